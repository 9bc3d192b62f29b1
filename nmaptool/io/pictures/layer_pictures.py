"""Make pictures of the layers of a set: normals, coverage, depth, face numbers."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np

from nmaptool._version import __version__
from nmaptool.core.errors import LimitError, UsageError
from nmaptool.io.pictures.normal_maps import normal_picture
from nmaptool.io.pictures.writer import Picture
from nmaptool.maps.codec import grey_codes
from nmaptool.types.layer_set import LayerSet

NORMAL_LAYERS = ("original", "base", "detail")
_MOST_EXACT = 1 << 24  # float32 and three bytes hold all whole numbers below this


def layer_picture(layers: LayerSet, name: str, floating: bool) -> Picture:
    """Return the picture of a layer, with its metadata; ``floating`` selects floats instead of codes."""
    shared = {"version": __version__, "layer": name, "recipe": json.dumps(dict(layers.report.options))}
    if layers.report.view:
        shared["view"] = layers.report.view
    if layers.frame.pitch_mm is not None:
        shared["pitch_mm"] = repr(layers.frame.pitch_mm)
    if name in NORMAL_LAYERS:
        picture = normal_picture(getattr(layers, name), 32 if floating else 16, name=name)
    elif name == "coverage":
        grey = layers.coverage if floating else grey_codes(layers.coverage, 16)
        picture = Picture(grey[..., None], ("Y",), {"kind": "coverage"}, name)
    elif name == "depth":
        picture = _depth(layers, floating)
    else:
        picture = _faces(layers, floating)
    return replace(picture, attributes={**picture.attributes, **shared})


def _depth(layers: LayerSet, floating: bool) -> Picture:
    if layers.depth_mm is None:
        raise UsageError("`depth`: these layers have no depth; only layers of a mesh do")
    seen = layers.coverage > 0
    near, far = float(layers.depth_mm[seen].min()), float(layers.depth_mm[seen].max())
    facts = {"kind": "depth", "near_mm": repr(near), "far_mm": repr(far)}
    if floating:
        return Picture(np.dstack([layers.depth_mm, seen.astype(np.float32)]), ("Z", "A"), facts, "depth")
    behind = (layers.depth_mm - near).clip(0) / max(far - near, 1e-30)
    shade = np.where(seen, 1 - behind, 0).clip(0, 1).astype(np.float32)
    codes = np.dstack([grey_codes(shade, 16), grey_codes(seen.astype(np.float32), 16)])
    return Picture(codes, ("Y", "A"), facts, "depth")


def _faces(layers: LayerSet, floating: bool) -> Picture:
    if layers.faces is None:
        raise UsageError("`faces`: these layers have no face numbers; only layers of a mesh do")
    if int(layers.faces.max()) + 1 >= _MOST_EXACT:
        raise LimitError(
            f"`faces`: a mesh of more than {_MOST_EXACT} faces has numbers too large for a picture; leave `faces` out"
        )
    facts = {"kind": "faces"}
    if floating:
        return Picture(layers.faces.astype(np.float32)[..., None], ("Y",), facts, "faces")
    number = (layers.faces + 1).astype(np.uint32)
    return Picture(np.dstack([number >> s & 255 for s in (0, 8, 16)]).astype(np.uint8), ("R", "G", "B"), facts, "faces")
