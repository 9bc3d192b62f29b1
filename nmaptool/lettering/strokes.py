"""How thin the strokes of letters are, and how narrow their counters."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.lettering.rings import contours_of, cross_section
from nmaptool.types.contours import Contours, ring_area

_THINNEST = 0.05  # the part of the outline whose strokes may be thinner: tips and corners
_MOST_SAMPLES = 4000
_CHUNK = 1_000_000


def thinnest_stroke_mm(contours: Contours) -> float:
    """Width of the thin strokes of letters in mm: 5% of the outline have thinner ones, such as tips.

    The width at a point of the outline is the distance straight across to the other side. Infinite without contours.

    >>> bar = Contours((np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 0.3], [0.0, 0.3]]),))
    >>> round(thinnest_stroke_mm(bar), 6)
    0.3
    """
    found = [_widths(part) for part in _parts(contours)]
    if not found:
        return math.inf
    widths = np.concatenate([widths for widths, _ in found])
    weights = np.concatenate([np.full(len(widths), step) for widths, step in found])
    order = np.argsort(widths)
    reached = np.cumsum(weights[order])
    return float(widths[order][np.searchsorted(reached, _THINNEST * reached[-1])])


def narrowest_counter_mm(contours: Contours) -> float:
    """Diameter in mm of the greatest circle in the smallest closed counter of the letters; infinite without counters.

    >>> square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    >>> round(narrowest_counter_mm(Contours((square * 2, square[::-1] + 1))), 2)
    4.0
    """
    return min((_greatest_circle(ring[::-1]) for ring in contours.rings if ring_area(ring) < 0), default=math.inf)


def _greatest_circle(ring: Float64) -> float:
    """Diameter of the greatest circle in a ring: it vanishes when it is offset inwards by the radius."""
    from manifold3d import JoinType

    section = cross_section([ring])
    low, high = 0.0, float(np.ptp(ring, axis=0).min()) / 2
    while high - low > 1e-4 * high:
        middle = (low + high) / 2
        low, high = (low, middle) if section.offset(-middle, JoinType.Miter).is_empty() else (middle, high)
    return low + high


def _parts(contours: Contours) -> Iterator[tuple[Float64, ...]]:
    """The rings of each connected part."""
    if contours.rings:
        for part in cross_section(contours.rings).decompose():
            yield contours_of(part, 0.0).rings


def _widths(rings: tuple[Float64, ...]) -> tuple[Float64, float]:
    """Distances across at points spread evenly over the outline of a part, and the length that each stands for."""
    begins = np.concatenate(rings)
    ends = np.concatenate([np.roll(ring, -1, axis=0) for ring in rings])
    edges = ends - begins
    lengths = np.hypot(edges[:, 0], edges[:, 1])
    reached = np.cumsum(lengths)
    x, y = begins.T
    area = float((x * ends[:, 1] - ends[:, 0] * y).sum() / 2)
    # a quarter of the mean stroke
    count = int(np.clip(2 * reached[-1] ** 2 / max(area, 1e-12), 16, _MOST_SAMPLES))
    places = (np.arange(count) + 0.5) * reached[-1] / count
    at = np.minimum(np.searchsorted(reached, places), len(edges) - 1)
    units = edges / np.where(lengths > 0, lengths, 1.0)[:, None]
    points = ends[at] - units[at] * (reached[at] - places)[:, None]
    # the area lies to the left of every ring
    normals = np.stack([-units[at, 1], units[at, 0]], axis=1)
    rows = max(_CHUNK // len(edges), 1)
    widths = [
        _across(points[i : i + rows], normals[i : i + rows], at[i : i + rows], begins, edges)
        for i in range(0, count, rows)
    ]
    return np.concatenate(widths), float(reached[-1] / count)


def _across(points: Float64, normals: Float64, own: np.ndarray, begins: Float64, edges: Float64) -> Float64:
    """Distance from each point along its normal to the first edge other than its own; infinite if there is none."""
    away = begins[None] - points[:, None]
    turn = normals[:, None, 0] * edges[None, :, 1] - normals[:, None, 1] * edges[None, :, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = (away[..., 0] * edges[None, :, 1] - away[..., 1] * edges[None, :, 0]) / turn
        part = (away[..., 0] * normals[:, None, 1] - away[..., 1] * normals[:, None, 0]) / turn
    hit = (distance > 0) & (part >= 0) & (part <= 1)
    hit[np.arange(len(points)), own] = False
    return np.asarray(np.where(hit, distance, np.inf).min(axis=1), np.float64)
