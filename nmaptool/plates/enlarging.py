"""A motif beside lettering that takes only a part of the edge: as large as the letters themselves allow."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.units import Length
from nmaptool.plates import shapes
from nmaptool.plates.layout import Layout
from nmaptool.plates.letters import Letters
from nmaptool.types.plate import PlateDesign

# the motif may move up or down by this part of the band of letters, in so many places
_PLACES = 17
_HALVINGS = 40
# least gain that is worth a move
_GAIN = 1.005


def enlarged(layout: Layout, motif: Mask, design: PlateDesign, letters: Sequence[Letters]) -> Layout:
    """The layout with a larger motif, where its hull keeps the margin from frame and letters.

    Only for round plates and ovals of a given aspect, whose lettering along the edge is in arcs.

    Parameters
    ----------
    layout : Layout
        With the band of letters free all around.
    motif : (H, W) bool
    design : PlateDesign
    letters : sequence of Letters
        On this layout.
    """
    along = [each for each in letters if each.options.text_path != "line"]
    plate = design.plate
    is_fixed = plate.shape == "round" or (plate.shape == "oval" and plate.proportion is not None)
    if layout.is_cover or not along or not is_fixed or _uses_pixels(design):
        return layout
    if any(each.options.text_path != "arc" for each in along):
        return layout
    margin_mm = layout.sizes.margin(design)
    inset_mm = layout.sizes.frame(design) + margin_mm
    anchor = layout.middle_mm / layout.pitch_mm
    hull = shapes.corner_points(motif) - anchor
    texts = np.concatenate([ring for each in along for ring in each.contours.rings]) - layout.middle_mm
    room = _Room(hull, texts, layout.width_mm / 2 - inset_mm, layout.height_mm / 2 - inset_mm, margin_mm)
    band_mm = layout.sizes.band(design)
    found = [(room.pitch(up, layout.pitch_mm), up) for up in np.linspace(-band_mm, band_mm, _PLACES)]
    # of equal ones, the one nearest to the middle
    pitch_mm, up = max(found, key=lambda each: (round(each[0] / layout.pitch_mm, 4), -abs(each[1])))
    if pitch_mm < _GAIN * layout.pitch_mm:
        return layout
    middle = anchor * pitch_mm - np.array([0.0, up])
    sizes = dataclasses.replace(layout.sizes, pitch_mm=pitch_mm)
    return dataclasses.replace(layout, pitch_mm=pitch_mm, middle_mm=middle, sizes=sizes)


class _Room:
    """What a motif has around it on an oval, in mm from the middle of the plate."""

    def __init__(self, hull: Float64, texts: Float64, across: float, down: float, gap: float) -> None:
        self._hull, self._texts, self._half, self._gap = hull, texts, np.array([across, down]), gap
        edge = np.roll(hull, -1, axis=0) - hull
        # away from the middle of the hull, whichever way it runs
        normal = np.column_stack([edge[:, 1], -edge[:, 0]]) / np.hypot(*edge.T)[:, None]
        sign = np.sign(((hull - hull.mean(axis=0)) * normal).sum(axis=1))
        self._normal = normal * sign[:, None]
        self._reach = (self._normal * hull).sum(axis=1)

    def pitch(self, up: float, least: float) -> float:
        """The largest pixels with which the motif fits, moved up by some mm; 0 if none do."""
        low, high = 0.0, 4 * least
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            low, high = (middle, high) if self._fits(middle, up) else (low, middle)
        return low

    def _fits(self, pitch: float, up: float) -> bool:
        points = self._hull * pitch + (0.0, up)
        if (np.hypot(*(points / self._half).T) > 1).any():
            return False
        # distances from the lines of a convex hull are at most those from the hull
        shift = self._normal[:, 1] * up
        away = self._texts @ self._normal.T - (self._reach * pitch + shift)
        return bool(away.max(axis=1).min() >= self._gap)


def _uses_pixels(design: PlateDesign) -> bool:
    """Whether a length of the design is in pixels of the map, whose size would change."""
    parts = (design.plate, design.frame, *design.texts)
    lengths = (getattr(part, each.name) for part in parts for each in dataclasses.fields(part))
    return any(isinstance(each, Length) and each.unit == "px" for each in lengths)
