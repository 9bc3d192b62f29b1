"""Pictures that are written beside a normal map."""

from __future__ import annotations

import numpy as np

from nmaptool._version import __version__
from nmaptool.core.arrays import Float32
from nmaptool.figures.curl import BRIGHTEST, DARKEST, curl_picture
from nmaptool.io.pictures.writer import Picture
from nmaptool.maps.codec import grey_codes
from nmaptool.types.normal_map import NormalMap


def curl_image(normal_map: NormalMap) -> Picture:
    """Return `nmaptool.curl_picture` with its scale in the metadata."""
    scale = {"black": repr(DARKEST), "white": repr(BRIGHTEST), "unit": "slope per px"}
    return Picture(curl_picture(normal_map), ("R", "G", "B"), {"kind": "curl", "version": __version__, **scale})


def mask_picture(mask: Float32) -> Picture:
    """Return a mask, (H, W) float32 in 0..1, as a 16-bit grey picture."""
    return Picture(grey_codes(mask, 16)[..., None], ("Y",), {"kind": "mask", "version": __version__})


def jumps_picture(jumps: Float32) -> Picture:
    """Return the jumps in a depth picture: black is no jump, white the highest; its height in px is in the metadata."""
    highest = float(jumps.max())
    grey = grey_codes(jumps / np.float32(highest or 1), 16)[..., None]
    facts = {"kind": "jumps", "version": __version__, "black": "0", "white": repr(highest), "unit": "px"}
    return Picture(grey, ("Y",), facts)
