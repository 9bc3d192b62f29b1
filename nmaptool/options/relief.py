"""Options for solving a relief."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from nmaptool.core.errors import UsageError
from nmaptool.core.units import Length, memory
from nmaptool.options.fields import Options, choice_of, option
from nmaptool.options.kinds import LARGEST_WEIGHT, Count, Numeric, Positive, Switch, Text, Weight
from nmaptool.options.length_kinds import LengthText

BackgroundMode = Literal["plane", "free", "cut", "surface"]
Energy = Literal["eq6", "eq4"]
Fit = Literal["scale", "slope", "delta"]
Edge = Literal["blend", "wall", "auto"]
SolverName = Literal["auto", "dct", "multigrid", "amg"]

SMALLEST_BETA = 1e-9
_LARGEST_SLOPE = 1e4


@dataclass(frozen=True)
class ReliefOptions(Options, group="Relief"):
    """How a relief is solved from one or two normal maps.

    mu, beta and delta refer to a picture of 1000 px on its longer side, so the same settings give the same shape at
    every resolution. --per-pixel uses them unscaled.

    Parameters
    ----------
    mu:
        Weight of the detail map: 0.1 adds crispness, 1 exaggerates. Has no effect without a detail map.
    beta:
        How strongly every point of the motif is pulled towards the height delta. Smaller is rounder, larger is flatter:
        on a picture of 1000 px, 0.0001 keeps forms of 100 px, 0.001 of 32 px, 0.01 of 10 px. With 0, the map alone
        decides.
    delta:
        Height that beta pulls the motif towards, in px of a picture of 1000 px. Use a negative height for an engraving.
    background:
        "plane": a flat plate at height 0. "free": the background follows its own normals and is not held. "cut": only
        the motif is made, ending at its silhouette. "surface": the background is held to the curved surface given with
        --surface.
    edge:
        Outline of the motif on a flat plate. "blend": it runs down into the plate, right for figures. "wall": it stands
        as a vertical wall, and the surface behind it is free, right for architecture, lettering and inlays. "auto": a
        wall if more than a third of the motif is flat.
    edge_height:
        Mean height of the wall of --edge wall, such as 2mm. Default: the height of the free surface at its outline.
    outline_round:
        Round the corners of a motif that is cut out (--background cut) to this radius, such as 0.5mm. Parts and gaps
        narrower than twice the radius disappear.
    slope_cap:
        Largest slope (rise per run) to keep. Steeper normals, and those that face away, are reduced to it.
    energy:
        "eq6" averages original and detail: the detail keeps its size and the base is compressed by 1 + mu. "eq4" adds
        mu times the detail to the original.
    per_pixel:
        Measure beta and delta in pixels of this picture instead of one of 1000 px.
    height:
        Exact height from the lowest to the highest point of the relief, such as 3mm. On a curved background, it is
        measured from that background.
    fit:
        How to reach the exact height: "scale" multiplies all heights; "slope" changes the slopes and keeps delta;
        "delta" changes delta and keeps the slopes.
    width:
        Width of the whole picture, such as 100mm. Default: the width stored in the file, otherwise 100 mm on the longer
        side.
    solver:
        "auto" picks the fastest: "dct" (exact) if every pixel is surface and has the same weight, "multigrid" for any
        mask and any weights, "amg" for a few lines on a large picture. Elsewhere, "amg" checks the result by a second
        method; it is slower and needs more memory.
    tolerance:
        Relative residual at which the solver stops. Smaller is more exact and slower.
    max_iterations:
        Give up if the solver has not converged after this many iterations.
    memory_limit:
        Most memory that the solver may use, such as 8GB. A picture that needs more is refused before the work begins.
        Default: the machine's free memory.
    """

    mu: float = option(0.1, Weight("0.1"))
    beta: float = option(0.001, Weight("0.001"))
    delta: float = option(30.0, Numeric("30"))
    background: BackgroundMode = option("plane", choice_of(BackgroundMode, "cut"))
    edge: Edge = option("blend", choice_of(Edge, "wall"))
    edge_height: Length | None = option(None, LengthText("2mm"))
    outline_round: Length | None = option(None, LengthText("0.5mm"))
    slope_cap: float = option(3.0, Positive("3", _LARGEST_SLOPE))
    energy: Energy = option("eq6", choice_of(Energy, "eq4"))
    per_pixel: bool = option(False, Switch())
    height: Length | None = option(None, LengthText("3mm"))
    fit: Fit = option("scale", choice_of(Fit, "slope"))
    width: Length | None = option(None, LengthText("100mm", absolute=True))
    solver: SolverName = option("auto", choice_of(SolverName, "multigrid"))
    tolerance: float = option(1e-8, Numeric("1e-8"))
    max_iterations: int = option(100, Count("200"))
    memory_limit: str | None = option(None, Text("8GB"))

    def __post_init__(self) -> None:
        super().__post_init__()
        if 0 < self.beta < SMALLEST_BETA:
            raise UsageError(f"`beta={self.beta:g}`: must be 0 or at least {SMALLEST_BETA:g}")
        if not (math.isfinite(self.delta) and abs(self.delta) <= LARGEST_WEIGHT):
            raise UsageError(f"`delta={self.delta:g}`: must be a number of at most {LARGEST_WEIGHT:g}")
        if not 1e-14 <= self.tolerance < 1:
            raise UsageError(f"`tolerance={self.tolerance:g}`: must lie between 1e-14 and 1, such as 1e-8")
        if self.memory_limit is not None:
            try:
                memory(self.memory_limit)
            except UsageError as error:
                raise UsageError(f"`memory_limit={self.memory_limit!r}`: {str(error).partition(': ')[2]}") from None
        if self.edge == "wall" and self.background != "plane":
            raise UsageError(f"`edge='wall'`: needs a flat plate, `background='plane'`, not {self.background}")
        if self.edge_height is not None and self.edge == "blend":
            raise UsageError(f"`edge_height='{self.edge_height}'`: needs `edge='wall'`")
        if self.outline_round is not None and self.background != "cut":
            raise UsageError(f"`outline_round='{self.outline_round}'`: needs `background='cut'`, not {self.background}")
        if self.edge != "blend" and self.fit != "scale":
            raise UsageError(f"`fit={self.fit!r}`: is for `edge='blend'`; a wall goes with `fit='scale'`")
        if self.fit != "scale" and self.height is None:
            raise UsageError(f"`fit={self.fit!r}`: needs `height`, such as `height='3mm'`")

    @property
    def memory_limit_bytes(self) -> int | None:
        """The limit in bytes; None if none is given."""
        return None if self.memory_limit is None else memory(self.memory_limit)
