"""A mask of pixels as right-angled triangles of all sizes: which of the vertices of the grid belong to the mesh."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.solids.outline import OutlineEdges, find_splits, merged_edges, outline_edges
from nmaptool.solids.sheet import falling_diagonals
from nmaptool.solids.split_errors import surface
from nmaptool.types.solid import Nodes

# neighbours counter-clockwise seen from the viewer, in rows and columns: along the grid, and along diagonals
_STRAIGHT = ((0, 1), (-1, 0), (0, -1), (1, 0))
_DIAGONAL = ((-1, 1), (-1, -1), (1, -1), (1, 1))
# a pixel at the vertex, between a neighbour and the next one
_BETWEEN = ((-1, 0), (-1, -1), (0, -1), (0, 0))


@dataclass(frozen=True, eq=False)
class Thinned:
    """Triangles that cover a mask of pixels exactly.

    They meet at whole sides, and all are right-angled with two equal legs along the grid or along its diagonals.

    Attributes
    ----------
    mask : (H, W) bool
    active : (R+1, C+1) bool
        Whether a vertex of the grid belongs to the mesh; beyond the mask it means nothing.
    side : int
        Of the tiles, in px.
    z_mm : (H+1, W+1) float64
        Heights. A pixel with two triangles is split along the diagonal along which they bend less.
    max_error_mm : float
        Largest vertical distance between a vertex of the grid and the triangles, of all heights that were given.
    """

    mask: Mask
    active: Mask
    side: int
    z_mm: Float64
    max_error_mm: float

    @property
    def triangles(self) -> Nodes:
        """(n, 3) int64: vertices ``row * (W+1) + column``, counter-clockwise seen from the viewer."""
        return np.concatenate([np.zeros((0, 3), np.int64), *(triangles for _, triangles in self.bands())])

    @property
    def outline(self) -> OutlineEdges:
        """The edges of the outline, with the mask to the left; vertices are not split."""
        edges = outline_edges(self.mask, find_splits(np.zeros_like(self.mask)))
        return merged_edges(edges, self.active[: len(self.mask) + 1, : self.mask.shape[1] + 1])

    @cached_property
    def face_count(self) -> int:
        """Number of triangles."""
        return sum(len(triangles) for _, triangles in self.bands())

    def heights_of(self, z_mm: Float64) -> Float64:
        """(H+1, W+1) float64: heights of the triangles at all vertices, for heights at the vertices of the mesh."""
        return surface(z_mm, self.active, self.side)

    def falls(self, top: int, end: int) -> Mask:
        """(end - top, W) bool: whether triangles meet along the falling diagonal of each pixel of some rows."""
        upper, lower, even = _halves_of_pixels(self.active[top : end + 1, : self.mask.shape[1] + 1], top)
        falls: Mask = np.where(upper & lower, falling_diagonals(self.z_mm, top, end), even)
        return falls

    def bands(self) -> Iterator[tuple[int, Nodes]]:
        """The first row of each row of tiles, and the triangles there as in `triangles`."""
        for top in range(0, len(self.mask), self.side):
            if self.mask[top : top + self.side].any():
                yield top, self._band(top)

    def _band(self, top: int) -> Nodes:
        """The triangles of a row of tiles."""
        side, width = self.side, self.mask.shape[1] + 1
        active = self.active[top : top + side + 1]
        inside = np.zeros((side + 2, active.shape[1] + 1), bool)
        own = self.mask[top : top + side]
        inside[1 : len(own) + 1, 1:width] = own
        found = [_whole_tiles(active, inside, side)]
        step = side
        while step > 1:
            half = step // 2
            row, col = np.nonzero(active[half::step, half::step])
            found.append(_around(row * step + half, col * step + half, half, _DIAGONAL, active, inside))
            if half > 1:
                for first, second in ((0, half), (half, 0)):
                    row, col = np.nonzero(active[first::step, second::step])
                    found.append(_around(row * step + first, col * step + second, half, _STRAIGHT, active, inside))
            step = half
        falls = self.falls(top, top + len(own))
        found.append(_pixels(active[: len(own) + 1, :width], own, falls))
        corners = np.concatenate(found)
        triangles: Nodes = (corners[..., 0] + top) * width + corners[..., 1]
        return triangles


def _whole_tiles(active: Mask, inside: Mask, side: int) -> Nodes:
    """(n, 3, 2): rows and columns of the triangles of tiles that are not split."""
    left = np.flatnonzero(~active[side // 2, side // 2 :: side]) * side
    nw, ne, sw, se = (
        np.stack([np.full_like(left, down), left + right], 1) for down in (0, side) for right in (0, side)
    )
    upper, lower = np.stack([nw, se, ne], axis=1), np.stack([nw, sw, se], axis=1)
    return np.concatenate([upper[inside[1, left + side]], lower[inside[side, left + 1]]])


def _around(
    row: Nodes, col: Nodes, half: int, directions: tuple[tuple[int, int], ...], active: Mask, inside: Mask
) -> Nodes:
    """(n, 3, 2): the triangles with their right angle at some vertices that are not split and lie inside.

    A vertex of the mesh has four, which lie between it and four neighbours at a distance of ``half`` px.
    """
    found = []
    for number, (first, pixel) in enumerate(zip(directions, _BETWEEN, strict=True)):
        second = directions[(number + 1) % 4]
        down, right = (half * (first[axis] + second[axis]) // 2 for axis in (0, 1))
        chosen = inside[row + 1 + pixel[0], col + 1 + pixel[1]]
        r, c = row[chosen], col[chosen]
        whole = ~active[r + down, c + right]
        r, c = r[whole], c[whole]
        ends = [np.stack([r + half * d[0], c + half * d[1]], axis=1) for d in (first, second)]
        found.append(np.stack([np.stack([r, c], axis=1), *ends], axis=1))
    return np.concatenate(found)


def _halves_of_pixels(active: Mask, top: int) -> tuple[Mask, Mask, Mask]:
    """Whether the upper and the lower half of each pixel are triangles, and whether its diagonal falls."""
    even = np.zeros((active.shape[0] - 1, active.shape[1] - 1), bool)
    even[top % 2 :: 2, ::2] = even[1 - top % 2 :: 2, 1::2] = True
    nw, ne, sw, se = active[:-1, :-1], active[:-1, 1:], active[1:, :-1], active[1:, 1:]
    # a half is a triangle if the vertex at its right angle is one of the mesh
    return np.where(even, ne, nw), np.where(even, sw, se), even


def _pixels(active: Mask, inside: Mask, falls: Mask) -> Nodes:
    """(n, 3, 2): the triangles that are halves of pixels, from an even row on."""
    upper, lower, _ = _halves_of_pixels(active, 0)
    upper, lower = upper & inside, lower & inside
    found = []
    for chosen, corners in (
        (upper & falls, ((0, 0), (1, 1), (0, 1))),
        (lower & falls, ((0, 0), (1, 0), (1, 1))),
        (upper & ~falls, ((0, 0), (1, 0), (0, 1))),
        (lower & ~falls, ((1, 0), (1, 1), (0, 1))),
    ):
        at = np.stack(np.nonzero(chosen), axis=1)
        found.append(at[:, None] + np.array(corners))
    return np.concatenate(found)
