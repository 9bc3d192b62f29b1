"""Fewer triangles for a plate with an exact outline: its inner pixels, and the points along its edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.solids.exact.rings import OutlinePoints
from nmaptool.solids.outline import OutlineEdges
from nmaptool.solids.sheet import Sheet
from nmaptool.solids.simplify import Steps
from nmaptool.solids.thinned_sheet import Thinning


class InnerThinning(Thinning):
    """Fewer triangles for the inner pixels, whose outline is joined to strips of triangles.

    Parameters
    ----------
    front : Sheet
    edges : OutlineEdges
        The outline that the strips join, in edges of single pixels.
    back : Sheet, optional
        A curved back, which has a strip of its own.
    bent : (H+1, W+1) bool
        Where the strips are not flat: vertices of the outline stay there.
    kept : (H+1, W+1) bool, optional
        Other vertices that stay.
    """

    def __init__(
        self, front: Sheet, edges: OutlineEdges, back: Sheet | None, bent: Mask, *, kept: Mask | None = None
    ) -> None:
        joined = np.zeros(front.z_mm.shape, bool)
        joined.ravel()[edges.start] = True
        joined &= bent
        super().__init__(front, edges, back, kept=joined if kept is None else joined | kept)
        self._sheets = 1 if back is None else 2

    def steps(self) -> list[Steps]:
        """Tolerances at which vertices come in, and how many triangles each brings."""
        inside, outline = self._thinner.steps()
        # a vertex on the outline splits a triangle of each sheet, and one of each strip
        return [(inside, 2 * self._sheets), (outline, 2 * self._sheets)]

    def fewest(self) -> int:
        """Triangles at any error, with one of each strip for each vertex of the outline."""
        front, edges, back = self.with_mesh(self._thinner.at(np.inf))
        return front.face_count + (0 if back is None else back.face_count) + self._sheets * len(edges.start)


@dataclass(frozen=True, eq=False)
class KeptPoints:
    """Points of an outline that stay.

    Attributes
    ----------
    kept : (n,) bool
    max_error_mm : float
        Largest vertical distance of a point from the line between those that stay.
    """

    kept: Mask
    max_error_mm: float


class PointThinning:
    """Fewer points along the edges of an outline.

    Parameters
    ----------
    points : OutlinePoints
    heights : (n, layers) float64
        Heights at the points and further inside in mm: where a point is left out, all of them are straight.
    faces_each : int
        Triangles that each point brings.
    faces_else : int
        Triangles besides those of points and inner pixels.
    """

    def __init__(self, points: OutlinePoints, heights: Float64, faces_each: int, faces_else: int) -> None:
        self._errors = _errors_of(points, heights)
        self._faces_each, self._faces_else = faces_each, faces_else

    def steps(self) -> list[Steps]:
        """Tolerances at which points come in, and how many triangles each brings."""
        return [(self._errors[np.isfinite(self._errors) & (self._errors > 0)], self._faces_each)]

    def fewest(self) -> int:
        """Triangles at any error."""
        return self._faces_else + self._faces_each * int(np.count_nonzero(np.isinf(self._errors)))

    def at(self, bound_mm: float) -> KeptPoints:
        """The points for a value of `steps`; infinite for the fewest."""
        kept = self._errors > bound_mm if np.isfinite(bound_mm) else np.isinf(self._errors)
        return KeptPoints(kept, float(self._errors[~kept].max(initial=0.0)))

    def within(self, max_error_mm: float) -> KeptPoints:
        """The points for an error."""
        return self.at(max_error_mm)

    def with_mesh(self, mesh: KeptPoints) -> Mask:
        """Which points stay."""
        return mesh.kept


def _errors_of(points: OutlinePoints, heights: Float64) -> Float64:
    """(n,) tolerances in mm up to which each point must stay; infinite for corners.

    An edge has a power of two of pieces. The point in the middle of pieces stays if one of the points between their
    ends lies further from the straight line, or one of the points that need it stays.
    """
    errors = np.full(len(points.segment), np.inf)
    first = np.flatnonzero(points.is_corner)
    pieces = np.diff(first, append=len(points.segment))
    for count in np.unique(pieces[pieces > 1]):
        start = first[pieces == count]
        rows = start[:, None] + np.arange(count)
        z = heights[np.column_stack([rows, points.after[rows[:, -1]]])]
        found = np.zeros((len(start), count))
        width = 2
        while width <= count:
            starts = np.arange(0, count, width)
            parts = z[:, starts[:, None] + np.arange(width + 1)]
            ends = parts[:, :, :1], parts[:, :, -1:]
            line = ends[0] + (np.arange(width + 1) / width)[:, None] * (ends[1] - ends[0])
            off = np.abs(parts - line).max(axis=(2, 3))
            middle = starts + width // 2
            if width > 2:
                for each in (middle - width // 4, middle + width // 4):
                    np.maximum(off, found[:, each], out=off)
            found[:, middle] = off
            width *= 2
        errors[rows[:, 1:]] = found[:, 1:]
    return errors
