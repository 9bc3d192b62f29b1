"""Messages about a relief: how it was solved."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from nmaptool.core.units import memory_text
from nmaptool.types.shown import counted
from nmaptool_cli.wording.maps import say_map

if TYPE_CHECKING:
    from nmaptool import NormalMap, Relief, ReliefReport
    from nmaptool_cli.run import Run


def describe_relief(run: Run, maps: Sequence[NormalMap], relief: Relief) -> None:
    """What was read and solved, with warnings."""
    import nmaptool as nm

    for normal_map in maps:
        say_map(run, normal_map)
    run.warn(*(f"{maps[0].name}: {finding}" for finding in nm.diagnose(maps[0])))
    report = relief.report
    run.say(*describe_solve(report))
    run.warn(*report.warnings)
    run.detail(f"  memory planned for the solver {memory_text(report.planned_bytes)}")
    run.detail(f"  residual of each iteration: {' '.join(f'{r:.1e}' for r in report.history)}")
    run.seconds(report.seconds)


def describe_solve(report: ReliefReport) -> Iterator[str]:
    """A solve, one line each."""
    o = report.options
    reach = f"up to {report.reach_px:.1f} px = {report.reach_mm:.2f} mm" if report.reach_px < 1e9 else "of any size"
    detail = f"mu {report.mu:g}, " if report.mu else ""
    delta = report.delta_px / report.px_per_delta
    fitted = {"delta": " (fitted)", "slope": f", slopes times {report.scale:.3g}"}.get(o.fit, "")
    yield f"  {o.background}: {detail}beta {o.beta:g}, delta {delta:.4g}{fitted}, keeps forms {reach}"
    seconds = sum(report.seconds.get(stage, 0) for stage in ("setup", "solve"))
    yield (
        f"  {report.solver}: {counted(report.unknowns, 'unknown')}, {counted(report.iterations, 'iteration')}, "
        f"residual {report.residual:.1e}, {seconds:.2f} s"
    )
    low, high = report.height_min_mm, report.height_max_mm
    size = f"pitch {report.pitch_mm:.4g} mm ({report.pitch_from})"
    yield f"  height {low:.3f} to {high:.3f} mm = {report.height_range_mm:.3f} mm, {size}"
    if o.background == "surface":
        yield f"  relief {report.relief_range_mm:.3f} mm from its curved background"
    if report.below_background_share > 0.02 and report.delta_px > 0:
        remedy = "" if o.fit == "delta" else "; a larger --delta lifts it"
        yield f"  {report.below_background_share:.1%} of the motif lies below its background{remedy}"
    if report.pitch_from == "assumed":
        yield "  no size given: 100 mm on the longer side is assumed; set yours with --width 80mm"
