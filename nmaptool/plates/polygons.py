"""Offsets, unions and differences of closed curves, by manifold3d."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.lettering.rings import contours_of, cross_section
from nmaptool.types.contours import Contours, ring_area

# distance between a round join and its polygon
_JOIN_MM = 5e-4


def offset(contours: Contours, by_mm: float, *, is_sharp: bool = False) -> Contours:
    """Curves moved outwards (or inwards, if negative) by a distance, with round or sharp corners outside."""
    import manifold3d

    if by_mm == 0:
        return contours
    count = max(8, int(np.ceil(np.pi / np.sqrt(2 * min(_JOIN_MM / abs(by_mm), 0.1)))))
    join = manifold3d.JoinType.Miter if is_sharp else manifold3d.JoinType.Round
    found = cross_section(contours.rings).offset(by_mm, join, circular_segments=count)
    return contours_of(found.simplify(_JOIN_MM / 10), contours.tolerance_mm + circle_tolerance(abs(by_mm), count))


def outer_rings(contours: Contours) -> Contours:
    """The curves without their holes."""
    return Contours(tuple(ring for ring in contours.rings if ring_area(ring) > 0), contours.tolerance_mm)


def circle(x_mm: float, y_mm: float, radius_mm: float, spacing_mm: float) -> Float64:
    """(n, 2) corners on a circle, counter-clockwise."""
    count = 4 * max(12, int(np.ceil(np.pi / 2 * radius_mm / spacing_mm)))  # so that it is exactly as wide and high
    angle = np.arange(count) * (2 * np.pi / count)
    return np.column_stack([x_mm + radius_mm * np.cos(angle), y_mm + radius_mm * np.sin(angle)])


def circle_tolerance(radius_mm: float, count: int) -> float:
    """The distance between a circle and its polygon of ``count`` corners."""
    return radius_mm * float(1 - np.cos(np.pi / count))


def refined(ring: Float64, spacing_mm: float) -> Float64:
    """A ring with more corners on its edges, so that none is longer than ``spacing_mm``."""
    edge = np.roll(ring, -1, axis=0) - ring
    count = np.maximum(1, np.ceil(np.hypot(*edge.T) / spacing_mm - 1e-9)).astype(np.int64)
    which = np.repeat(np.arange(len(ring)), count)
    share = (np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)) / count[which]
    out: Float64 = ring[which] + edge[which] * share[:, None]
    return out


def without_short_edges(ring: Float64, least_mm: float) -> Float64:
    """A ring without the corners that are nearer than ``least_mm`` to the one before, such as where two curves met."""
    short = np.hypot(*(ring - np.roll(ring, 1, axis=0)).T) < least_mm
    if not short.any():
        return ring
    kept: list[Float64] = []
    for corner in ring:
        if not kept or np.hypot(*(corner - kept[-1])) >= least_mm:
            kept.append(corner)
    while len(kept) > 3 and np.hypot(*(kept[0] - kept[-1])) < least_mm:
        kept.pop()
    return np.array(kept)
