"""Height fields in millimetres."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float64, Mask, read_only
from nmaptool.core.errors import InputError
from nmaptool.core.grid import corner_mean, touching_vertices
from nmaptool.types.contours import Contours
from nmaptool.types.picture import Frame
from nmaptool.types.shown import Pictured

DEFAULT_LONGER_SIDE_MM = 100.0


@dataclass(frozen=True, eq=False, repr=False)
class Height(Pictured):
    """Heights in millimetres at the corners of the pixels.

    Parameters
    ----------
    z_mm : (H+1, W+1) float64
        Heights at vertices; 0 at vertices that touch no pixel of the domain.
    domain : (H, W) bool
        Pixels (faces) that belong to the surface.
    frame : Frame
        Size; the pitch must be known.
    raised : (H, W) bool, optional
        Pixels of a motif that stands on its plate with vertical walls. The vertices along its outline have the height
        of the motif; the pixels around it lie at height 0 there.
    outline : Contours, optional
        Exact outline of a plate: one outer ring and any holes, in mm from the lower left corner of the grid. The domain
        is then the pixels whose centres lie inside, and heights are given at all vertices: at least one pixel beyond
        the outline, where they continue those inside.
    """

    z_mm: Float64
    domain: Mask
    frame: Frame
    raised: Mask | None = None
    outline: Contours | None = None

    def __post_init__(self) -> None:
        rows, cols = self.frame.shape
        if self.frame.pitch_mm is None:
            raise InputError("a height field needs a pixel size in mm; set pitch_mm of its frame")
        if self.z_mm.shape != (rows + 1, cols + 1) or self.z_mm.dtype != np.float64:
            raise InputError(
                f"heights are {self.z_mm.dtype} {self.z_mm.shape}, expected float64 {(rows + 1, cols + 1)}"
            )
        if self.domain.shape != (rows, cols) or self.domain.dtype != np.bool_:
            raise InputError(f"domain is {self.domain.dtype} {self.domain.shape}, expected bool {(rows, cols)}")
        if self.raised is not None and (self.raised.shape != (rows, cols) or self.raised.dtype != np.bool_):
            raise InputError(f"raised is {self.raised.dtype} {self.raised.shape}, expected bool {(rows, cols)}")
        if self.raised is not None and self.outline is None and not self.domain.all():
            raise InputError("a raised motif stands on a plate: the domain must be the whole picture")
        if not np.all(np.isfinite(self.z_mm)):
            raise InputError("heights must be finite")
        if not self.domain.any():
            raise InputError("the domain of the height field is empty")
        object.__setattr__(self, "z_mm", read_only(self.z_mm))
        object.__setattr__(self, "domain", read_only(self.domain))
        if self.raised is not None:
            object.__setattr__(self, "raised", read_only(self.raised))

    @property
    def pitch_mm(self) -> float:
        """Millimetres per pixel."""
        assert self.frame.pitch_mm is not None  # checked at construction
        return self.frame.pitch_mm

    @property
    def vertex_mask(self) -> Mask:
        """(H+1, W+1) bool: vertices that touch the domain."""
        return touching_vertices(self.domain)

    @property
    def range_mm(self) -> tuple[float, float]:
        """Heights of the lowest and the highest vertex of the domain."""
        inside = self.z_mm[self.vertex_mask]
        return float(inside.min()), float(inside.max())

    def plate_mm(self) -> Float64:
        """(H+1, W+1) float64 heights around a raised motif: 0 along its outline."""
        return self.z_mm if self.raised is None else np.where(touching_vertices(self.raised), 0.0, self.z_mm)

    def at_pixels(self) -> Float64:
        """(H, W) float64 heights in mm at pixel centres (mean of the corners), NaN outside the domain."""
        centre = corner_mean(self.z_mm)
        if self.raised is not None:
            centre[~self.raised] = corner_mean(self.plate_mm())[~self.raised]
        centre[~self.domain] = np.nan
        return centre

    def _line(self) -> str:
        rows, cols = self.frame.shape
        low, high = self.range_mm
        size = f"{cols * self.pitch_mm:.4g} x {rows * self.pitch_mm:.4g} mm"
        return f"{size} ({self.frame} px), {low:.4g} to {high:.4g} mm high"
