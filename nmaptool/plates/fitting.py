"""The smallest circles, ellipses and drawn shapes that hold a motif."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError
from nmaptool.plates.distance import Curves, inside_grid, inside_points
from nmaptool.plates.polygons import offset, outer_rings
from nmaptool.types.contours import Contours

_HALVINGS = 48
# raster that the middle of a drawn field is searched on
_RASTER = 200
# points on each side of a motif's hull
_POINTS = 12


def enclosing_circle(points: Float64) -> tuple[Float64, float]:
    """Middle and radius of the smallest circle around (n, 2) points."""
    import cv2

    middle, radius = cv2.minEnclosingCircle(points.astype(np.float32))
    centre = np.array(middle, np.float64)
    return centre, float(max(radius * (1 - 1e-6), np.hypot(*(points - centre).T).max()))


def ellipse_for(points_mm: Float64, inset_mm: float, aspect: float | None, own: float) -> tuple[float, float]:
    """Width and height of the smallest ellipse whose field, ``inset_mm`` from the edge, holds points around its middle.

    Parameters
    ----------
    points_mm : (n, 2) float64
    inset_mm : float
    aspect : float or None
        Width by height of the ellipse. None: its inside has the aspect ``own``.
    own : float
    """
    if aspect is None:
        b = float(np.hypot(points_mm[:, 0] / own, points_mm[:, 1]).max())
        return 2 * (own * b + inset_mm), 2 * (b + inset_mm)

    def holds(b: float) -> bool:
        across, down = aspect * b - inset_mm, b - inset_mm
        return min(across, down) > 0 and bool((np.hypot(points_mm[:, 0] / across, points_mm[:, 1] / down) <= 1).all())

    low = inset_mm / min(aspect, 1.0)
    high = low + 2 * float(np.hypot(*points_mm.T).max()) / min(aspect, 1.0)
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        low, high = (low, middle) if holds(middle) else (middle, high)
    return 2 * aspect * high, 2 * high


class Drawn:
    """A drawn shape, to hold a motif.

    Parameters
    ----------
    contours : Contours
        Of any size.
    """

    def __init__(self, contours: Contours) -> None:
        low, high = contours.bounds_mm
        self.contours = outer_rings(contours).moved(*(-(low + high) / 2).tolist())
        self.size: Float64 = high - low
        self._fields: dict[float, tuple[Contours, Float64] | None] = {}

    def field(self, inset: float) -> tuple[Contours, Float64] | None:
        """The shape moved inwards, and the middle of its largest inner circle; None if nothing is left."""
        if inset not in self._fields:
            found = outer_rings(offset(self.contours, -inset))
            self._fields[inset] = (found, _innermost(found)) if found.rings else None
        return self._fields[inset]

    def field_middle(self, width_mm: float, inset_mm: float) -> Float64:
        """The middle of the field of a plate of this width, from the middle of the plate, in mm."""
        factor = float(width_mm / self.size[0])
        found = self.field(inset_mm / factor)
        assert found is not None
        out: Float64 = found[1] * factor
        return out


def _innermost(contours: Contours) -> Float64:
    """The point farthest from the outline."""
    low, high = contours.bounds_mm
    x, y = np.linspace(low[0], high[0], _RASTER), np.linspace(low[1], high[1], _RASTER)
    inside = inside_grid(contours, x, y)
    points = np.stack(np.meshgrid(x, y), axis=-1)[inside]
    distance = Curves(contours, float((high - low).max()) / _RASTER).nearest(points).distance_mm
    # several points may be equally far: their middle
    best: Float64 = points[distance > distance.max() * (1 - 1e-3)].mean(axis=0)
    return best


def drawn_scale(drawn: Drawn, points: Float64, inset: float) -> float:
    """The largest factor on points around the origin with which they fit into the field of a drawn shape."""
    found = drawn.field(inset)
    if found is None:
        return 0.0
    field, middle = found
    closed = np.concatenate([points, points[:1]])
    share = np.linspace(0, 1, _POINTS, endpoint=False)[:, None, None]
    dense = (closed[:-1] * (1 - share) + closed[1:] * share).reshape(-1, 2)
    low, high = 0.0, 4 * float(drawn.size.max()) / float(np.hypot(*points.T).max())
    for _ in range(_HALVINGS):
        factor = (low + high) / 2
        low, high = (factor, high) if inside_points(field, dense * factor + middle).all() else (low, factor)
    return low


def drawn_for_motif(drawn: Drawn, points_mm: Float64, inset_mm: float) -> float:
    """The factor on a drawn shape with which its field just holds a motif.

    Raises
    ------
    InputError
        If no size does.
    """
    # the factor f holds the motif if the shape of size 1 with an inset of inset / f holds the motif times 1 / f
    low, high = 0.0, 64 * float(np.hypot(*points_mm.T).max() + inset_mm) / float(drawn.size.min())
    for _ in range(_HALVINGS // 2):
        factor = (low + high) / 2
        fits = drawn_scale(drawn, points_mm, inset_mm / factor) >= 1 / factor
        low, high = (low, factor) if fits else (factor, high)
    if drawn_scale(drawn, points_mm, inset_mm / high) < 1 / high:
        raise InputError("the drawn shape is too narrow for the motif; use a wider shape or a smaller `margin`")
    return high
