"""Height fields as few triangles: right-angled ones of all sizes, within a strict error."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.errors import InputError
from nmaptool.core.grid import touching_vertices
from nmaptool.solids.outline import OutlineEdges, find_splits, merged_edges, outline_edges
from nmaptool.solids.sheet import falling_diagonals
from nmaptool.solids.split_errors import close, split_errors, surface, tile_side
from nmaptool.types.solid import Nodes

Steps = tuple[Float64, int]
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

    def count(self) -> int:
        """Triangles."""
        return sum(len(triangles) for _, triangles in self.bands())

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
        falls = falling_diagonals(self.z_mm, top, top + len(own))
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


def _pixels(active: Mask, inside: Mask, falls: Mask) -> Nodes:
    """(n, 3, 2): the triangles that are halves of pixels."""
    even = np.zeros(inside.shape, bool)
    even[::2, ::2] = even[1::2, 1::2] = True
    nw, ne, sw, se = active[:-1, :-1], active[:-1, 1:], active[1:, :-1], active[1:, 1:]
    # right angles of the halves of a pixel, whose diagonal falls in even pixels
    upper, lower = np.where(even, ne, nw) & inside, np.where(even, sw, se) & inside
    falls = np.where(upper & lower, falls, even)
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


class Thinner:
    """The triangles of height fields over a mask for any tolerance.

    Parameters
    ----------
    heights : sequence of (H+1, W+1) float64
        In mm. The same triangles serve for all.
    mask : (H, W) bool
    kept : (H+1, W+1) bool
        Vertices that stay.
    """

    def __init__(self, heights: Sequence[Float64], mask: Mask, kept: Mask) -> None:
        self.heights = heights
        self.mask = mask
        self.side = tile_side(*mask.shape)
        self._errors = split_errors(heights, mask, kept)

    def at(self, bound_mm: float) -> Thinned:
        """The triangles for a value of `steps`; infinite for the fewest.

        Their error is at most so large, except for the rounding of numbers.
        """
        return self._mesh(self._active(self._errors, bound_mm))

    def within(self, max_error_mm: float) -> Thinned:
        """The triangles whose error is at most so large."""
        errors = self._errors
        while True:
            active = self._active(errors, max_error_mm)
            off = self._deviations(active)
            too_far = off > max_error_mm
            if not too_far.any():
                return self._mesh(active, off)
            # by the rounding of numbers: these vertices come in
            errors = errors.copy()
            errors[: off.shape[0], : off.shape[1]][too_far] = np.inf
            close(errors, self.side)

    def _active(self, errors: Float64, bound_mm: float) -> Mask:
        active: Mask = errors > bound_mm if np.isfinite(bound_mm) else np.isinf(errors)
        return active

    def _mesh(self, active: Mask, off: Float64 | None = None) -> Thinned:
        off = self._deviations(active) if off is None else off
        return Thinned(self.mask, active, self.side, self.heights[0], float(off.max()))

    def _deviations(self, active: Mask) -> Float64:
        """(H+1, W+1) float64: vertical distances of the vertices of the mask from triangles."""
        known = touching_vertices(self.mask)
        out = np.zeros(known.shape)
        for z_mm in self.heights:
            z = np.where(known, z_mm, 0.0)
            off = surface(z, active, self.side)
            off -= z
            np.abs(off, out=off)
            np.maximum(out, off, out=out, where=known)
        return out

    def steps(self) -> tuple[Float64, Float64]:
        """Tolerances in mm at which vertices come in: those inside of the mask, and those on its outline."""
        rows, cols = self.mask.shape
        around = np.zeros((rows + 1, cols + 1), np.uint8)
        for down, right in ((0, 0), (0, 1), (1, 0), (1, 1)):
            around[down : down + rows, right : right + cols] += self.mask
        errors = self._errors[: rows + 1, : cols + 1]
        finite = np.isfinite(errors) & (errors > 0)
        return errors[finite & (around == 4)], errors[finite & (around == 2)]


def tolerance_for(limit: int, fewest: int, steps: Sequence[Steps]) -> float:
    """The smallest error that needs at most so many triangles.

    Parameters
    ----------
    limit : int
        Triangles.
    fewest : int
        Triangles at any error.
    steps : sequence of (float64 array, int)
        Errors in mm below which a vertex comes in, and by how many triangles each vertex adds to the mesh.

    Raises
    ------
    InputError
        If the limit is below ``fewest``.
    """
    if fewest > limit:
        raise InputError(
            f"`triangles='{limit}'`: the outline alone needs {fewest:,} triangles; allow so many, or give `max_error`"
        )
    # positive numbers have the order of their bits; what lies above the upper bound is counted once
    left = [(errors, each) for errors, each in steps if len(errors)]
    low, high = -1, int(np.float64(np.inf).view(np.int64))
    count = fewest
    while high - low > 1:
        middle = (low + high) // 2
        bound = np.int64(middle).view(np.float64)
        added = sum(each * int(np.count_nonzero(errors > bound)) for errors, each in left)
        if count + added <= limit:
            high, count = middle, count + added
            left = [(errors[errors <= bound], each) for errors, each in left]
        else:
            low = middle
            left = [(errors[errors > bound], each) for errors, each in left]
    return float(np.int64(high).view(np.float64))


def thin(
    z_mm: Float64,
    mask: Mask,
    kept_vertices: Mask,
    *,
    max_error_mm: float | None = None,
    max_triangles: int | None = None,
) -> Thinned:
    """Cover the pixels of a mask with as few triangles as an error allows, or as exactly as a number allows.

    Parameters
    ----------
    z_mm : (H+1, W+1) float64
        Heights. Vertices that do not touch the mask are not looked at.
    mask : (H, W) bool
    kept_vertices : (H+1, W+1) bool
        Vertices that stay. Those that the outline needs stay anyway.
    max_error_mm : float, optional
        Largest vertical distance of a vertex from the triangles. Default: infinite.
    max_triangles : int, optional

    Returns
    -------
    Thinned

    Raises
    ------
    InputError
        If the outline needs more than ``max_triangles``.
    """
    thinner = Thinner([z_mm], mask, kept_vertices)
    if max_triangles is None:
        return thinner.within(np.inf if max_error_mm is None else max_error_mm)
    inside, outline = thinner.steps()
    return thinner.at(tolerance_for(max_triangles, thinner.at(np.inf).count(), [(inside, 2), (outline, 1)]))
