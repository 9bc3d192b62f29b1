"""Distances from points to closed curves, and which points lie inside."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.winding import winding_on_grid, winds_around
from nmaptool.types.contours import Contours

# points that are searched for at once
_AT_ONCE = 1_000_000


@dataclass(frozen=True, eq=False)
class Nearest:
    """The nearest point of curves, for each of n points.

    Attributes
    ----------
    distance_mm : (n,) float64
        Infinite where the curves are farther away than asked for.
    along_mm : (n,) float64
        Where on its ring the nearest point lies, from its first corner.
    ring : (n,) int64
        Which ring; -1 where there is none.
    """

    distance_mm: Float64
    along_mm: Float64
    ring: NDArray[np.int64]


class Curves:
    """Closed curves to measure distances to.

    Parameters
    ----------
    contours : Contours
    spacing_mm : float
        Longest edge that the search uses; distances are exact to the polygons for any.
    """

    def __init__(self, contours: Contours, spacing_mm: float) -> None:
        self.contours = contours
        self._spacing_mm = spacing_mm

    @cached_property
    def lengths_mm(self) -> tuple[float, ...]:
        """The length of each ring."""
        return tuple(float(np.hypot(*_edges(ring).T).sum()) for ring in self.contours.rings)

    @cached_property
    def _edges_and_tree(self) -> tuple[Any, _Edges]:
        """A tree of the ends of short edges, and these edges."""
        from scipy.spatial import cKDTree  # takes long to load

        parts = [_short_edges(ring, number, self._spacing_mm) for number, ring in enumerate(self.contours.rings)]
        shift = np.cumsum([0, *(len(part.start) for part in parts)])
        edges = _Edges(
            np.concatenate([part.start for part in parts]),
            np.concatenate([part.way for part in parts]),
            np.concatenate([part.along for part in parts]),
            np.concatenate([part.ring for part in parts]),
            np.concatenate([part.before + first for part, first in zip(parts, shift, strict=False)]),
        )
        return cKDTree(edges.start), edges

    def nearest(self, points_mm: Float64, reach_mm: float = np.inf) -> Nearest:
        """The nearest point of the curves for (n, 2) points, where it is within ``reach_mm``."""
        count = len(points_mm)
        out = Nearest(np.full(count, np.inf), np.zeros(count), np.full(count, -1, np.int64))
        for first in range(0, count, _AT_ONCE):
            self._search(points_mm, np.arange(first, min(first + _AT_ONCE, count)), reach_mm, out)
        return out

    def _search(self, points_mm: Float64, rows: NDArray[np.intp], reach_mm: float, out: Nearest) -> None:
        """Find the nearest points for some rows of the points.

        Of the nearest edge, one end is within sqrt(d^2 + s^2 / 4), where d is the distance of the edge and s the
        longest edge. So the search is over when the ends that were not compared are farther away.
        """
        tree, edges = self._edges_and_tree
        quarter = float((edges.way**2).sum(axis=1).max()) / 4
        bound = float(np.sqrt(reach_mm**2 + quarter)) * (1 + 1e-12)
        count = 2
        while len(rows):
            count = min(count, len(edges.start))
            away, found = tree.query(points_mm[rows], count, distance_upper_bound=bound, workers=-1)
            found, away = found.reshape(len(rows), count), away.reshape(len(rows), count)
            for ends in found.T:
                near = ends < len(edges.start)
                for at in (ends[near], edges.before[ends[near]]):
                    _compare(points_mm, rows[near], at, edges, reach_mm, out)
            least = np.sqrt(np.minimum(out.distance_mm[rows], reach_mm) ** 2 + quarter)
            rows = rows[(away[:, -1] < least * (1 - 1e-12)) & (count < len(edges.start))]
            count *= 4


@dataclass(frozen=True, eq=False)
class _Edges:
    """Short edges of rings: their starts, ways to their ends, places along their ring, rings, and the edges before."""

    start: Float64
    way: Float64
    along: Float64
    ring: NDArray[np.int64]
    before: NDArray[np.int64]


def _short_edges(ring: Float64, number: int, spacing_mm: float) -> _Edges:
    """A ring's edges divided so that none is longer than ``spacing_mm``."""
    edge = _edges(ring)
    length = np.hypot(*edge.T)
    count = np.maximum(1, np.ceil(length / spacing_mm)).astype(np.int64)
    which = np.repeat(np.arange(len(ring)), count)
    share = (np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)) / count[which]
    reached = np.cumsum(length) - length
    return _Edges(
        ring[which] + edge[which] * share[:, None],
        edge[which] / count[which][:, None],
        reached[which] + share * length[which],
        np.full(len(which), number),
        np.arange(-1, len(which) - 1) % len(which),
    )


def _compare(
    points_mm: Float64, rows: NDArray[np.intp], at: NDArray[np.intp], edges: _Edges, reach_mm: float, out: Nearest
) -> None:
    """Keep the nearest point of one edge for each of some points, where it is nearer than that found before."""
    edge, way = edges.way[at], points_mm[rows] - edges.start[at]
    squared = np.maximum((edge**2).sum(axis=1), 1e-30)
    share = np.clip((way * edge).sum(axis=1) / squared, 0.0, 1.0)
    distance = np.hypot(*(way - edge * share[:, None]).T)
    better = (distance < out.distance_mm[rows]) & (distance <= reach_mm)
    rows, at = rows[better], at[better]
    out.distance_mm[rows] = distance[better]
    out.along_mm[rows] = edges.along[at] + share[better] * np.sqrt(squared[better])
    out.ring[rows] = edges.ring[at]


def _edges(ring: Float64) -> Float64:
    """(n, 2) from each corner to the next."""
    return np.roll(ring, -1, axis=0) - ring


def inside_grid(contours: Contours, x_mm: Float64, y_mm: Float64) -> Mask:
    """Which points of a grid lie inside closed curves.

    Parameters
    ----------
    contours : Contours
    x_mm : (cols,) float64
        Ascending.
    y_mm : (rows,) float64

    Returns
    -------
    (rows, cols) bool
    """
    inside: Mask = winding_on_grid(contours.rings, x_mm, y_mm) != 0
    return inside


def inside_points(contours: Contours, points_mm: Float64) -> Mask:
    """(n,) bool: which of (n, 2) points lie inside closed curves."""
    return winds_around(contours.rings, points_mm)
