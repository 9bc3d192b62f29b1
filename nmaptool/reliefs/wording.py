"""What is said about the solve of a relief, one line each, with options as in `nmaptool.core.mentions`."""

from __future__ import annotations

from collections.abc import Iterator

from nmaptool.types.relief import MOSTLY_FLAT, ReliefReport
from nmaptool.types.shown import counted


def describe_solve(report: ReliefReport) -> Iterator[str]:
    """The options that shaped it, the solver, its size, and what may be wrong."""
    o = report.options
    reach = f"up to {report.reach_px:.1f} px = {report.reach_mm:.2f} mm" if report.reach_px < 1e9 else "of any size"
    detail = f"mu {report.mu:g}, " if report.mu else ""
    delta = report.delta_px / report.px_per_delta
    fitted = {"delta": " (fitted)", "slope": f", slopes times {report.scale:.3g}"}.get(o.fit, "")
    yield f"{o.background}: {detail}beta {o.beta:g}, delta {delta:.4g}{fitted}, keeps forms {reach}"
    seconds = sum(report.seconds.get(stage, 0) for stage in ("setup", "solve"))
    yield (
        f"{report.solver}: {counted(report.unknowns, 'unknown')}, {counted(report.iterations, 'iteration')}, "
        f"residual {report.residual:.1e}, {seconds:.2f} s"
    )
    low, high = report.height_min_mm, report.height_max_mm
    size = f"pitch {report.pitch_mm:.4g} mm ({report.pitch_from})"
    yield f"height {low:.3f} to {high:.3f} mm = {report.height_range_mm:.3f} mm, {size}"
    yield from advise(report)


def advise(report: ReliefReport) -> Iterator[str]:
    """What the user may want to change."""
    o = report.options
    yield from _describe_edge(report)
    if o.background == "surface":
        yield f"relief {report.relief_range_mm:.3f} mm from its curved background"
    if report.below_background_share > 0.02 and report.delta_px > 0:
        remedy = "" if o.fit == "delta" else "; a larger `delta` lifts it"
        yield f"{report.below_background_share:.1%} of the motif lies below its background{remedy}"
    if report.pitch_from == "assumed":
        yield "no size given: 100 mm on the longer side is assumed; set yours with `width='80mm'`"


def _describe_edge(report: ReliefReport) -> Iterator[str]:
    """How the outline meets the plate, where that was chosen or may be wrong."""
    flat = f"{report.flat_share:.0%} of the motif is flat"
    if report.edge == "wall":
        chosen = f" ({flat}; `edge='blend'` lets it run down)" if report.options.edge == "auto" else ""
        yield f"edge: a wall of {abs(report.edge_height_mm):.3g} mm on average{chosen}"
    elif report.options.edge == "auto":
        yield f"edge: runs down into the plate (only {flat}; `edge='wall'` lets it stand)"
    elif report.options.background == "plane" and report.flat_share > MOSTLY_FLAT and report.foreground_share < 1:
        yield f"{flat} and becomes rounded towards its outline; `edge='wall'` keeps it flat"
