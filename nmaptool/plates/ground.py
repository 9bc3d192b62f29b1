"""The motif and the frame on the grid of a plate, before lettering and openings."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError
from nmaptool.plates.board import Board
from nmaptool.plates.frame import FrameSize, frame_heights, slope_width
from nmaptool.plates.layout import Layout
from nmaptool.plates.openings import Opening, outer_slope
from nmaptool.plates.profiles import slope
from nmaptool.types.contours import Contours
from nmaptool.types.plate import PlateDesign
from nmaptool.types.relief import Relief


def motif_and_frame(
    relief: Relief, layout: Layout, design: PlateDesign, board: Board, edge: Contours, openings: tuple[Opening, ...]
) -> tuple[Float64, FrameSize | None]:
    """Heights of motif and frame at the vertices of a board, and the size of the frame.

    Parameters
    ----------
    relief : Relief
    layout : Layout
    design : PlateDesign
    board : Board
    edge : Contours
        Of the plate without openings, on the grid of the board.
    openings : tuple of Opening
        On the grid of the board.
    """
    z_mm = _motif(relief, layout, design, board)
    inside_mm, band_mm = layout.sizes.frame(design), layout.sizes.band(design)
    if layout.is_cover and band_mm:
        z_mm = _cropped(z_mm, inside_mm + band_mm, board, edge, design.plate.draft)
    if not inside_mm:
        return z_mm, None
    high = design.frame.frame_height
    # an engraving is as deep as the relief, and its frame as high
    top = 0.0 if design.plate.engrave else max(float(z_mm.max()), 0.0)
    top = top or relief.report.relief_range_mm
    height_mm = top if high is None else layout.sizes.mm(high)
    size = FrameSize(inside_mm, height_mm, slope_width(height_mm, design.plate.draft, board.pitch_mm))
    frame_mm, shows = frame_heights(board, edge, design, size)
    if any(each.is_loop for each in openings):
        slope_mm = min(size.slope_mm, inside_mm / 4)
        frame_mm *= outer_slope(board, board.depth_mm(edge, slope_mm + 4 * board.pitch_mm), slope_mm)
    return z_mm * shows + frame_mm, size


def _motif(relief: Relief, layout: Layout, design: PlateDesign, board: Board) -> Float64:
    """Heights of the motif at the vertices of a board, from the surface of the plate."""
    is_plane = relief.report.options.background == "plane"
    z_mm = relief.z_mm if is_plane else relief.z_mm - relief.height.range_mm[0]
    if design.plate.engrave:
        z_mm = -z_mm
    # a background that is not held to a plate continues beyond the picture
    return np.asarray(board_cut(z_mm, board, 1, continues=not is_plane or layout.is_cover), np.float64)


def _cropped(z_mm: Float64, inset_mm: float, board: Board, edge: Contours, draft: float) -> Float64:
    """Heights that run down to the plate at a distance from its edge."""
    slope_mm = slope_width(float(np.abs(z_mm).max()), draft, board.pitch_mm)
    depth_mm = board.depth_mm(edge, inset_mm + slope_mm + 2 * board.pitch_mm)
    return z_mm * slope(depth_mm - (inset_mm + slope_mm / 2), slope_mm, board.pitch_mm)


def board_cut(values: NDArray[Any], board: Board, extra: int, *, continues: bool = False) -> NDArray[Any]:
    """Values of the picture's pixels (``extra`` 0) or vertices (1) on the board: 0 beyond the picture, or continued."""
    rows = values.shape[0] - extra
    top = board.rows - rows - board.bottom
    right = board.cols - (values.shape[1] - extra) - board.left
    pads = [(max(0, top), max(0, board.bottom)), (max(0, board.left), max(0, right))]
    crop = [(max(0, -top), max(0, -board.bottom)), (max(0, -board.left), max(0, -right))]
    cut = tuple(slice(a, size - b) for (a, b), size in zip(crop, values.shape, strict=True))
    kept = values[cut]
    if not kept.size:
        raise InputError("the picture does not reach the plate; use a smaller plate")
    out: NDArray[Any] = np.pad(kept, pads, mode="edge") if continues else np.pad(kept, pads)
    return out
