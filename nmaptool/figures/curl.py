"""A picture of where a normal map is not integrable."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.vectors import curl, inner_vertices, slopes
from nmaptool.types.inputs import NormalsLike, as_normal_map
from nmaptool.types.normal_map import NormalMap

# slope per px shown darkest and brightest; between them the scale is logarithmic
DARKEST, BRIGHTEST = 1e-3, 1.0
_UNDEFINED = (96, 96, 96)
_STEEPEST = 3.0


def curl_picture(normal_map: NormalsLike) -> NDArray[np.uint8]:
    """Show |curl| as a colour at each pixel: black where the map is integrable, through red to light yellow.

    Parameters
    ----------
    normal_map : NormalMap or (H, W, 3) float of any type

    Returns
    -------
    (H, W, 3) uint8
        sRGB, for display; grey where the map is not defined. On a logarithmic scale, black is a curl of 0.001 slope per
        px or less, and the lightest yellow a curl of 1 or more. A pixel shows the largest curl at its four corners.
        Slopes are capped at 3.

    Raises
    ------
    InputError, UsageError
        As for `nmaptool.NormalMap.from_array`, if the map is not a NormalMap.

    Examples
    --------
    >>> flat = np.zeros((2, 3, 3))
    >>> flat[..., 2] = 1
    >>> nm.curl_picture(flat).shape
    (2, 3, 3)
    """
    import cv2

    normal_map = as_normal_map(normal_map)
    codes = curl_codes(normal_map)
    picture: NDArray[np.uint8] = cv2.applyColorMap(codes, cv2.COLORMAP_INFERNO)[..., ::-1].copy()
    picture[normal_map.coverage < 0.5] = _UNDEFINED
    return picture


def curl_codes(normal_map: NormalMap) -> NDArray[np.uint8]:
    """Return |curl| at each pixel on the scale of `curl_picture`.

    Parameters
    ----------
    normal_map : NormalMap

    Returns
    -------
    (H, W) uint8
        0 where the map is integrable or not defined, 255 at a curl of 1 slope per px or more.
    """
    rows, cols = normal_map.frame.shape
    at_vertex = np.zeros((rows + 1, cols + 1), np.float32)
    if min(rows, cols) > 1:
        defined = normal_map.coverage >= 0.5
        size = np.abs(curl(*slopes(normal_map.normals, _STEEPEST)))
        at_vertex[1:-1, 1:-1] = np.where(inner_vertices(defined), size, 0)
    largest = np.maximum(at_vertex[:-1], at_vertex[1:])
    largest = np.maximum(largest[:, :-1], largest[:, 1:])
    share = np.log(np.maximum(largest, DARKEST) / DARKEST) / np.log(BRIGHTEST / DARKEST)
    return np.asarray(share.clip(0, 1) * 255 + 0.5, np.float32).astype(np.uint8)
