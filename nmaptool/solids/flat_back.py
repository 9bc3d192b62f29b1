"""A flat back of few triangles: rectangles away from the outline's moved nodes, pixels beside them."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.grid import places
from nmaptool.solids.outline import OutlineEdges, outline_edges
from nmaptool.solids.shape import Shape
from nmaptool.solids.sheet import Placing, Sheet
from nmaptool.types.solid import Faces, Nodes, Part

_BAND_FACES = 1 << 18


@dataclass(frozen=True, eq=False)
class Rectangles:
    """A mask as rectangles: rows of pixels with the same ends, joined.

    Attributes
    ----------
    left, right, top, bottom : (n,) int64
        In px; right and bottom are one more than the last column and row.
    run_starts, run_rectangles : (m,) int64
        ``row * W + column`` of the first pixel of each run of pixels, ascending, and its rectangle.
    """

    left: Nodes
    right: Nodes
    top: Nodes
    bottom: Nodes
    run_starts: Nodes
    run_rectangles: Nodes
    width: int

    def of_pixels(self, rows: Nodes, cols: Nodes) -> Nodes:
        """The rectangle of each pixel of the mask."""
        return self.run_rectangles[np.searchsorted(self.run_starts, rows * self.width + cols, "right") - 1]

    def seams(self) -> tuple[Nodes, Nodes, Nodes, Nodes, Nodes]:
        """Where a rectangle lies on top of another: row, left and right end in px, the upper and the lower one."""
        row, left = np.divmod(self.run_starts, self.width)
        right = self.right[self.run_rectangles]
        above = (row - 1) * self.width
        low = np.searchsorted(row * self.width + right, above + left, "right")
        high = np.searchsorted(self.run_starts, above + right)
        count = np.maximum(high - low, 0)
        lower = np.repeat(np.arange(len(row)), count)
        upper = np.arange(len(lower)) - np.repeat(np.cumsum(count) - count - low, count)
        kept = self.run_rectangles[lower] != self.run_rectangles[upper]
        lower, upper = lower[kept], upper[kept]
        ends = np.maximum(left[lower], left[upper]), np.minimum(right[lower], right[upper])
        return row[lower], *ends, self.run_rectangles[upper], self.run_rectangles[lower]


def rectangles_of(mask: Mask) -> Rectangles:
    """Split a mask into rectangles, each as tall as the runs of its pixels stay the same.

    Parameters
    ----------
    mask : (H, W) bool

    Returns
    -------
    Rectangles
    """
    cols = mask.shape[1]
    edges = np.diff(np.pad(mask, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    row, left = places(edges > 0)
    right = places(edges < 0)[1]
    order = np.lexsort((row, right, left))
    r, a, b = row[order], left[order], right[order]
    is_new = np.ones(len(r), bool)
    is_new[1:] = (a[1:] != a[:-1]) | (b[1:] != b[:-1]) | (r[1:] != r[:-1] + 1)
    number = np.cumsum(is_new) - 1
    of_run = np.empty(len(r), np.int64)
    of_run[order] = number
    first = np.flatnonzero(is_new)
    last = np.append(first[1:], len(r))[: len(first)] - 1
    return Rectangles(a[first], b[first], r[first], r[last] + 1, row * cols + left, of_run, cols)


@dataclass(frozen=True, eq=False)
class FlatBack:
    """The flat back of a shape, at one height: fans over rectangles, and pixels beside moved nodes of the outline.

    Parameters
    ----------
    shape : Shape
    placing : Placing
    z_mm : float
        Its height.
    first_node : int
        What is added to the nodes of the shape; the middles of rectangles come last.
    outline : OutlineEdges
        Of the shape, possibly with nodes left out along straight runs, but for the corners of rectangles.
    beside : (H, W) bool
        Pixels that are triangulated as on the front.
    """

    shape: Shape
    placing: Placing
    z_mm: float
    first_node: int
    outline: OutlineEdges
    beside: Mask

    @cached_property
    def _rectangles(self) -> Rectangles:
        return rectangles_of(self.shape.mask & ~self.beside)

    @property
    def node_count(self) -> int:
        """One more than the highest node number."""
        return self.first_node + self.shape.node_count + len(self._rectangles.left)

    @property
    def face_count(self) -> int:
        """Triangles of the back."""
        return 2 * int(np.count_nonzero(self.beside)) + len(self._fans[0])

    def xyz_of(self, nodes: Nodes) -> Float64:
        """(n, 3) float64 mm of nodes of the shape, on the back."""
        rows = self.shape.mask.shape[0]
        return self.placing.xyz_mm(self.shape.places_px(nodes), np.full(len(nodes), self.z_mm), rows)

    def parts(self) -> Iterator[Part]:
        """The triangles, seen from below."""
        if self.beside.any():
            shape = dataclasses.replace(self.shape, mask=self.beside)
            flat = np.broadcast_to(np.float64(self.z_mm), (self.beside.shape[0] + 1, self.beside.shape[1] + 1))
            yield from Sheet(flat, shape, self.placing, -1, self.first_node).parts()
        centre, start, end = self._fans
        for first in range(0, len(centre), _BAND_FACES):
            band = slice(first, first + _BAND_FACES)
            yield self._fan_part(centre[band], start[band], end[band])

    @cached_property
    def _fans(self) -> tuple[Nodes, Nodes, Nodes]:
        """Rectangle, start and end node of each triangle, counter-clockwise seen from the viewer."""
        width, found = self.shape.mask.shape[1] + 1, self._rectangles
        edges = self._edges()
        row, left, right, upper, lower = found.seams()
        a, b = row * width + left, row * width + right
        rectangle = np.concatenate([found.of_pixels(edges.rows, edges.cols), upper, lower])
        return rectangle, np.concatenate([edges.start, a, b]), np.concatenate([edges.end, b, a])

    def _edges(self) -> OutlineEdges:
        """The outline of the rectangles: the shape's where they meet it, and single edges along the pixels beside."""
        if not self.beside.any():
            return self.outline
        own, inner = self.outline, outline_edges(self.shape.mask & ~self.beside, self.shape.splits)
        kept = ~self.beside[own.rows, own.cols]
        codes = _edge_codes(inner)
        outer = np.isin(codes, _edge_codes(outline_edges(self.shape.mask, self.shape.splits)))
        return own.chosen(kept).joined(inner.chosen(~outer))

    def _fan_part(self, rectangle: Nodes, start: Nodes, end: Nodes) -> Part:
        found = self._rectangles
        nodes, local = np.unique(np.stack([start, end]), return_inverse=True)
        local = local.reshape(2, -1)
        middles, at = np.unique(rectangle, return_inverse=True)
        places_px = np.column_stack([found.left + found.right, found.top + found.bottom])[middles] / 2
        rows = self.shape.mask.shape[0]
        centres = self.placing.xyz_mm(places_px, np.full(len(middles), self.z_mm), rows)
        faces: Faces = np.stack([at + len(nodes), local[1], local[0]], axis=1).astype(np.int32)
        numbers = np.concatenate([nodes, self.shape.node_count + middles]) + self.first_node
        return Part(np.concatenate([self.xyz_of(nodes), centres]), faces, numbers)


def _edge_codes(edges: OutlineEdges) -> Nodes:
    """A number for each edge of single pixels: its start and its direction."""
    return edges.start * np.int64(1 << 31) + edges.end


def rectangle_corners(back: FlatBack) -> Mask:
    """(H+1, W+1) bool: the corners of the rectangles of a back, which its outline must pass through."""
    rows, cols = back.shape.mask.shape
    corners = np.zeros((rows + 1, cols + 1), bool)
    found = rectangles_of(back.shape.mask & ~back.beside)
    for row in (found.top, found.bottom):
        for col in (found.left, found.right):
            corners[row, col] = True
    return corners
