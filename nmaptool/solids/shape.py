"""Where the nodes of a mask of pixels lie: on the grid, or moved along the outline."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.grid import found_in
from nmaptool.solids.outline import CORNERS, Splits
from nmaptool.types.solid import Nodes

# how far the two nodes of a split vertex are drawn apart, along x and y
SPLIT_PX = 0.01


def _no_nodes() -> Nodes:
    return np.zeros(0, np.int64)


@dataclass(frozen=True, eq=False)
class Shape:
    """A mask of pixels and the places of its nodes.

    Node ``row * (W + 1) + col`` is a vertex of the grid; the second nodes of split vertices follow.

    Attributes
    ----------
    mask : (H, W) bool
    splits : Splits
    moved : (n,) int64
        Nodes that do not lie on the grid, ascending.
    by_px : (n, 2) float64
        How far, to the right and down.
    forced : (m,) int64
        Pixels ``row * W + col`` whose diagonal is given, ascending.
    forced_falls : (m,) bool
        Whether it falls, from the upper left to the lower right corner.
    keeps_heights : bool
        Whether moved nodes keep the heights of their vertices: where they hardly move, and where a motif meets its
        plate. Otherwise their heights continue the surface inside.
    """

    mask: Mask
    splits: Splits
    moved: Nodes = field(default_factory=_no_nodes)
    by_px: Float64 = field(default_factory=lambda: np.zeros((0, 2)))
    forced: Nodes = field(default_factory=_no_nodes)
    forced_falls: Mask = field(default_factory=lambda: np.zeros(0, bool))
    keeps_heights: bool = False

    @property
    def node_count(self) -> int:
        """Vertices of the grid and second nodes."""
        return self.splits.first + len(self.splits.vertices)

    def vertex_of(self, nodes: Nodes) -> Nodes:
        """The vertex of the grid that each node belongs to."""
        if not len(self.splits.vertices):
            return nodes
        second = np.clip(nodes - self.splits.first, 0, len(self.splits.vertices) - 1)
        return np.where(nodes < self.splits.first, nodes, self.splits.vertices[second])

    def places_px(self, nodes: Nodes) -> Float64:
        """(n, 2) float64: x to the right and y down of nodes, in px from the upper left corner of the mask."""
        row, col = np.divmod(self.vertex_of(nodes), self.mask.shape[1] + 1)
        out = np.column_stack([col, row]).astype(np.float64)
        at = found_in(self.moved, nodes)
        out[at >= 0] += self.by_px[at[at >= 0]]
        return out


def split_moves(splits: Splits) -> tuple[Nodes, Float64]:
    """The nodes of split vertices, and how they are drawn apart: each towards its own pixel."""
    across = np.where(splits.lower_is_right, SPLIT_PX, -SPLIT_PX)
    down = np.full(len(across), SPLIT_PX)
    second = splits.first + np.arange(len(across))
    lower = np.column_stack([across, down])
    return np.concatenate([splits.vertices, second]), np.concatenate([-lower, lower])


def pixel_shape(mask: Mask, splits: Splits) -> Shape:
    """The shape whose outline follows the pixels; only split vertices are drawn apart."""
    return Shape(mask, splits, *split_moves(splits), keeps_heights=True)


def pixels_touching(nodes: Nodes, shape: Shape) -> Mask:
    """(H, W) bool: pixels of the mask with one of the nodes at a corner."""
    rows, cols = shape.mask.shape
    near = np.zeros(shape.mask.shape, bool)
    row, col = np.divmod(shape.vertex_of(nodes), cols + 1)
    for down, right in CORNERS.values():
        r, c = row - down, col - right
        inside = (r >= 0) & (r < rows) & (c >= 0) & (c < cols)
        near[r[inside], c[inside]] = True
    return near & shape.mask
