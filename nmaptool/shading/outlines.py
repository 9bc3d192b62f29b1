"""How much of each pixel of a picture a plate or a motif covers."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32
from nmaptool.types.contours import Contours
from nmaptool.types.height import Height

# samples across a pixel of an exact outline
_SAMPLES = 4
# fractional bits of the corners of a polygon
_SHIFT = 6
# blur, in pixels of the height field, that rounds the steps of an outline of pixels, and of a soft one
_ROUNDED_PX, _SOFT_PX = 1.2, 0.6


def plate_coverage(height: Height, shape: tuple[int, int], coverage: Float32 | None = None) -> Float32:
    """Share of each pixel of a picture inside the surface of a height field.

    Parameters
    ----------
    height : Height
        Its exact outline is used, if it has one.
    shape : tuple of int
        Rows and columns of the picture.
    coverage : (H, W) float32, optional
        Share of each pixel of the height field that is motif: the surface, unless that is the whole picture.

    Returns
    -------
    (h, w) float32
        0 to 1.
    """
    if height.outline is not None:
        return contour_coverage(height.outline, height.frame.rows * height.pitch_mm, height.pitch_mm, height, shape)
    if height.domain.all():
        return np.ones(shape, np.float32)
    return enlarged_coverage(height.domain if coverage is None else coverage, shape)


def contour_coverage(
    outline: Contours, rows_mm: float, pitch_mm: float, height: Height, shape: tuple[int, int]
) -> Float32:
    """As `plate_coverage`, from closed curves."""
    rows, cols = shape
    scale_x = cols * _SAMPLES / (height.frame.cols * pitch_mm)
    scale_y = rows * _SAMPLES / rows_mm
    # the centre of a sample is a whole number for the rasteriser
    corners = [
        np.column_stack([ring[:, 0] * scale_x, (rows_mm - ring[:, 1]) * scale_y]) - 0.5 for ring in outline.rings
    ]
    fixed = [np.round(ring * (1 << _SHIFT)).astype(np.int32) for ring in corners]
    # the samples on the curve belong to both the inside and the outside
    right, bottom = (side * _SAMPLES << _SHIFT for side in (cols, rows))
    frame = np.array([[-right, -bottom], [2 * right, -bottom], [2 * right, 2 * bottom], [-right, 2 * bottom]], np.int32)
    inside, outside = (_filled(curves, rows, cols) for curves in (fixed, [frame, *fixed]))
    return np.asarray((1 + inside - outside) / 2, np.float32)


def _filled(curves: list[NDArray[np.int32]], rows: int, cols: int) -> Float32:
    """Share of the samples of each pixel between closed curves, or on them."""
    import cv2

    canvas = np.zeros((rows * _SAMPLES, cols * _SAMPLES), np.uint8)
    cv2.fillPoly(canvas, curves, 255, lineType=cv2.LINE_8, shift=_SHIFT)
    small: NDArray[Any] = cv2.resize(canvas, (cols, rows), interpolation=cv2.INTER_AREA)
    return small.astype(np.float32) / np.float32(255)


def enlarged_coverage(coverage: NDArray[Any], shape: tuple[int, int]) -> Float32:
    """Coverage of a mask or of a soft outline on the grid of a picture, with a smooth edge one pixel wide.

    Parameters
    ----------
    coverage : (H, W) bool or float32
    shape : tuple of int
        Rows and columns of the picture.

    Returns
    -------
    (h, w) float32
        0 to 1.
    """
    import cv2

    rows, cols = shape
    factor = max(rows / coverage.shape[0], cols / coverage.shape[1])
    values: NDArray[Any] = coverage.astype(np.float32)
    hard = coverage.dtype == np.bool_
    if factor <= 1 and not hard:
        return np.asarray(cv2.resize(values, (cols, rows), interpolation=cv2.INTER_AREA), np.float32).clip(0, 1)
    sigma = _ROUNDED_PX if hard else _SOFT_PX
    way = cv2.INTER_AREA if factor <= 1 else cv2.INTER_CUBIC
    smooth = cv2.GaussianBlur(values, (0, 0), sigma, borderType=cv2.BORDER_REPLICATE)
    smooth = cv2.resize(smooth, (cols, rows), interpolation=way)
    # the blur spreads the edge over this many pixels of the picture
    wide = max(1.0, factor * sigma * math.sqrt(math.tau))
    out = ((smooth - np.float32(0.5)) * np.float32(wide) + np.float32(0.5)).clip(0, 1)
    if hard:  # what is too thin for the blur keeps its pixels
        wide_parts = cv2.morphologyEx(values, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
        thin = cv2.resize(values - wide_parts, (cols, rows), interpolation=min(way, cv2.INTER_AREA))
        out = np.maximum(out, thin.clip(0, 1) if (values > wide_parts).any() else 0)
    return np.asarray(out, np.float32)
