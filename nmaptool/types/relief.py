"""A relief: heights, and the report of how they were solved."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from nmaptool.core.arrays import Float32, Float64, Mask
from nmaptool.options import ReliefOptions
from nmaptool.types.height import Height
from nmaptool.types.plate import PlateReport
from nmaptool.types.report import Report
from nmaptool.types.shown import Pictured, counted

# a motif of which more is flat is likely architecture or lettering: figures have 0.15 at most, facades 0.45 or more
MOSTLY_FLAT = 0.35


@dataclass(frozen=True, eq=False, repr=False)
class ReliefReport(Report):
    """How a relief was solved.

    Attributes
    ----------
    options : ReliefOptions
        The options given.
    pitch_mm, pitch_from : float, str
        Size of a pixel, and whether it was ``given``, in the ``file`` or ``assumed``.
    mu, beta_px, delta_px, reach_px, reach_mm : float
        Parameters of the solve, in pixels of this picture. The reach is sqrt(k/beta), where k is the weight of the
        slopes (1 + mu, or 1 with "eq4"), without weight maps.
    px_per_delta : float
        Pixels of this picture per unit of ``options.delta``.
    solver, unknowns, islands, floating_islands, iterations, residual, history
        The solve. The residual is relative, the largest over the islands. There are no iterations if a session already
        had the heights.
    planned_bytes : int
        Memory that the solver was estimated to need.
    height_min_mm, height_max_mm, height_range_mm : float
        Over the vertices of the surface.
    relief_range_mm : float
        Height range measured from the background, which --height sets.
    below_background_share : float
        Share of the foreground's vertices below a held background; 0 if no background is held.
    foreground_share, steep_share : float
        Share of the picture that is foreground; share of the active pixels whose slope was capped.
    edge : str
        "wall" where the motif stands on its plate with vertical walls, else "blend".
    edge_height_mm : float
        Mean height of these walls; 0 for "blend".
    flat_share : float
        Share of the motif whose normals lie within ten degrees of the viewer.
    scale : float
        Factor on all heights (``fit="scale"``) or on the slopes (``fit="slope"``).
    seconds : mapping of str to float
        Time by stage: ``inputs`` (to a linear system), ``setup`` (of the solver), ``solve``, ``finish`` (to
        millimetres).
    warnings : tuple of str
    """

    options: ReliefOptions
    pitch_mm: float
    pitch_from: str
    mu: float
    beta_px: float
    delta_px: float
    px_per_delta: float
    reach_px: float
    reach_mm: float
    solver: str
    unknowns: int
    islands: int
    floating_islands: int
    iterations: int
    residual: float
    history: tuple[float, ...]
    height_min_mm: float
    height_max_mm: float
    height_range_mm: float
    relief_range_mm: float
    below_background_share: float
    foreground_share: float
    steep_share: float
    scale: float
    edge: str = "blend"
    edge_height_mm: float = 0.0
    flat_share: float = 0.0
    planned_bytes: int = 0
    seconds: dict[str, float] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Plain values for JSON; an infinite reach becomes None."""
        out = super().to_dict()
        for key in ("reach_px", "reach_mm"):
            out[key] = out[key] if math.isfinite(out[key]) else None
        return out


@dataclass(frozen=True, eq=False, repr=False)
class Relief(Pictured):
    """A relief: its heights, its foreground, and the report of the solve.

    Attributes
    ----------
    height : Height
        Heights in mm at vertices, the surface's pixels, the frame.
    foreground : (H, W) bool
        The pixels of the motif.
    report : ReliefReport
    coverage : (H, W) float32 or None
        Share of each pixel that is motif; None where it is not known.
    plate : PlateReport or None
        How the plate was made that the relief is on; None without a plate.
    """

    height: Height
    foreground: Mask
    report: ReliefReport
    coverage: Float32 | None = None
    plate: PlateReport | None = None

    @property
    def z_mm(self) -> Float64:
        """(H+1, W+1) float64 heights in mm at the corners of the pixels."""
        return self.height.z_mm

    @property
    def mask(self) -> Mask:
        """(H, W) bool: pixels of the surface."""
        return self.height.domain

    @property
    def pitch_mm(self) -> float:
        """Millimetres per pixel."""
        return self.height.pitch_mm

    def _line(self) -> str:
        report = self.report
        return f"{self.height._line()}, by {report.solver} in {counted(report.iterations, 'iteration')}"
