"""The smallest circles, ellipses and drawn shapes that hold a motif."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.plates.distance import Curves, inside_grid, inside_points
from nmaptool.plates.polygons import offset, outer_rings
from nmaptool.types.contours import Contours

_HALVINGS = 48
# raster that the middle of a drawn field is searched on, how often it is searched on a finer one, and differences that
# its steps explain
_RASTER = 64
_ZOOMS = 4
_LEVEL = 0.05


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
    curves = Curves(contours, float((high - low).max()) / _RASTER)
    for _ in range(_ZOOMS):
        x, y = np.linspace(low[0], high[0], _RASTER), np.linspace(low[1], high[1], _RASTER)
        points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        away = np.where(inside_grid(contours, x, y).ravel(), curves.nearest(points).distance_mm, 0.0)
        step = float((high - low).max()) / (_RASTER - 1)
        best: Float64 = points[away.argmax()]
        if _is_level(points, away, step):
            break
        low, high = best - 2 * step, best + 2 * step
    # several points may be equally far, such as along the middle of a bar: their middle, if it is one of them
    level: Float64 = points[away > away.max() - _LEVEL * step].mean(axis=0)
    inside = bool(inside_points(contours, level[None])[0])
    far = inside and float(curves.nearest(level[None]).distance_mm[0]) >= away.max() - _LEVEL * step
    return level if far else best


def _is_level(points: Float64, away: Float64, step: float) -> bool:
    """Whether points that lie far apart are equally far from the outline."""
    return bool((np.ptp(points[away > away.max() - _LEVEL * step], axis=0) > 3 * step).any())


def drawn_scale(drawn: Drawn, points: Float64, inset: float) -> float:
    """The largest factor on a convex polygon around the origin with which it fits into the field of a drawn shape.

    The polygon grows until a corner of the field touches one of its edges, or one of its corners an edge of the field.

    Parameters
    ----------
    drawn : Drawn
    points : (n, 2) float64
        Corners in order, in either direction; the origin may lie on an edge.
    inset : float
        Of the field.

    Returns
    -------
    float
        0 if nothing is left of the field.
    """
    found = drawn.field(inset)
    if found is None:
        return 0.0
    field, middle = found
    rings = [ring - middle for ring in field.rings]
    return min(_to_corners(points, np.concatenate(rings)), *(_to_edges(points, ring) for ring in rings))


def _to_corners(points: Float64, corners: Float64) -> float:
    """The least factor with which a convex polygon reaches one of some corners."""
    edge = np.roll(points, -1, axis=0) - points
    normal = np.column_stack([edge[:, 1], -edge[:, 0]])
    reach = (normal * points).sum(axis=1)
    normal, reach = normal * np.sign(reach.sum()), reach * np.sign(reach.sum())
    # a corner outside an edge that the origin lies on is never reached
    distance = corners @ normal.T
    tiny = 1e-12 * float(np.abs(reach).max())
    factor = np.where(reach > tiny, distance / np.maximum(reach, tiny), np.where(distance > 0, np.inf, 0.0))
    return float(factor.max(axis=1).min())


def _to_edges(points: Float64, ring: Float64) -> float:
    """The least factor with which a corner of a polygon reaches an edge of a ring, along the ray from the origin."""
    start, way = ring[:, None], (np.roll(ring, -1, axis=0) - ring)[:, None]
    turn = points[:, 0] * way[..., 1] - points[:, 1] * way[..., 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = (start[..., 0] * way[..., 1] - start[..., 1] * way[..., 0]) / turn
        share = (start[..., 0] * points[:, 1] - start[..., 1] * points[:, 0]) / turn
    hit = (factor > 0) & (share >= 0) & (share <= 1)
    return float(np.where(hit, factor, np.inf).min())
