"""Rectangles of sheets, whose vertices, heights and diagonals are those of the whole."""

from __future__ import annotations

import dataclasses

import numpy as np

from nmaptool.core.arrays import Mask
from nmaptool.solids.cutting.whole import PartFrame
from nmaptool.solids.pieces import cropped
from nmaptool.solids.sheet import Placing, Sheet
from nmaptool.types.parts import PlannedPart
from nmaptool.types.solid import Nodes


def cropped_sheet(
    sheet: Sheet, mask: Mask, top: int, left: int, placing: Placing, first_node: int = 0, within: Mask | None = None
) -> Sheet:
    """A rectangle of a sheet.

    Parameters
    ----------
    sheet : Sheet
    mask : (h, w) bool
        Pixels of the sheet that belong to it.
    top, left : int
        Its upper left corner in the sheet.
    placing : Placing
        Of the rectangle.
    first_node : int
    within : (h, w) bool, optional
        Pixels whose moved nodes and diagonals belong to it, too. Default: the mask.

    Returns
    -------
    Sheet
        Pixels along its sides keep the diagonals that they have in the whole.
    """
    shape, at = cropped(sheet.shape, mask, top, left, within)
    rows, cols = mask.shape
    known = sheet.z_of_moved[at] if len(at) else np.zeros(0)
    side = _along_sides(mask if within is None else within)
    forced = np.union1d(shape.forced, side)
    falls = sheet.falls_at(forced // cols + top, forced % cols + left)
    return Sheet(
        np.ascontiguousarray(sheet.z_mm[top : top + rows + 1, left : left + cols + 1]),
        dataclasses.replace(shape, forced=forced, forced_falls=falls),
        placing,
        sheet.facing,
        first_node,
        known,
    )


def _along_sides(mask: Mask) -> Nodes:
    """Pixels ``row * w + col`` of a mask in its first and last rows and columns."""
    edge = np.zeros(mask.shape, bool)
    edge[[0, -1]] = True
    edge[:, [0, -1]] = True
    return np.flatnonzero(edge & mask)


def cut_vertices(whole: PartFrame, part: PlannedPart, top: int, left: int, shape: tuple[int, int]) -> Mask:
    """(h+1, w+1) bool: vertices on the lines between a part and its neighbours.

    Parameters
    ----------
    whole : PartFrame
    part : PlannedPart
    top, left : int
        Upper left corner of the pixels in the whole.
    shape : (int, int)
        Their rows and columns.
    """
    rows, cols = shape
    on = np.zeros((rows + 1, cols + 1), bool)
    for line, end in ((part.top, whole.frame.rows), (part.bottom, whole.frame.rows)):
        if 0 < line < end and 0 <= line - top <= rows:
            on[line - top] = True
    for line, end in ((part.left, whole.frame.cols), (part.right, whole.frame.cols)):
        if 0 < line < end and 0 <= line - left <= cols:
            on[:, line - left] = True
    return on
