"""How far a height field lies from triangles before each vertex of the grid splits them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.grid import touching_vertices
from nmaptool.core.parallel import map_parallel
from nmaptool.solids.triangle_tree import UNIT_PX, tree

_LARGEST_TILE_PX = 256
_Kind = TypeVar("_Kind", bound=np.generic)


def tile_side(rows: int, cols: int) -> int:
    """The width of the tiles of a grid in px: a power of two."""
    return min(_LARGEST_TILE_PX, max(UNIT_PX, 1 << (max(rows, cols) - 1).bit_length()))


def padded_to_tiles(values: NDArray[_Kind], side: int) -> NDArray[_Kind]:
    """A copy of values at (H+1, W+1) vertices, with zeros to the right and below up to whole tiles."""
    rows, cols = (-(-(length - 1) // side) * side + 1 for length in values.shape)
    out = np.zeros((rows, cols), values.dtype)
    out[: values.shape[0], : values.shape[1]] = values
    return out


def needed_outline(mask: Mask, side: int) -> Mask:
    """(H+1, W+1) bool: vertices of an outline that keep triangles from lying across it.

    A straight part of the outline that starts at a multiple of its length, a power of two, and lies in such a row or
    column, is a side of triangles as soon as its ends are vertices; so only the ends are needed.

    Parameters
    ----------
    mask : (H, W) bool
    side : int
        Of the tiles.
    """
    padded = np.pad(mask, 1)
    down = padded[1:-1, 1:] != padded[1:-1, :-1]  # (H, W+1): between a vertex and the next one below
    right = padded[1:, 1:-1] != padded[:-1, 1:-1]
    on_down, on_right = _ends(down), _ends(right.T).T
    needed = on_down | on_right
    free = ~(on_down & on_right)
    for edges, at, may_go in ((down, needed, free), (right.T, needed.T, free.T)):
        _forget_middles(edges, at, may_go, side)
    return needed


def _ends(edges: Mask) -> Mask:
    """(H+1, W+1) bool: the ends of (H, W+1) edges between a vertex and the next one below."""
    out = np.zeros((len(edges) + 1, edges.shape[1]), bool)
    out[:-1] = edges
    out[1:] |= edges
    return out


def _forget_middles(edges: Mask, needed: Mask, may_go: Mask, side: int) -> None:
    """Clear the middles of straight parts of an outline, given as edges to the next vertex below."""
    length = 1
    while length < side and len(edges) > 1:
        pairs = len(edges) // 2 * 2
        edges = edges[0:pairs:2, ::2] & edges[1:pairs:2, ::2]
        chosen = (slice(length, 2 * length * len(edges), 2 * length), slice(None, None, 2 * length))
        needed[chosen] &= ~(edges & may_go[chosen])
        length *= 2


def split_errors(heights: Sequence[Float64], mask: Mask, kept: Mask) -> Float64:
    """The tolerance up to which each vertex must split its triangles.

    Parameters
    ----------
    heights : sequence of (H+1, W+1) float64
        In mm. The same triangles serve for all.
    mask : (H, W) bool
        Pixels that are covered.
    kept : (H+1, W+1) bool
        Vertices that are never left out, besides those that the outline needs.

    Returns
    -------
    (R+1, C+1) float64
        mm; R and C are H and W rounded up to multiples of `tile_side`. The vertices whose value is greater than a
        tolerance are those of a mesh without gaps, for any tolerance: the value is the largest vertical distance of
        any height from the triangles that the vertex splits, or the value of a vertex that can only be reached through
        this one, if that is greater. It is infinite for kept vertices and at the corners of tiles.
    """
    side = tile_side(*mask.shape)
    known = touching_vertices(mask)
    whole = None if known.all() and not np.any(np.array(mask.shape) % side) else padded_to_tiles(known, side)
    out = np.zeros_like(padded_to_tiles(np.zeros(kept.shape), side))
    for z_mm in heights:
        _measure_tiles(padded_to_tiles(np.where(known, z_mm, 0.0), side), whole, mask, out, side)
    out[: kept.shape[0], : kept.shape[1]][kept | needed_outline(mask, side)] = np.inf
    out[::side, ::side] = np.inf
    close(out, side)
    return out


def _measure_tiles(z_mm: Float64, known: Mask | None, mask: Mask, out: Float64, side: int) -> None:
    """Raise the values of vertices to the deviations from the triangles that they split."""
    pattern = tree(side)
    tops = range(0, len(out) - 1, side)

    def measure(top: int) -> None:
        for left in range(0, out.shape[1] - 1, side):
            if mask[top : top + side, left : left + side].any():
                here = (slice(top, top + side + 1), slice(left, left + side + 1))
                part = None if known is None or known[here].all() else known[here]
                view = out[here]
                np.maximum(view, pattern.errors(np.ascontiguousarray(z_mm[here]), part), out=view)

    # rows of tiles share vertices with their neighbours only
    map_parallel(tops[::2], measure)
    map_parallel(tops[1::2], measure)


def close(errors: Float64, side: int) -> None:
    """Raise the value of each vertex to that of the vertices that need it, from the finest level up.

    Parameters
    ----------
    errors : (R+1, C+1) float64
        Changed in place.
    side : int
        Of the tiles.
    """
    step = 2
    while step <= side:
        half = step // 2
        across, down = errors[::step, half::step], errors[half::step, ::step]  # middles of sides
        if half > 1:
            # triangles beside a side are split at the centres of the squares half as wide
            centres = errors[half // 2 :: half, half // 2 :: half]
            pairs = np.maximum(centres[:, ::2], centres[:, 1::2])
            np.maximum(across[:-1], pairs[::2], out=across[:-1])
            np.maximum(across[1:], pairs[1::2], out=across[1:])
            pairs = np.maximum(centres[::2], centres[1::2])
            np.maximum(down[:, :-1], pairs[:, ::2], out=down[:, :-1])
            np.maximum(down[:, 1:], pairs[:, 1::2], out=down[:, 1:])
        centres = errors[half::step, half::step]
        for around in (across[:-1], across[1:], down[:, :-1], down[:, 1:]):
            np.maximum(centres, around, out=centres)
        step *= 2


def surface(z_mm: Float64, active: Mask, side: int) -> Float64:
    """Heights of the triangles at all vertices of the grid.

    A vertex that is left out lies in the middle of a line within one triangle.

    Parameters
    ----------
    z_mm : (H+1, W+1) float64
    active : (R+1, C+1) bool
        The vertices of the mesh.
    side : int

    Returns
    -------
    (H+1, W+1) float64
    """
    z = padded_to_tiles(z_mm, side)
    step = side
    while step > 1:
        half = step // 2
        centres, off = z[half::step, half::step], ~active[half::step, half::step]
        corners = z[::step, ::step]
        falling = corners[:-1, :-1] + corners[1:, 1:]
        if step < side:  # diagonals run from the centre of a square to the corners
            rising = corners[:-1, 1:] + corners[1:, :-1]
            falling[::2, 1::2] = rising[::2, 1::2]
            falling[1::2, ::2] = rising[1::2, ::2]
        np.multiply(falling, 0.5, out=centres, where=off)
        across, down = (
            (slice(None, None, step), slice(half, None, step)),
            (slice(half, None, step), slice(None, None, step)),
        )
        np.multiply(corners[:, :-1] + corners[:, 1:], 0.5, out=z[across], where=~active[across])
        np.multiply(corners[:-1] + corners[1:], 0.5, out=z[down], where=~active[down])
        step = half
    return z[: z_mm.shape[0], : z_mm.shape[1]]
