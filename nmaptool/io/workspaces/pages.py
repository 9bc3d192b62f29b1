"""What layered TIFF and EXR files share: pictures with a name and a place, each with nmaptool's metadata."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool._version import __version__
from nmaptool.io.workspaces import metadata as metadata
from nmaptool.types.picture import RasterImage, largest_code
from nmaptool.types.workspace import MASK_SUFFIX, Workspace, WorkspaceGroup, WorkspaceLayer, WorkspaceMask

FURTHEST = 300_000


@dataclass(frozen=True, eq=False)
class Page:
    """One page or part of a file.

    Parameters
    ----------
    name : str
    image : RasterImage
    left, top : int
        Place that the format itself states.
    """

    name: str
    image: RasterImage
    left: int = 0
    top: int = 0


def page_attributes(workspace: Workspace, number: int, *, mask: bool = False) -> dict[str, str]:
    """Return the metadata of the page of a layer or of its mask: those of every nmaptool map, and the layer's own."""
    layer = workspace.layers[number]
    frame = workspace.frame
    said: dict[str, Any] = {"names": [one.name for one in workspace.layers], "canvas": [frame.cols, frame.rows]}
    if frame.pitch_mm is not None:
        said["pitch_mm"] = frame.pitch_mm
    if not number and not mask and workspace.metadata is not None:  # some editors keep only one description
        said["workspace"] = dict(workspace.metadata)
    if mask:
        assert layer.mask is not None
        place = {"mask_of": layer.name, "left": layer.mask.left, "top": layer.mask.top}
        said.update(place, outside=layer.mask.outside, enabled=layer.mask.enabled)
        return {"version": __version__, "kind": "mask", "words": metadata.to_json(said)}
    ids: dict[int, int] = {}
    for one in workspace.layers:
        for group in one.groups:
            ids.setdefault(id(group), len(ids))
    groups = [[ids[id(g)], g.name, g.visible, g.opacity, g.blend_mode] for g in layer.groups]
    said.update(left=layer.left, top=layer.top, visible=layer.visible, opacity=layer.opacity)
    said.update(blend_mode=layer.blend_mode, groups=groups, facts=dict(layer.facts))
    plain = {"version": __version__, "kind": "normal", "green": "up", "layer": layer.name}
    plain |= {"encoding": "signed"} if layer.signed else {"zero_code": "127.5"}
    if frame.pitch_mm is not None:
        plain["pitch_mm"] = repr(frame.pitch_mm)
    return {**plain, "words": metadata.to_json(said)}


def page_metadata(image: RasterImage) -> dict[str, Any]:
    """Return nmaptool's metadata of a page, empty if an editor dropped them."""
    return metadata.from_json(image.attributes.get("words", "")) or {}


def layers_of(pages: Sequence[Page]) -> tuple[tuple[WorkspaceLayer, ...], dict[str, Any] | None, list[tuple[str, str]]]:
    """Return layers bottom to top, the metadata of the workspace, and the masks whose layer is gone."""
    masks: dict[str, WorkspaceMask] = {}
    kept: list[tuple[Page, dict[str, Any]]] = []
    all_metadata = [page_metadata(page.image) for page in pages]
    owners = {page.name for page, said in zip(pages, all_metadata, strict=True) if "mask_of" not in said}
    for page, said in zip(pages, all_metadata, strict=True):
        owner = said.get("mask_of", page.name.removesuffix(MASK_SUFFIX))
        grey = len(page.image.channels) < 3
        if "mask_of" in said and isinstance(owner, str) and (grey or owner in owners):
            masks[owner] = _mask(page, said)
        elif "mask_of" not in said and owner != page.name and grey:
            masks[owner] = _mask(page, {})
        else:  # a picture that only inherited a mask's metadata is not a mask
            kept.append((page, {} if "mask_of" in said else said))
    groups: dict[int, WorkspaceGroup] = {}
    layers = tuple(_layer(page, said, masks, groups) for page, said in kept)
    orphans = [(name + MASK_SUFFIX, "mask without its layer") for name in masks]
    return layers, _metadata([said for _, said in kept]), orphans


def _metadata(said: list[dict[str, Any]]) -> dict[str, Any] | None:
    """Join the metadata of all layers; of layers that are gone only the name is left."""
    whole = next((one["workspace"] for one in said if isinstance(one.get("workspace"), dict)), None)
    if whole is not None:
        return dict(whole)
    first = next((one for one in said if isinstance(one.get("names"), list)), None)
    if first is None:
        return None
    facts = {one["facts"]["name"]: one["facts"] for one in said if _has_name(one.get("facts"))}
    names = [name for name in first["names"] if isinstance(name, str)]
    found = {"layers": [facts.get(name, {"name": name}) for name in names], "canvas": first.get("canvas")}
    return {**found, "pitch_mm": metadata.pitch_in(first)}


