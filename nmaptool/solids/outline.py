"""The outline of a mask of pixels: its edges, its nodes, and corners where two pixels touch."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from nmaptool.core.arrays import Mask
from nmaptool.core.grid import found_in, places, touching_corners
from nmaptool.types.solid import Nodes

# corners of a pixel, counter-clockwise seen from the viewer: row and column offsets from its upper left corner
CORNERS = {"nw": (0, 0), "sw": (1, 0), "se": (1, 1), "ne": (0, 1)}
# side of a pixel: offset of the pixel across, then the first and last corner of the edge
_SIDES = (((0, -1), "nw", "sw"), ((1, 0), "sw", "se"), ((0, 1), "se", "ne"), ((-1, 0), "ne", "nw"))


@dataclass(frozen=True, eq=False)
class Splits:
    """Vertices that are split, because two pixels of the mask touch there at a corner only.

    The pixel above keeps the vertex, the pixel below gets a second one. The surface is a manifold this way.

    Attributes
    ----------
    vertices : (k,) int64
        Numbers of the vertices on the grid, ascending.
    lower_is_right : (k,) bool
        Whether the pixel below lies to the right of the vertex.
    first : int
        Node number of the first second vertex.
    """

    vertices: Nodes
    lower_is_right: Mask
    first: int

    def applied(self, nodes: Nodes, corner: str) -> Nodes:
        """Node numbers of that corner of some pixels, with the second vertices where they have one."""
        if not len(self.vertices) or corner not in ("nw", "ne"):
            return nodes
        at = found_in(self.vertices, nodes)
        # the lower right pixel meets the vertex with its upper left corner
        split = (at >= 0) & (self.lower_is_right[at] == (corner == "nw"))
        return np.where(split, self.first + at, nodes)


def find_splits(mask: Mask) -> Splits:
    """The vertices at which two pixels of a mask touch at a corner only.

    Parameters
    ----------
    mask : (H, W) bool

    Returns
    -------
    Splits
    """
    rows, cols = mask.shape
    falling, rising = touching_corners(mask)
    row, col = places(falling | rising)
    return Splits((row + 1) * (cols + 1) + col + 1, falling[row, col], (rows + 1) * (cols + 1))


@dataclass(frozen=True, eq=False)
class OutlineEdges:
    """The edges between pixels of a mask and the outside, with the mask to the left.

    Attributes
    ----------
    start, end : (n,) int64
        Nodes.
    rows, cols : (n,) int64
        The pixel of the mask at each edge.
    """

    start: Nodes
    end: Nodes
    rows: Nodes
    cols: Nodes

    def chosen(self, which: Mask) -> OutlineEdges:
        """Some of the edges."""
        return OutlineEdges(self.start[which], self.end[which], self.rows[which], self.cols[which])

    def joined(self, other: OutlineEdges) -> OutlineEdges:
        """These edges and others."""
        names = ("start", "end", "rows", "cols")
        return OutlineEdges(*(np.concatenate([getattr(self, name), getattr(other, name)]) for name in names))


def outline_edges(mask: Mask, splits: Splits) -> OutlineEdges:
    """The directed edges of the outline of a mask; each of its nodes starts one edge and ends one.

    Parameters
    ----------
    mask : (H, W) bool
    splits : Splits

    Returns
    -------
    OutlineEdges
    """
    height, width = mask.shape
    padded = np.pad(mask, 1)
    found = []
    for (down, right), first, last in _SIDES:
        across = padded[1 + down : 1 + down + height, 1 + right : 1 + right + width]
        row, col = places(mask & ~across)
        ends = [corner_nodes(row, col, width, splits, corner) for corner in (first, last)]
        found.append((*ends, row, col))
    start, end, rows, cols = (np.concatenate(each) for each in zip(*found, strict=True))
    return OutlineEdges(start, end, rows, cols)


def corner_nodes(row: Nodes, col: Nodes, width: int, splits: Splits, corner: str) -> Nodes:
    """Node of that corner of each pixel."""
    down, right = CORNERS[corner]
    return splits.applied((row + down) * (width + 1) + col + right, corner)


def merged_edges(edges: OutlineEdges, active: Mask) -> OutlineEdges:
    """The same outline through fewer nodes.

    Parameters
    ----------
    edges : OutlineEdges
        Of single pixels.
    active : (H+1, W+1) bool
        The vertices that stay, with all corners of the outline among them. Second nodes of split vertices stay.

    Returns
    -------
    OutlineEdges
        Each with the pixel at its start.
    """
    stays = active.ravel()

    def is_left_out(nodes: Nodes) -> Mask:
        out: Mask = (nodes < stays.size) & ~stays[np.minimum(nodes, stays.size - 1)]
        return out

    order = np.argsort(edges.start)
    starts = edges.start[order]
    end = edges.end.copy()
    open_ends = np.flatnonzero(is_left_out(end))
    while len(open_ends):
        # each edge reaches as far as the edge at its end does
        end[open_ends] = end[order[np.searchsorted(starts, end[open_ends])]]
        open_ends = open_ends[is_left_out(end[open_ends])]
    return replace(edges, end=end).chosen(~is_left_out(edges.start))
