"""Closed curves that cross each other, made into clean ones."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Literal

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.types.contours import Contours, ring_area

Rule = Literal["NonZero", "EvenOdd"]


def united(rings: Iterable[Float64], tolerance_mm: float = 0.0) -> Contours:
    """The area that rings enclose with a winding number other than zero, as rings that do not cross.

    Parameters
    ----------
    rings : iterable of (n, 2) float64
        Closed polygons in mm; outer ones run in one direction, holes in the other.
    tolerance_mm : float
        The distance between the polygons and the true curves, for the result.

    Returns
    -------
    Contours
        To 1e-8 mm, the grid of the boolean operation.
    """
    return contours_of(cross_section(rings), tolerance_mm)


def cross_section(rings: Iterable[Float64], rule: Rule = "NonZero") -> Any:
    """A ``manifold3d.CrossSection`` of rings, filled by their winding number or by a rule of the same name."""
    from manifold3d import CrossSection, FillRule

    return CrossSection([np.ascontiguousarray(ring) for ring in rings], getattr(FillRule, rule))


def contours_of(section: Any, tolerance_mm: float) -> Contours:
    """The rings of a ``manifold3d.CrossSection``; those of no area are left out."""
    rings = (np.array(ring, np.float64) for ring in section.to_polygons())
    return Contours(tuple(ring for ring in rings if len(ring) > 2 and ring_area(ring)), tolerance_mm)
