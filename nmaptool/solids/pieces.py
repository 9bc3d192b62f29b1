"""A shape in pieces: pixels that hang together by their sides."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from nmaptool.core.arrays import Mask
from nmaptool.core.grid import found_in
from nmaptool.solids.outline import Splits, find_splits
from nmaptool.solids.shape import Shape
from nmaptool.types.solid import Nodes


def pieces_of(shape: Shape) -> Iterator[tuple[Shape, int, int]]:
    """The pieces of a shape, each with the row and column of its upper left corner, from the top.

    Pixels that touch only at a corner belong to different pieces, unless they are connected elsewhere.
    """
    from scipy import ndimage  # takes long to load

    if shape.mask.all():
        yield shape, 0, 0
        return
    labels, _ = ndimage.label(shape.mask)
    for number, (rows, cols) in enumerate(ndimage.find_objects(labels), start=1):
        piece, _ = cropped(shape, labels[rows, cols] == number, rows.start, cols.start)
        yield piece, rows.start, cols.start


def cropped(shape: Shape, mask: Mask, top: int, left: int, within: Mask | None = None) -> tuple[Shape, Nodes]:
    """The piece of a shape that has its own mask, moved to its own corner, and which of the moved nodes it has.

    Moved nodes belong to it if they touch its pixels, or those of ``within``.
    """
    splits = find_splits(mask)
    moved, by_px = shape.moved, shape.by_px
    row, col = np.divmod(shape.vertex_of(moved), shape.mask.shape[1] + 1)
    row, col = row - top, col - left
    local, kept = _local_nodes(shape.splits, splits, mask if within is None else within, moved, row, col)
    at = np.flatnonzero(kept)
    at = at[np.argsort(local[at])]
    forced_row, forced_col = np.divmod(shape.forced, shape.mask.shape[1])
    forced_row, forced_col = forced_row - top, forced_col - left
    own = _at(mask, forced_row, forced_col)
    forced = forced_row[own] * mask.shape[1] + forced_col[own]
    piece = Shape(mask, splits, local[at], by_px[at], forced, shape.forced_falls[own], shape.keeps_heights)
    return piece, at


def _local_nodes(whole: Splits, own: Splits, mask: Mask, nodes: Nodes, row: Nodes, col: Nodes) -> tuple[Nodes, Mask]:
    """Node numbers in a piece of nodes of the whole at a row and column of the piece, and whether they belong to it."""
    vertex = row * (mask.shape[1] + 1) + col
    is_second = nodes >= whole.first
    at = np.where(is_second, nodes - whole.first, found_in(whole.vertices, nodes))
    touches = np.zeros(len(nodes), bool)
    for down, right in ((-1, -1), (-1, 0), (0, -1), (0, 0)):
        touches |= _at(mask, row + down, col + right)
    if not len(whole.vertices):
        return vertex, touches
    is_split = at >= 0
    leans_right = whole.lower_is_right[at]
    lower = _at(mask, row, np.where(leans_right, col, col - 1))
    upper = _at(mask, row - 1, np.where(leans_right, col - 1, col))
    kept = np.where(is_split, np.where(is_second, lower, upper), touches)
    seconds = found_in(own.vertices, vertex)
    return np.where(is_second & upper & lower & (seconds >= 0), own.first + seconds, vertex), kept


def _at(mask: Mask, row: Nodes, col: Nodes) -> Mask:
    """The mask at places that may lie outside of it."""
    inside = (row >= 0) & (row < mask.shape[0]) & (col >= 0) & (col < mask.shape[1])
    found: Mask = np.zeros(len(row), bool)
    found[inside] = mask[row[inside], col[inside]]
    return found
