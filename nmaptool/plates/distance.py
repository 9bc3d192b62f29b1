"""Distances from points to closed curves, and which points lie inside."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64, Mask
from nmaptool.types.contours import Contours

# the nearest edge is at one of the nearest samples of the curves
_NEAREST = 3
# points that are compared with all edges at once
_BAND = 256


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
        Spacing of the samples that the search begins with; distances are exact to the polygons.
    """

    def __init__(self, contours: Contours, spacing_mm: float) -> None:
        self.contours = contours
        self._spacing_mm = spacing_mm

    @cached_property
    def lengths_mm(self) -> tuple[float, ...]:
        """The length of each ring."""
        return tuple(float(np.hypot(*_edges(ring).T).sum()) for ring in self.contours.rings)

    @cached_property
    def _samples(self) -> tuple[Any, Float64, Float64, Float64, NDArray[np.int64]]:
        """A tree of short edges' middles; their starts, ends, places along their ring, and rings."""
        from scipy.spatial import cKDTree  # takes long to load

        starts, ends, alongs, rings = [], [], [], []
        for number, ring in enumerate(self.contours.rings):
            edge = _edges(ring)
            length = np.hypot(*edge.T)
            count = np.maximum(1, np.ceil(length / self._spacing_mm)).astype(np.int64)
            which = np.repeat(np.arange(len(ring)), count)
            step = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)
            share = step / count[which]
            start = ring[which] + edge[which] * share[:, None]
            starts.append(start)
            ends.append(start + edge[which] / count[which][:, None])
            before = np.concatenate([[0.0], np.cumsum(length)[:-1]])
            alongs.append(before[which] + share * length[which])
            rings.append(np.full(len(which), number))
        start, end = np.concatenate(starts), np.concatenate(ends)
        return cKDTree((start + end) / 2), start, end, np.concatenate(alongs), np.concatenate(rings)

    def nearest(self, points_mm: Float64, reach_mm: float = np.inf) -> Nearest:
        """The nearest point of the curves for (n, 2) points, where it is within ``reach_mm``."""
        tree, start, end, along, ring = self._samples
        count = min(_NEAREST, len(start))
        bound = reach_mm + self._spacing_mm
        _, found = tree.query(points_mm, count, distance_upper_bound=bound, workers=-1)
        found = found.reshape(len(points_mm), count)
        out = Nearest(np.full(len(points_mm), np.inf), np.zeros(len(points_mm)), np.full(len(points_mm), -1, np.int64))
        for each in found.T:
            (near,) = np.nonzero(each < len(start))
            at = each[near]
            edge, way = end[at] - start[at], points_mm[near] - start[at]
            squared = np.maximum((edge**2).sum(axis=1), 1e-30)
            share = np.clip((way * edge).sum(axis=1) / squared, 0.0, 1.0)
            distance = np.hypot(*(way - edge * share[:, None]).T)
            better = (distance < out.distance_mm[near]) & (distance <= reach_mm)
            rows, at = near[better], at[better]
            out.distance_mm[rows] = distance[better]
            out.along_mm[rows] = along[at] + share[better] * np.sqrt(squared[better])
            out.ring[rows] = ring[at]
        return out


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
    order = np.argsort(y_mm)
    levels = y_mm[order]
    turns = np.zeros((len(y_mm), len(x_mm) + 1), np.int32)
    for ring in contours.rings:
        start, end = ring, np.roll(ring, -1, axis=0)
        low, high = np.minimum(start[:, 1], end[:, 1]), np.maximum(start[:, 1], end[:, 1])
        first, last = np.searchsorted(levels, low, "left"), np.searchsorted(levels, high, "left")
        count = last - first
        edge = np.repeat(np.arange(len(ring)), count)
        row = np.arange(len(edge)) - np.repeat(np.cumsum(count) - count - first, count)
        share = (levels[row] - start[edge, 1]) / (end[edge, 1] - start[edge, 1])
        crossing = start[edge, 0] + share * (end[edge, 0] - start[edge, 0])
        upward = np.where(end[edge, 1] > start[edge, 1], 1, -1)
        np.add.at(turns, (row, np.searchsorted(x_mm, crossing, "left")), upward)
    inside: Mask = np.empty((len(y_mm), len(x_mm)), bool)
    inside[order] = np.cumsum(turns, axis=1)[:, :-1] != 0
    return inside


def inside_points(contours: Contours, points_mm: Float64) -> Mask:
    """(n,) bool: which of (n, 2) points lie inside closed curves."""
    turns = np.zeros(len(points_mm), np.int64)
    for first in range(0, len(points_mm), _BAND):
        x, y = points_mm[first : first + _BAND].T[:, :, None]
        for start in contours.rings:
            end = np.roll(start, -1, axis=0)
            crosses = (start[:, 1] <= y) != (end[:, 1] <= y)
            side = (end[:, 0] - start[:, 0]) * (y - start[:, 1]) - (end[:, 1] - start[:, 1]) * (x - start[:, 0])
            upward = end[:, 1] > start[:, 1]
            # edges to the right of the point
            counted = np.where(upward, 1, -1) * (crosses & ((side > 0) == upward))
            turns[first : first + _BAND] += counted.sum(axis=1)
    inside: Mask = turns != 0
    return inside
