"""Interpolate normals and their coverage: sharp on smooth surfaces, without ringing along edges and jumps."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Float64
from nmaptool.core.vectors import FLAT, unit

_LEAST_COVERAGE = 1 / 512
_RINGING = 0.04


def interpolated(
    mixed: Float32, inside: NDArray[np.uint8], centred: Float64, size: tuple[int, int], box: NDArray[Any] | None
) -> tuple[Float32, Float32]:
    """Return unit normals, not yet transformed, and coverage from (h, w, 4) vectors times coverage and coverage.

    If a (left, top, right, bottom) box is given, the edge of the picture is hard and is the edge of the box.
    """
    import cv2

    def warp(array: NDArray[Any], how: int) -> NDArray[Any]:
        out: NDArray[Any] = cv2.warpAffine(array, centred, size, flags=how, borderMode=border(box))
        if box is not None:
            x0, y0, x1, y1 = box.clip(0)
            out[:y0] = out[y1:] = 0
            out[:, :x0] = out[:, x1:] = 0
        return out

    vectors = warp(mixed, cv2.INTER_LINEAR)
    coverage = vectors[..., 3].clip(0, 1)
    smooth = warp(inside, cv2.INTER_NEAREST).astype(bool)
    if smooth.any():
        sharp = warp(mixed, cv2.INTER_LANCZOS4)
        # next to jumps within the map, the sharper interpolation would ring
        for off in cv2.split(cv2.absdiff(sharp, vectors)):
            smooth &= off < _RINGING
        np.copyto(vectors, sharp, where=smooth[..., None])
        coverage[smooth] = 1
    coverage[coverage < _LEAST_COVERAGE] = 0
    normals = unit(vectors[..., :3])
    normals[coverage == 0] = FLAT
    return normals, coverage


def border(box: NDArray[Any] | None) -> int:
    """Return OpenCV's border mode: a hard edge is replicated beyond the picture, so it does not fade."""
    import cv2

    return cv2.BORDER_CONSTANT if box is None else cv2.BORDER_REPLICATE
