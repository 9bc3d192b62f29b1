"""Two ways of rebuilding judged by their curves of vertex deviation over normal deviation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

# a point of a curve: normal deviation, vertex deviation
Point = tuple[float, float]


def front(points: Sequence[Point]) -> list[Point]:
    """The points that no other beats in both, by rising normal deviation."""
    kept: list[Point] = []
    for point in sorted(points):
        if not kept or point[1] < kept[-1][1]:
            kept.append(point)
    return kept


def reached(curves: Sequence[Sequence[Point]], normal: float) -> float | None:
    """The least vertex deviation at a normal deviation of at most ``normal``, between points of a front by logarithms.

    None where no curve comes down to it.
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
    """A point of the rival's front: its normal deviation, and our vertex deviation there over its own.

    None where we do not come down to that normal deviation.
    """

    normal: float
    ratio: float | None


def compare_fronts(ours: Sequence[Sequence[Point]], rival: Sequence[Point]) -> list[FrontPoint]:
    """Each point of the rival's front, with the least that any of our curves has there."""
    found = []
    for normal, size in front(rival):
        here = reached(ours, normal) if normal > 0 and size > 0 else None
        found.append(FrontPoint(normal, None if here is None else here / size))
    return found
