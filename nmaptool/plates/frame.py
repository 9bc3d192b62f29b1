"""The frame along the edge of a plate: its heights, and how much of the relief shows beside it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError
from nmaptool.plates.board import Board
from nmaptool.plates.patterns import beads, rope
from nmaptool.plates.profiles import Cross, plain_profile, slope
from nmaptool.types.contours import Contours
from nmaptool.types.plate import PlateDesign


@dataclass(frozen=True)
class FrameSize:
    """A frame in mm.

    Attributes
    ----------
    width_mm, height_mm : float
    slope_mm : float
        Width of its inner slope.
    """

    width_mm: float
    height_mm: float
    slope_mm: float


def slope_width(height_mm: float, draft: float, pitch_mm: float) -> float:
    """Width of a slope of some height at a draft in degrees from upright; at least one and a half pixels."""
    return max(height_mm * math.tan(math.radians(draft)), 1.5 * pitch_mm)


def frame_heights(board: Board, outline: Contours, design: PlateDesign, size: FrameSize) -> tuple[Float64, Float64]:
    """Heights of a frame at the vertices of a grid.

    Parameters
    ----------
    board : Board
    outline : Contours
        In mm from the lower left corner of the grid, without holes.
    design : PlateDesign
    size : FrameSize

    Returns
    -------
    z_mm : (rows, cols) float64
    shows : (rows, cols) float64
        Share of the relief that shows: 0 under the frame, 1 inside it.

    Raises
    ------
    InputError
        If the plate is narrower than two frames.
    """
    margin_mm = 2 * board.pitch_mm
    depth_mm = board.depth_mm(outline, size.width_mm + margin_mm)
    if not (depth_mm > size.width_mm).any():
        across, down = outline.bounds_mm[1] - outline.bounds_mm[0]
        raise InputError(
            f"`frame='{design.frame.frame}'`: a frame {size.width_mm:.4g} mm wide leaves nothing inside a plate of "
            f"{across:.4g} x {down:.4g} mm; use a narrower frame"
        )
    cross = Cross(size.width_mm, min(size.slope_mm, size.width_mm / 2), board.pitch_mm)
    clipped = np.maximum(depth_mm, -margin_mm)
    name = design.frame.frame_profile
    if name in ("rope", "bead"):
        share = (rope if name == "rope" else beads)(cross, clipped, board, outline)
    else:
        share = plain_profile(name, design.profile if design.frame.is_drawn else None, cross, clipped)
    shows = slope(clipped - (size.width_mm - cross.slope_mm / 2), cross.slope_mm, board.pitch_mm)
    return share * size.height_mm, shows
