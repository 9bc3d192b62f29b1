"""The outlines of plates, around the origin: rectangle, disc, ellipse, a drawn shape, the outline of a motif."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.errors import InputError
from nmaptool.lettering.rings import united
from nmaptool.plates.polygons import (
    circle,
    circle_tolerance,
    offset,
    outer_rings,
    refined,
    without_short_edges,
)
from nmaptool.types.contours import Contours

# samples of a quarter of an ellipse, from which corners at equal distances are chosen
_SAMPLES = 20000
# edges of a motif's outline shorter than this share of a pixel are left out
_SHORTEST = 1e-2


def disc(diameter_mm: float, spacing_mm: float) -> Contours:
    """A circle."""
    ring = circle(0.0, 0.0, diameter_mm / 2, spacing_mm)
    return Contours((ring,), circle_tolerance(diameter_mm / 2, len(ring)))


def ellipse(width_mm: float, height_mm: float, spacing_mm: float) -> Contours:
    """An ellipse, with corners at equal distances, and closer at its ends if they are sharp."""
    a, b = width_mm / 2, height_mm / 2
    angle = np.linspace(0.0, 2 * np.pi, 4 * _SAMPLES + 1)
    length = np.hypot(np.diff(a * np.cos(angle)), np.diff(b * np.sin(angle)))
    middle = (angle[1:] + angle[:-1]) / 2
    curvature = a * b / np.hypot(a * np.sin(middle), b * np.cos(middle)) ** 3
    # where the curve is sharper than a circle of the same area, edges are shorter, so that they are as near to it
    along = np.concatenate([[0.0], np.cumsum(length * np.sqrt(np.maximum(1.0, curvature * np.sqrt(a * b))))])
    count = 4 * max(12, int(np.ceil(along[-1] / spacing_mm / 4)))  # so that it is exactly as wide and high
    chosen = np.interp(np.arange(count) * along[-1] / count, along, angle)
    ring = np.column_stack([a * np.cos(chosen), b * np.sin(chosen)])
    # farthest from an edge is the point halfway between the angles of its ends
    half = (chosen + np.append(chosen[1:], 2 * np.pi)) / 2
    away = np.column_stack([a * np.cos(half), b * np.sin(half)]) - ring
    edge = np.roll(ring, -1, axis=0) - ring
    distance = np.abs(edge[:, 0] * away[:, 1] - edge[:, 1] * away[:, 0]) / np.hypot(*edge.T)
    return Contours((ring,), float(distance.max()))


def rectangle(width_mm: float, height_mm: float, corner_mm: float, spacing_mm: float) -> Contours:
    """A rectangle with round or sharp corners.

    Raises
    ------
    InputError
        If the corners do not fit.
    """
    a, b = width_mm / 2, height_mm / 2
    if corner_mm > min(a, b):
        raise InputError(
            f"`corner='{corner_mm:.4g}mm'`: the plate is {width_mm:.4g} x {height_mm:.4g} mm, so its corners have a "
            f"radius of {min(a, b):.4g} mm at most"
        )
    if corner_mm == 0:
        return Contours((refined(np.array([[-a, -b], [a, -b], [a, b], [-a, b]]), spacing_mm),))
    count = max(6, int(np.ceil(np.pi / 2 * corner_mm / spacing_mm)))
    quarter = np.linspace(0.0, np.pi / 2, count + 1)
    parts = []
    for turn, (x, y) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        angle = quarter + turn * np.pi / 2
        middle = np.array([x * (a - corner_mm), y * (b - corner_mm)])
        parts.append(middle + corner_mm * np.column_stack([np.cos(angle), np.sin(angle)]))
    ring = np.concatenate(parts)
    ring = ring[np.hypot(*(ring - np.roll(ring, 1, axis=0)).T) > 1e-9]
    tolerance_mm = float(corner_mm * (1 - np.cos(np.pi / 4 / count)))
    return Contours((refined(ring, spacing_mm),), tolerance_mm)


def scaled_to(drawn: Contours, width_mm: float, spacing_mm: float) -> Contours:
    """A drawn shape with a given width, its middle at the origin."""
    low, high = drawn.bounds_mm
    factor = width_mm / (high[0] - low[0])
    middle = (low + high) / 2
    rings = tuple(refined((ring - middle) * factor, spacing_mm) for ring in drawn.rings)
    return Contours(rings, drawn.tolerance_mm * factor)


def motif_outline(motif: Mask, pitch_mm: float, distance_mm: float, spacing_mm: float) -> Contours:
    """The outline of a motif at some distance, without holes, in mm from the lower left corner of the picture.

    Raises
    ------
    InputError
        If the motif has several parts that the distance does not join.
    """
    pixels = offset(pixel_contours(motif, pitch_mm), 1e-3 * pitch_mm)
    # smooth the steps of the pixels: out by more than the distance, then back
    reach_mm = max(2 * pitch_mm, 0.5 * distance_mm)
    found = outer_rings(offset(offset(pixels, distance_mm + reach_mm), -reach_mm))
    if len(found.rings) != 1:
        raise InputError(
            f"`shape='mask'`: the motif has {len(found.rings)} separate parts at a margin of {distance_mm:.4g} mm; a "
            "plate is one piece, so use a larger `margin` or join the parts in the mask"
        )
    ring = without_short_edges(found.rings[0], _SHORTEST * pitch_mm)
    return Contours((refined(ring, spacing_mm),), found.tolerance_mm)


def pixel_contours(motif: Mask, pitch_mm: float) -> Contours:
    """The outline of the pixels of a motif, in mm from the lower left corner of the picture."""
    import cv2

    # contours of a picture at twice the size run through the middles of its pixels, half a pixel inside
    doubled = np.kron(motif.astype(np.uint8), np.ones((2, 2), np.uint8))
    found, _ = cv2.findContours(doubled, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    rows = motif.shape[0]
    rings = []
    for each in found:
        points = each[:, 0].astype(np.float64)
        if len(points) < 3:
            continue
        x, y = (points[:, 0] + 0.5) / 2, rows - (points[:, 1] + 0.5) / 2
        rings.append(np.column_stack([x, y]) * pitch_mm)
    if not rings:
        raise InputError("`shape='mask'`: the motif is empty or smaller than a pixel")
    inner = united(rings)
    return offset(inner, pitch_mm / 4, is_sharp=True)


def corner_points(motif: Mask) -> Float64:
    """(n, 2) corners of the convex hull of a motif in px, from the lower left corner of the picture, y up."""
    import cv2

    rows, cols = motif.shape
    found_rows = np.flatnonzero(motif.any(axis=1))
    first, last = motif.argmax(axis=1)[found_rows], cols - motif[:, ::-1].argmax(axis=1)[found_rows]
    x = np.concatenate([first, first, last, last])
    y = np.concatenate([found_rows, found_rows + 1, found_rows, found_rows + 1])
    hull = cv2.convexHull(np.column_stack([x, y]).astype(np.int32))[:, 0].astype(np.float64)
    return np.column_stack([hull[:, 0], rows - hull[:, 1]])
