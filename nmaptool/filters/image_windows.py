"""Rolling guidance on windows of a large normal map, pass by pass: each pass needs the one before it in a margin."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from nmaptool.core.arrays import Float32
from nmaptool.filters.image import (
    BLUR_REACH,
    CELL_PER_SIGMA,
    SIGMA_R,
    SIGMA_S_PX,
    Cell,
    FilterCanvas,
    Meter,
    cells_of,
    next_guide,
)

Box = tuple[slice, slice]


@dataclass(frozen=True)
class WindowFilter:
    """The filter of `nmaptool.filters.image.rolling_guidance_image`, for windows.

    Parameters
    ----------
    sigma_s_px, sigma_r : float
        As there.
    shape : (int, int)
        Rows and columns of the box around all covered pixels of the map, on which the cells depend.
    """

    sigma_s_px: float
    sigma_r: float
    shape: tuple[int, int]

    @property
    def sigma(self) -> float:
        """The spatial sigma in use."""
        return min(max(self.sigma_s_px, SIGMA_S_PX[0]), SIGMA_S_PX[1])

    @property
    def border(self) -> int:
        """Pixels around the map in which the guide is computed, too: centres of cells may lie there."""
        return border_px(self.sigma_s_px)

    @property
    def blur_margin(self) -> int:
        """Pixels around a window that the first pass depends on."""
        return math.ceil(BLUR_REACH * self.sigma)

    @cached_property
    def cells(self) -> list[Cell]:
        """The cells around each pixel."""
        return cells_of(self.sigma, self.shape)

    @property
    def margin(self) -> int:
        """Pixels around a window that each further pass depends on: the farthest cell, and half its width."""
        return int(max(max(abs(cell.dy), abs(cell.dx)) + 3**cell.level // 2 for cell in self.cells))

    @property
    def bytes_per_pixel(self) -> int:
        """Memory of a pass for each pixel of a window with its margin."""
        return 12 * (6 + max(cell.level for cell in self.cells)) + 24

    def first(self, vectors: Float32, own: Box) -> Float32:
        """Blur: the first pass.

        Parameters
        ----------
        vectors : (h, w, 3) float32
            Normals times coverage of the motif in a window with `blur_margin`; 0 outside the map.
        own : (slice, slice)
            The part to return.

        Returns
        -------
        (rows, cols, 3) float32
            Unit vectors, or 0 where nothing is near.
        """
        canvas = FilterCanvas(vectors, [Cell(0, 0, 0, 0.0)])
        guide = canvas.directions(canvas.blurred(self.sigma), slice(None))
        return _part(canvas, guide, own)

    def following(self, vectors: Float32, guide: Float32, own: Box) -> Float32:
        """Average under the guide of the pass before.

        Parameters
        ----------
        vectors, guide : (h, w, 3) float32
            As for `first`, and its result, in a window with `margin`.
        own : (slice, slice)
            The part to return.

        Returns
        -------
        (rows, cols, 3) float32
        """
        canvas = FilterCanvas(vectors, self.cells)
        sigma_r = min(max(self.sigma_r, SIGMA_R[0]), SIGMA_R[1])
        scaled = canvas.empty()
        scaled.reshape(canvas.shape)[canvas.picture] = np.moveaxis(guide, -1, 0) * np.float32(math.sqrt(0.5) / sigma_r)
        top = canvas.picture[1].start
        rows = canvas.batches_of(top + own[0].start, top + own[0].stop)
        return _part(canvas, next_guide(canvas, scaled, self.cells, Meter(None, 1), rows), own)


def border_px(sigma_s_px: float) -> int:
    """Half the width of the largest cell."""
    sigma = min(max(sigma_s_px, SIGMA_S_PX[0]), SIGMA_S_PX[1])
    level = 0
    while 3 ** (level + 1) <= CELL_PER_SIGMA * sigma:
        level += 1
    return int(3**level // 2)


def _part(canvas: FilterCanvas, planes: Float32, own: Box) -> Float32:
    picture = planes.reshape(canvas.shape)[canvas.picture]
    return np.ascontiguousarray(np.moveaxis(picture[(slice(None), *own)], 0, -1))
