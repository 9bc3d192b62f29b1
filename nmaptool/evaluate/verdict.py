"""Compare two reconstruction methods by their curves of vertex deviation over normal deviation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

# a point of a curve: normal deviation, vertex deviation
Point = tuple[float, float]


def front(points: Sequence[Point]) -> list[Point]:
    """Return the Pareto front: the points that no other point beats in both deviations, by rising normal deviation."""
    kept: list[Point] = []
    for point in sorted(points):
        if not kept or point[1] < kept[-1][1]:
            kept.append(point)
    return kept


def reached(curves: Sequence[Sequence[Point]], normal: float) -> float | None:
    """Return the smallest vertex deviation at a normal deviation of at most ``normal``, interpolated logarithmically.

    None if no curve reaches that normal deviation.
    """
    found = []
    for curve in curves:
        kept = front([(angle, size) for angle, size in curve if angle > 0 and size > 0])
        if kept and kept[0][0] <= normal:
            angles, sizes = (np.log(each) for each in zip(*kept, strict=True))
            found.append(float(np.exp(np.interp(np.log(normal), angles, sizes))))
    return min(found, default=None)


@dataclass(frozen=True)
class FrontPoint:
    """A point of the rival's front: its normal deviation, and the ratio of our vertex deviation there to its own.

    The ratio is None if our curves do not reach that normal deviation.
    """

    normal: float
    ratio: float | None


def compare_fronts(ours: Sequence[Sequence[Point]], rival: Sequence[Point]) -> list[FrontPoint]:
    """Return each point of the rival's front with the smallest ratio of any of our curves there."""
    found = []
    for normal, size in front(rival):
        here = reached(ours, normal) if normal > 0 and size > 0 else None
        found.append(FrontPoint(normal, None if here is None else here / size))
    return found
