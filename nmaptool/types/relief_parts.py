"""The two parts of a relief's heights."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.types.picture import Frame
from nmaptool.types.shown import OneLine


@dataclass(frozen=True, eq=False, repr=False)
class ReliefParts(OneLine):
    """Heights z = base + h0 + delta h1, in px, for every delta (paper, Eqs. 6 and 8 are linear in delta).

    Attributes
    ----------
    first_px : (H+1, W+1) float64
        h0: heights above the background for delta 0. Do not write to it.
    second_px : (H+1, W+1) float64
        h1: what a delta of one pixel of this picture adds. Do not write to it.
    base_px : (H+1, W+1) float64 or None
        Heights of a curved background; None is 0.
    surface : (H, W) bool
        Pixels that belong to the relief.
    frame : Frame
    pitch_mm : float
    px_per_delta : float
        Pixels of this picture per unit of ``ReliefOptions.delta``.
    """

    first_px: Float64
    second_px: Float64
    base_px: Float64 | None
    surface: Mask
    frame: Frame
    pitch_mm: float
    px_per_delta: float

    def z_mm(self, delta: float, scale: float = 1.0) -> Float64:
        """Return the (H+1, W+1) heights in mm.

        Parameters
        ----------
        delta : float
            As ``ReliefOptions.delta``.
        scale : float
            Factor on all heights above the background.
        """
        above = self.first_px + (delta * self.px_per_delta) * self.second_px
        above *= scale
        if self.base_px is not None:
            above += self.base_px
        return np.asarray(above * self.pitch_mm)

    def _line(self) -> str:
        return f"{self.frame.cols} x {self.frame.rows} px, {self.pitch_mm:.4g} mm per px"
