"""The exact outline of a plate as points: its corners, and points between them where an edge is longer than a pixel."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.errors import InputError
from nmaptool.types.contours import Contours, ring_area
from nmaptool.types.height import Height
from nmaptool.types.solid import Nodes

_NEAREST_MM = 1e-5


@dataclass(frozen=True, eq=False)
class OutlinePoints:
    """Points along closed rings, ring after ring.

    Attributes
    ----------
    xy_mm : (n, 2) float64
        From the lower left corner of the picture, y up.
    segment : (n,) int64
        Number of the corner at each point, or of the last one before it; each ring begins with a corner.
    ring_of : (c,) int64
        Number of the ring of each corner.
    """

    xy_mm: Float64
    segment: Nodes
    ring_of: Nodes

    @cached_property
    def is_corner(self) -> Mask:
        """(n,) bool: corners of the outline."""
        return np.diff(self.segment, prepend=-1) > 0

    @cached_property
    def after(self) -> Nodes:
        """(n,) int64: the next point of the ring."""
        return _next_of(self.ring_of[self.segment])

    @cached_property
    def corner_after(self) -> Nodes:
        """(c,) int64: the next corner of the ring."""
        return _next_of(self.ring_of)

    @property
    def rings(self) -> list[Float64]:
        """The points of each ring."""
        return np.split(self.xy_mm, np.flatnonzero(np.diff(self.ring_of[self.segment])) + 1)

    def chosen(self, kept: Mask) -> OutlinePoints:
        """Some of the points, with all corners among them."""
        return dataclasses.replace(self, xy_mm=self.xy_mm[kept], segment=self.segment[kept])


def outline_points(outline: Contours, height: Height) -> OutlinePoints:
    """The corners of an outline, and so many points between them that they are at most a pixel apart.

    An edge is divided into a power of two of equal pieces.

    Parameters
    ----------
    outline : Contours
    height : Height
        The outline must lie within its picture.

    Raises
    ------
    InputError
        If there is not one outer ring, or it leaves the picture, or it is too small or touches itself.
    """
    rings = [_without_near(ring, _nearest_mm(outline)) for ring in outline.rings]
    _check_rings(rings, height)
    corners = np.concatenate(rings)
    ring_of = np.repeat(np.arange(len(rings)), [len(ring) for ring in rings])
    ends = corners[_next_of(ring_of)]
    length_px = np.hypot(*(ends - corners).T) / height.pitch_mm
    pieces = 1 << np.ceil(np.log2(np.maximum(length_px - 1e-9, 1.0))).astype(np.int64)
    segment = np.repeat(np.arange(len(corners)), pieces)
    step = np.arange(len(segment)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    share = (step / pieces[segment])[:, None]
    xy_mm = corners[segment] + share * (ends - corners)[segment]
    _check_distinct(xy_mm, _nearest_mm(outline))
    return OutlinePoints(xy_mm, segment, ring_of)


def _next_of(group: Nodes) -> Nodes:
    """For each element of groups that follow one another, the next of the same group; the first follows the last."""
    starts = np.flatnonzero(np.diff(group, prepend=-1))
    after = np.arange(1, len(group) + 1)
    after[np.append(starts[1:], len(group)) - 1] = starts
    return after


def _nearest_mm(outline: Contours) -> float:
    """How near two corners may be: files hold coordinates in single precision."""
    return max(_NEAREST_MM, 4 * float(np.spacing(np.float32(np.abs(outline.bounds_mm).max()))))


def _without_near(ring: Float64, nearest_mm: float) -> Float64:
    """A ring without the corners that are too near to the one before."""
    if (np.hypot(*(ring - np.roll(ring, 1, axis=0)).T) >= nearest_mm).all():
        return ring
    kept = [0]
    for number in range(1, len(ring)):
        if np.hypot(*(ring[number] - ring[kept[-1]])) >= nearest_mm:
            kept.append(number)
    if np.hypot(*(ring[kept[-1]] - ring[0])) < nearest_mm:
        kept.pop()
    if len(kept) < 3:
        raise InputError(f"a ring of the outline is smaller than {nearest_mm:.1g} mm; leave it out")
    return ring[kept]


def _check_rings(rings: Sequence[Float64], height: Height) -> None:
    outer = sum(ring_area(ring) > 0 for ring in rings)
    if outer != 1:
        raise InputError(
            f"the outline has {outer} outer rings, which run counter-clockwise; a plate needs one, and any holes "
            "clockwise"
        )
    points = np.concatenate(rings)
    low, high = points.min(axis=0), points.max(axis=0)
    rows, cols = height.frame.shape
    size = np.array([cols, rows]) * height.pitch_mm
    off = max(float(-low.min()), float((high - size).max()))
    if off > 1e-9 * size.max():
        raise InputError(
            f"the outline lies {off:.4g} mm outside of the heights, which are {size[0]:.4g} x {size[1]:.4g} mm; give "
            "heights at least one pixel beyond the outline"
        )


def _check_distinct(xy_mm: Float64, nearest_mm: float) -> None:
    """Refuse rings that meet in a point."""
    single = xy_mm.astype(np.float32)
    order = np.lexsort(single.T)
    same = (single[order[1:]] == single[order[:-1]]).all(axis=1)
    if same.any():
        x, y = xy_mm[order[1:][same][0]]
        raise InputError(
            f"the outline touches itself at x = {x:.6g} mm, y = {y:.6g} mm; keep its parts at least "
            f"{nearest_mm:.1g} mm apart"
        )