def _has_name(facts: object) -> bool:
    return isinstance(facts, dict) and isinstance(facts.get("name"), str)


def _place(page: Page, said: Mapping[str, Any]) -> tuple[int, int]:
    return _exact(page.left, said.get("left")), _exact(page.top, said.get("top"))


def _exact(own: int, said: object) -> int:
    """The place from nmaptool's metadata, or the format's own (not negative in TIFF) if an editor moved the layer."""
    if isinstance(said, int) and not isinstance(said, bool) and abs(said) <= FURTHEST and own in (said, max(said, 0)):
        return said
    return min(max(own, -FURTHEST), FURTHEST)


def _share(value: object, default: float = 1.0) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value <= 1:
        return default
    return float(value)


def _layer(
    page: Page, said: dict[str, Any], masks: dict[str, WorkspaceMask], groups: dict[int, WorkspaceGroup]
) -> WorkspaceLayer:
    pixels = four_channels(page.image)
    facts = said["facts"] if _has_name(said.get("facts")) else {}
    left, top = _place(page, said)
    mode = said.get("blend_mode")
    signed = page.image.attributes.get("encoding") == "signed"
    return WorkspaceLayer(
        name=page.name,
        pixels=pixels,
        left=left,
        top=top,
        visible=said.get("visible") is not False,
        opacity=_share(said.get("opacity")),
        blend_mode=mode if isinstance(mode, str) and mode else "normal",
        mask=masks.pop(page.name, None) or masks.pop(str(facts.get("name", page.name)), None),
        groups=_groups(said.get("groups"), groups),
        facts=facts,
        signed=signed and pixels.dtype == np.float32,
    )


def _groups(value: object, known: dict[int, WorkspaceGroup]) -> tuple[WorkspaceGroup, ...]:
    found = []
    for one in value if isinstance(value, list) else []:
        if not (isinstance(one, list) and len(one) == 5 and isinstance(one[0], int) and isinstance(one[1], str)):
            return ()
        mode = one[4] if isinstance(one[4], str) else "normal"
        found.append(known.setdefault(one[0], WorkspaceGroup(one[1], one[2] is not False, _share(one[3]), mode)))
    return tuple(found)


def _mask(page: Page, said: Mapping[str, Any]) -> WorkspaceMask:
    left, top = _place(page, said)
    return WorkspaceMask(
        grey_channel(page.image), left, top, _share(said.get("outside"), 0.0), said.get("enabled") is not False
    )


def masks_joined(layers: Sequence[WorkspaceLayer]) -> list[WorkspaceLayer]:
    """Return layers bottom to top; a hidden grey one called ``NAME [mask]`` becomes the mask of the layer ``NAME``.

    This keeps masks when an editor converts a format without masks to one that has them.
    """
    bare = {layer.name for layer in layers if layer.mask is None}
    found: dict[str, WorkspaceMask] = {}
    for layer in layers:
        owner = layer.name.removesuffix(MASK_SUFFIX)
        red, green, blue, alpha = (layer.pixels[..., i] for i in range(4))
        grey = np.array_equal(red, green) and np.array_equal(red, blue)
        if owner != layer.name and owner in bare and not layer.visible and grey:
            found[owner] = WorkspaceMask(_grey(red, alpha), layer.left, layer.top)
    joined = {owner + MASK_SUFFIX for owner in found}
    kept = [layer for layer in layers if layer.name not in joined]
    return [replace(layer, mask=found.get(layer.name, layer.mask)) for layer in kept]


def four_channels(image: RasterImage) -> NDArray[Any]:
    """Return the R, G, B, A of a layer, (H, W, 4); grey is repeated three times, and without alpha all is opaque."""
    names, pixels = image.channels, image.pixels
    color = [names.index(c) for c in "RGB"] if {"R", "G", "B"} <= set(names) else [0, 0, 0]
    top = largest_code(pixels)
    alpha = pixels[..., names.index("A")] if "A" in names else np.full(pixels.shape[:2], top, pixels.dtype)
    return np.dstack([pixels[..., color], alpha])


def grey_channel(image: RasterImage) -> NDArray[Any]:
    """Return a mask as an editor may have saved it: grey, times alpha if it has one."""
    grey = image.pixels[..., 0]
    if "A" not in image.channels:
        return np.ascontiguousarray(grey)
    return _grey(grey, image.pixels[..., image.channels.index("A")])


def _grey(grey: NDArray[Any], alpha: NDArray[Any]) -> NDArray[Any]:
    both: NDArray[Any] = grey.astype(np.float64) * alpha / largest_code(grey)
    return both.astype(np.float32) if grey.dtype == np.float32 else np.rint(both).astype(grey.dtype)
