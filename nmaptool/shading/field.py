"""The surface that a picture shows: heights on the grid of its pixels, and how much of each pixel they cover."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from nmaptool.core.arrays import Float32, Float64, Mask
from nmaptool.core.grid import touching_vertices
from nmaptool.shading.outlines import enlarged_coverage, plate_coverage
from nmaptool.shading.resampling import resampled
from nmaptool.types.height import Height

_SMALLEST_LONGER_SIDE = 900
_LARGEST_LONGER_SIDE = 2000
# thickness of a plate whose base is not known, as a share of its longer side
_THIN = 0.04
_OPAQUE = 0.5


@dataclass(frozen=True, eq=False)
class Field:
    """Heights at the corners of a picture's pixels.

    Attributes
    ----------
    z_mm : (h+1, w+1) float32
        They continue smoothly outside the surface.
    coverage : (h, w) float32
        Share of each pixel that is surface, 0 to 1.
    pitch_mm : float
        Millimetres per pixel of the picture.
    back_mm : float
        Height of the back, on which the piece lies.
    """

    z_mm: Float32
    coverage: Float32
    pitch_mm: float
    back_mm: float

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of pixels."""
        rows, cols = self.coverage.shape
        return rows, cols

    @cached_property
    def is_whole(self) -> bool:
        """Whether the surface covers the whole picture."""
        return bool(self.coverage.min() >= 1)

    @cached_property
    def placed_mm(self) -> Float32:
        """(h+1, w+1) heights, at the back outside the surface."""
        if self.is_whole:
            return self.z_mm
        inside = _at_corners(self.coverage)
        return np.where(inside > _OPAQUE, self.z_mm, np.float32(self.back_mm))

    @cached_property
    def centers_mm(self) -> Float32:
        """(h, w) heights at the centres of the pixels."""
        return mean_of_corners(self.z_mm)


def mean_of_corners(values: Float32) -> Float32:
    """(h, w) means of the four corners of each pixel, from (h+1, w+1)."""
    across = values[:, :-1] + values[:, 1:]
    return np.float32(0.25) * (across[:-1] + across[1:])


def _at_corners(values: Float32) -> Float32:
    """(h+1, w+1) means of the pixels at each corner, from (h, w)."""
    return mean_of_corners(np.pad(values, 1, mode="edge"))


def picture_shape(rows: int, cols: int, size_px: int | None = None) -> tuple[int, int]:
    """Rows and columns of a preview.

    Small pictures are enlarged by a whole number to 900 px or more, those of more than 2000 px are reduced to it.

    Parameters
    ----------
    rows, cols : int
        Pixels of the height field.
    size_px : int, optional
        Longer side, instead.

    >>> picture_shape(200, 300), picture_shape(3000, 4000), picture_shape(20, 40, 512)
    ((600, 900), (1500, 2000), (256, 512))
    """
    longer = max(rows, cols)
    if size_px is None and longer <= _LARGEST_LONGER_SIDE:
        factor = max(1, -(-_SMALLEST_LONGER_SIDE // longer))
        return rows * factor, cols * factor
    size = _LARGEST_LONGER_SIDE if size_px is None else size_px
    return max(1, round(rows * size / longer)), max(1, round(cols * size / longer))


def field_of(
    height: Height, size_px: int | None = None, coverage: Float32 | None = None, base_mm: float | None = None
) -> Field:
    """Return the surface on the grid of a picture.

    Parameters
    ----------
    height : Height
    size_px : int, optional
        Longer side of the picture. Default: see `picture_shape`.
    coverage : (H, W) float32, optional
        Share of each pixel that is motif, where the outline is soft.
    base_mm : float, optional
        Thickness of the plate below its lowest point. Default: 4 % of its longer side.
    """
    rows, cols = height.frame.shape
    shape = picture_shape(rows, cols, size_px)
    pitch_mm = height.pitch_mm * max(rows, cols) / max(shape)
    raised = height.raised
    if raised is None or raised.all():
        z_mm = _on_grid(_continued(height.z_mm, height.vertex_mask), shape)
    else:
        motif = _on_grid(_continued(height.z_mm, touching_vertices(raised)), shape)
        z_mm = _on_grid(_continued(height.plate_mm(), touching_vertices(~raised)), shape)
        z_mm += _at_corners(enlarged_coverage(raised if coverage is None else coverage, shape)) * (motif - z_mm)
    covered = plate_coverage(height, shape, coverage)
    inside = z_mm[_at_corners(covered) > _OPAQUE]
    low = float(inside.min() if inside.size else z_mm.min())
    thick = _THIN * max(shape) * pitch_mm if base_mm is None else base_mm
    return Field(z_mm, covered, pitch_mm, low - thick)


def _continued(z_mm: Float64, known: Mask) -> Float64:
    """Heights continued from the nearest known vertex."""
    if known.all():
        return z_mm
    import cv2

    unknown = ~known
    _, labels = cv2.distanceTransformWithLabels(
        unknown.astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    # each known vertex has a label of its own, which the vertices nearest to it share
    by_label = np.zeros(int(labels.max()) + 1)
    by_label[labels[known]] = z_mm[known]
    out = z_mm.copy()
    out[unknown] = by_label[labels[unknown]]
    return out


def _on_grid(z_mm: Float64, shape: tuple[int, int]) -> Float32:
    """Heights at the corners of the picture's pixels."""
    import cv2

    values = z_mm.astype(np.float32)
    sides = [count - 1 for count in z_mm.shape]
    shrink = max(side / count for side, count in zip(sides, shape, strict=True))
    if shrink > 1:  # finer detail than the picture's pixels would alias
        values = cv2.GaussianBlur(values, (0, 0), 0.5 * shrink, borderType=cv2.BORDER_REFLECT_101)
    rows, cols = (np.linspace(0, side, count + 1) for side, count in zip(sides, shape, strict=True))
    return resampled(values, rows, cols)
