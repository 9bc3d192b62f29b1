"""Find where closed polygons cross themselves or each other."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.winding import winds_around
from nmaptool.lettering.rings import Rule, cross_section
from nmaptool.types.contours import ring_area

_BLOCK = 256
_RULES: tuple[Rule, ...] = ("EvenOdd", "NonZero")
# an area per length below which a crossing is rounding of the boolean operation, in mm
_ROUNDING_MM = 1e-6


def holds(outer: Float64, ring: Float64) -> bool:
    """Whether a ring that does not cross an outer one lies inside it."""
    return bool(winds_around([outer], ring[:1])[0])


def cross_themselves(rings: list[Float64]) -> bool:
    """Whether a ring crosses itself: then it encloses parts with a winding number other than 1."""
    return any(abs(abs(ring_area(ring)) - _area([ring], rule)) > rounding([ring]) for ring in rings for rule in _RULES)


def cross_each_other(rings: list[Float64]) -> bool:
    """Whether rings that do not cross themselves cross each other: then nested areas do not add up."""
    order = sorted(rings, key=lambda ring: -abs(ring_area(ring)))
    nested = 0.0
    for number, ring in enumerate(order):
        depth = sum(holds(other, ring) for other in order[:number])
        nested += abs(ring_area(ring)) * (1 if depth % 2 == 0 else -1)
    return abs(nested - _area(rings, "EvenOdd")) > rounding(rings)


def rounding(rings: list[Float64]) -> float:
    """Area in mm2 below which a loop or an overlap counts as rounding."""
    return _ROUNDING_MM * float(sum(np.hypot(*(np.roll(ring, -1, axis=0) - ring).T).sum() for ring in rings))


def _area(rings: list[Float64], rule: Rule) -> float:
    """Area that rings enclose by a fill rule."""
    return float(cross_section(rings, rule).area())


def crossing_point(rings: list[Float64]) -> tuple[float, float] | None:
    """One point where edges cross; None if edges only touch or overlap."""
    begins = np.concatenate(rings)
    ends = np.concatenate([np.roll(ring, -1, axis=0) for ring in rings])
    low, high = np.minimum(begins[:, 0], ends[:, 0]), np.maximum(begins[:, 0], ends[:, 0])
    order = np.argsort(low)
    begins, ends, low, high = begins[order], ends[order], low[order], high[order]
    for first in range(0, len(begins), _BLOCK):
        block = slice(first, first + _BLOCK)
        near = np.arange(first, np.searchsorted(low, high[block].max(), side="right"))
        hit = _cross(begins[block], ends[block], begins[near], ends[near])
        if hit.any():
            i, j = (int(number) for number in np.argwhere(hit)[0])
            return _meeting(begins[first + i], ends[first + i], begins[near[j]], ends[near[j]])
    return None


def _side(a: Float64, b: Float64, points: Float64) -> Float64:
    """Twice the area of each triangle of an edge and a point: its sign is the side of the point."""
    edge, away = (b - a)[:, None], points[None] - a[:, None]
    return np.asarray(edge[..., 0] * away[..., 1] - edge[..., 1] * away[..., 0], np.float64)


def _cross(a: Float64, b: Float64, c: Float64, d: Float64) -> Mask:
    """(n, m) bool: whether the edges from a to b and those from c to d cross between their ends."""
    mine = _side(a, b, c) * _side(a, b, d) < 0
    return np.asarray(mine & ((_side(c, d, a) * _side(c, d, b)).T < 0), np.bool_)


def _meeting(a: Float64, b: Float64, c: Float64, d: Float64) -> tuple[float, float]:
    """The point where two edges cross."""
    edge, other = b - a, d - c
    part = ((c - a)[0] * other[1] - (c - a)[1] * other[0]) / (edge[0] * other[1] - edge[1] * other[0])
    x, y = a + part * edge
    return float(x), float(y)
