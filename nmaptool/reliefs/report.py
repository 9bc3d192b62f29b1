"""Build the report of a relief from its heights and the solver's statistics."""

from __future__ import annotations

from dataclasses import dataclass

from nmaptool.core.text import in_short
from nmaptool.options import ReliefOptions
from nmaptool.reliefs.finish import HeightFacts
from nmaptool.reliefs.layout import MotifFacts
from nmaptool.reliefs.targets import Weights, to_pixels
from nmaptool.solver import Solver
from nmaptool.types.relief import ReliefReport

# if more than this share of a motif on a flat background is flat, it is probably lettering or an emblem
_MUCH_FLAT = 0.1
# outside this range of sizes in mm, the size in the file is probably wrong
_SMALLEST_MM, _LARGEST_MM = 5.0, 5000.0


@dataclass(frozen=True)
class SolverFacts:
    """Facts about a solver for the report; the solver itself can be released.

    Attributes
    ----------
    name : str
    unknowns, islands, floating_islands, planned_bytes : int
    """

    name: str
    unknowns: int
    islands: int
    floating_islands: int
    planned_bytes: int


def facts_of(solver: Solver) -> SolverFacts:
    """Return the facts about a solver for the report."""
    islands = solver.islands
    floating = int(islands.floating.sum())
    return SolverFacts(solver.method.name, solver.unknowns, islands.count, floating, solver.planned_bytes)


def report_of(
    options: ReliefOptions,
    motif: MotifFacts,
    weights: Weights,
    heights: HeightFacts,
    solver: SolverFacts,
    pitch: tuple[float, str],
    steep_share: float,
    longer_side: int,
    pulled: bool,
) -> ReliefReport:
    """Return the report of one relief.

    ``pitch`` is the pitch in mm and its source; ``pulled`` says whether beta is not 0 everywhere.
    """
    reach_px = weights.reach_px(options.energy)
    low, high = heights.range_mm
    return ReliefReport(
        options=options,
        pitch_mm=pitch[0],
        pitch_from=pitch[1],
        mu=weights.mu,
        beta_px=weights.beta,
        delta_px=heights.delta_px,
        px_per_delta=to_pixels(1.0, 1.0, longer_side, options.per_pixel)[1],
        reach_px=reach_px,
        reach_mm=reach_px * pitch[0],
        solver=solver.name,
        unknowns=solver.unknowns,
        islands=solver.islands,
        floating_islands=solver.floating_islands,
        iterations=heights.statistics.iterations,
        residual=heights.statistics.residual,
        history=heights.statistics.history,
        height_min_mm=low,
        height_max_mm=high,
        height_range_mm=high - low,
        relief_range_mm=heights.relief_range_mm,
        below_background_share=heights.below_share,
        foreground_share=motif.share,
        steep_share=steep_share,
        edge="blend" if motif.edge_height_mm is None else "wall",
        edge_height_mm=motif.edge_height_mm or 0.0,
        flat_share=motif.flat_share,
        scale=heights.scale,
        planned_bytes=solver.planned_bytes,
        warnings=(
            *_warnings(options, motif, heights.scale, reach_px, pulled),
            *_size_doubts(motif.shape, pitch, high - low),
        ),
    )


def _warnings(options: ReliefOptions, motif: MotifFacts, scale: float, reach_px: float, pulled: bool) -> list[str]:
    found = []
    if not motif.holds:
        if not pulled:
            found.append("`beta` is 0 and nothing is held: `delta` has no effect, and the heights have mean 0")
        elif options.background in ("plane", "surface"):
            found.append("the map has no background to hold: the whole picture is surface, pulled to height `delta`")
    if motif.left_alone > _MUCH_FLAT * motif.share and pulled:
        found.append("much of the motif is flat; for lettering and emblems, `beta=0` keeps every height of the map")
    if reach_px < 1:
        found.append(f"`beta` is so large that it flattens shapes wider than {reach_px:.2g} px; use a smaller `beta`")
    if options.fit == "slope" and scale < 0.05:
        found.append(f"the slopes were scaled by {scale:.2g} to reach `height`, so little of the shape remains")
    return found


def _size_doubts(shape: tuple[int, ...], pitch: tuple[float, str], height_mm: float) -> list[str]:
    """Doubts about the size of the picture, at most one; ``shape`` is its rows and columns."""
    rows_mm, cols_mm = (pixels * pitch[0] for pixels in shape)
    size = f"{in_short(cols_mm)} x {in_short(rows_mm)} mm"
    source = {"file": " by the size in the file", "assumed": " as assumed"}.get(pitch[1], "")
    if height_mm > min(rows_mm, cols_mm):
        high = f"the relief is {in_short(height_mm)} mm high, but the picture only {size}{source}"
        return [f"{high}; use a larger `width`, such as `width='80mm'`, or a smaller `height`"]
    if pitch[1] == "file" and not _SMALLEST_MM <= max(rows_mm, cols_mm) <= _LARGEST_MM:
        return [f"the picture is {size}{source}; set its `width`, such as `width='80mm'`"]
    return []
