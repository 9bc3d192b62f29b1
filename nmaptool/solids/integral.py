"""The volume between a sheet and height 0."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.solids.outline import CORNERS, corner_nodes
from nmaptool.solids.shape import pixels_touching
from nmaptool.solids.sheet import Sheet

_BAND_ROWS = 256


def volume_below(sheet: Sheet) -> float:
    """The integral of the heights of a sheet over its shape in mm3, for the diagonals along which its pixels are split.

    It is computed pixel by pixel from the heights, without the triangles.
    """
    mask = sheet.shape.mask
    beside = pixels_touching(sheet.shape.moved, sheet.shape)
    total = 0.0
    for top in range(0, len(mask), _BAND_ROWS):
        end = min(top + _BAND_ROWS, len(mask))
        plain = mask[top:end] & ~beside[top:end]
        z = sheet.z_mm[top : end + 1]
        falling_ends, rising_ends = z[:-1, :-1] + z[1:, 1:], z[:-1, 1:] + z[1:, :-1]
        # the corners at the ends of the diagonal belong to both triangles
        sums = falling_ends + rising_ends + np.where(sheet.falls(top, end), falling_ends, rising_ends)
        total += float(sums[plain].sum()) / 6
    return (total + _moved_volume(sheet)) * sheet.placing.pitch_mm**2


def _moved_volume(sheet: Sheet) -> float:
    """The same over the pixels with a moved corner, in px2 mm."""
    shape = sheet.shape
    row, col = np.nonzero(pixels_touching(shape.moved, shape))
    if not len(row):
        return 0.0
    cols = shape.mask.shape[1]
    nodes = {corner: corner_nodes(row, col, cols, shape.splits, corner) for corner in CORNERS}
    place = {corner: shape.places_px(each) for corner, each in nodes.items()}
    z = {corner: sheet.z_of(each) for corner, each in nodes.items()}
    falls = sheet.falls_at(row, col)
    falling, rising = (("nw", "sw", "se"), ("nw", "se", "ne")), (("nw", "sw", "ne"), ("sw", "se", "ne"))
    pairs = [(corners, falls) for corners in falling] + [(corners, ~falls) for corners in rising]
    return sum(
        _prisms([place[corner][chosen] for corner in corners], [z[corner][chosen] for corner in corners])
        for corners, chosen in pairs
    )


def _prisms(places_px: list[Float64], z_mm: list[Float64]) -> float:
    """Volume of prisms below triangles, from the places (y down) and heights of their three corners."""
    a, b, c = places_px
    area = ((c - a)[:, 0] * (b - a)[:, 1] - (c - a)[:, 1] * (b - a)[:, 0]) / 2
    return float((area * (z_mm[0] + z_mm[1] + z_mm[2])).sum() / 3)
