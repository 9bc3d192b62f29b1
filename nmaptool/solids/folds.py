"""Moved nodes without folds: every pixel around them keeps two triangles of fair size."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.grid import found_in, touching_vertices
from nmaptool.solids.outline import CORNERS, corner_nodes, find_splits
from nmaptool.solids.shape import Shape
from nmaptool.types.solid import Nodes

# triangles smaller than this are avoided, where a whole one has 0.5
_SMALLEST_AREA_PX = 0.04
_SMALL_AREA_PX = 0.2


def without_folds(shape: Shape, is_fixed: Mask) -> Shape:
    """Take back moves until every pixel around moved nodes can be split into two triangles of fair size.

    Parameters
    ----------
    shape : Shape
    is_fixed : (n,) bool
        Moved nodes whose moves stay.

    Returns
    -------
    Shape
        With the moves that are left, and the diagonals of pixels that only one diagonal splits well.
    """
    by_px = shape.by_px.copy()
    pixels = _Quads.around(shape)
    for attempt in range(8):
        falling, rising = pixels.smallest_areas(by_px)
        bad = np.maximum(falling, rising) < _SMALLEST_AREA_PX
        if not bad.any():
            break
        touched = np.unique(pixels.moved_corners[bad])
        touched = touched[touched >= 0]
        touched = touched[~is_fixed[touched]]
        by_px[touched] *= 0.5 if attempt < 6 else 0.0
    falling, rising = pixels.smallest_areas(by_px)
    forced = (np.minimum(falling, rising) < _SMALL_AREA_PX) & (falling != rising)
    where, falls = pixels.numbers[forced], (falling > rising)[forced]
    order = np.argsort(where)
    return Shape(shape.mask, shape.splits, shape.moved, by_px, where[order], falls[order])


def moved_within(shape: Shape, inner: Mask, fixed: Nodes) -> Shape:
    """The moves of the nodes that have pixels of a mask on all sides.

    Parameters
    ----------
    shape : Shape
        Without split vertices.
    inner : (H, W) bool
        Pixels that touch only at sides.
    fixed : (k,) int64
        Moved nodes whose moves stay.

    Returns
    -------
    Shape
        Of the mask; its moved nodes keep the heights of their vertices.
    """
    outside = touching_vertices(np.pad(~inner, 1, constant_values=True))[1:-1, 1:-1]
    kept = ~outside.ravel()[shape.moved]
    within = Shape(inner, find_splits(inner), shape.moved[kept], shape.by_px[kept])
    within = without_folds(within, np.isin(within.moved, fixed))
    return replace(within, keeps_heights=True)


@dataclass(frozen=True, eq=False)
class _Quads:
    """Pixels with a moved corner: their numbers, whether they are in the mask, corners on the grid and their moves.

    Corners are in the order nw, sw, se, ne; ``moved_corners`` are rows of the moves, -1 where a corner is not moved.
    """

    numbers: Nodes
    is_inside: Mask
    grid_px: Float64
    moved_corners: Nodes

    @classmethod
    def around(cls, shape: Shape) -> _Quads:
        rows, cols = shape.mask.shape
        row, col = np.divmod(shape.vertex_of(shape.moved), cols + 1)
        around = []
        for down, right in CORNERS.values():
            r, c = row - down, col - right
            inside = (r >= 0) & (r < rows) & (c >= 0) & (c < cols)
            around.append((r * cols + c)[inside])
        numbers = np.unique(np.concatenate(around))
        r, c = np.divmod(numbers, cols)
        inside = shape.mask[r, c]
        grid = np.stack([np.column_stack([c + right, r + down]) for down, right in CORNERS.values()], axis=1)
        moved = np.empty((len(numbers), 4), np.int64)
        for number, corner in enumerate(CORNERS):
            down, right = CORNERS[corner]
            plain = (r + down) * (cols + 1) + c + right
            nodes = np.where(inside, corner_nodes(r, c, cols, shape.splits, corner), plain)
            moved[:, number] = found_in(shape.moved, nodes)
        return cls(numbers, inside, grid.astype(np.float64), moved)

    def smallest_areas(self, by_px: Float64) -> tuple[Float64, Float64]:
        """The smaller triangle's area along the falling and along the rising diagonal of each pixel."""
        moves = np.concatenate([by_px, np.zeros((1, 2))])[self.moved_corners]
        nw, sw, se, ne = np.moveaxis(self.grid_px + moves, 1, 0)
        falling = np.minimum(_area(nw, sw, se), _area(nw, se, ne))
        rising = np.minimum(_area(nw, sw, ne), _area(sw, se, ne))
        return falling, rising


def _area(a: Float64, b: Float64, c: Float64) -> Float64:
    """Area of triangles that run counter-clockwise on the screen, y down."""
    area: Float64 = ((c - a)[:, 0] * (b - a)[:, 1] - (c - a)[:, 1] * (b - a)[:, 0]) / 2
    return area
