"""The run of a relief by tiles: assembly, solve, levels, exact height, report."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.progress import Stages
from nmaptool.reliefs.finish import HeightFacts, factor_for_height, length_px
from nmaptool.reliefs.fit import factor_for_range
from nmaptool.reliefs.heights import SolveStatistics
from nmaptool.reliefs.layout import MotifFacts
from nmaptool.reliefs.motif import no_motif
from nmaptool.reliefs.report import SolverFacts, report_of
from nmaptool.tiled.finishing import Shifts, Sum, hull, level_islands
from nmaptool.tiled.inputs import Sources
from nmaptool.tiled.job import ReliefJob
from nmaptool.tiled.solving import Pool, Swept, assembled, coarse_problem, run_step, solve, teller
from nmaptool.types.relief import ReliefReport

_Shifts = tuple[Shifts | None, ...]


def run_relief(
    job: ReliefJob, pool: Pool, sources: Sources, pitch_from: str, stages: Stages
) -> tuple[ReliefReport, Sum, _Shifts]:
    """Solve; return the report, and how the heights follow from the solved arrays."""
    progress = stages.progress
    with stages.stage("inputs"):
        records = assembled(job, pool, progress)
        sources.check_unchanged()
        counts = np.sum([record["counts"] for record in records.values()], axis=0)
        _check_motif(job, sources, counts)
    with stages.stage("setup"):
        coarse = coarse_problem(job)
    with stages.stage("solve"):
        swept = [solve(job, pool, load, records, coarse, progress) for load in job.loads]
        most = max(float(record["most"]) for record in records.values())
        levelled = [level_islands(job, pool, each, most, progress) for each in swept]
    shifts: _Shifts = tuple(shift for shift, _ in levelled)
    with stages.stage("finish"):
        total, facts = _finish(job, pool, swept, [span for _, span in levelled], shifts, stages)
    report = _report(job, counts, swept, facts, pitch_from)
    return report, total, shifts


def _check_motif(job: ReliefJob, sources: Sources, counts: Any) -> None:
    if counts[0]:
        return
    selected = None if job.files.mask is None else bool(counts[1])
    raise no_motif(job.original, sources.background, selected)


def _finish(
    job: ReliefJob, pool: Pool, swept: list[Swept], spans: list[tuple[float, float]], shifts: _Shifts, stages: Stages
) -> tuple[Sum, HeightFacts]:
    """Find the factors for the exact height."""
    options, pitch_mm, grid = job.options, job.pitch_mm, job.grid
    wanted = length_px(options.height, (grid.rows, grid.cols), pitch_mm)
    arrays = tuple(each.array for each in swept)
    has_base = job.files.surface is not None
    statistics = SolveStatistics(
        max(each.residual for each in swept),
        sum(each.iterations for each in swept),
        sum((each.history for each in swept), start=()),
    )
    delta, scale = job.weights.delta, 1.0
    low, high = spans[0]
    if options.fit == "scale":
        factors: tuple[float, ...] = (1.0,)
        if wanted is not None:
            scale = factor_for_height((low, high), max(abs(low), abs(high)), wanted, options)
            factors, low, high = (scale,), scale * low, scale * high
    else:
        assert wanted is not None
        names = (arrays[0], arrays[1])
        step = partial(hull, job, names, (shifts[0], shifts[1]))
        found = run_step(job, pool, "hull", step, teller(stages.progress, "finding the height"))
        points: Float64 = np.concatenate([record["points"] for record in found.values()])
        first, second = points[:, 0], points[:, 1]
        if options.fit == "slope":
            scale = factor_for_range(delta * second, first, wanted, "the slopes", pitch_mm)
        else:
            side = -1.0 if delta < 0 else 1.0
            delta = side * factor_for_range(first, side * second, wanted, "delta", pitch_mm)
        factors = (scale, delta)
        heights = scale * first + delta * second
        low, high = float(heights.min()), float(heights.max())
    # the share below the background is counted when the heights are written
    facts = HeightFacts((low * pitch_mm, high * pitch_mm), (high - low) * pitch_mm, 0.0, delta, scale, statistics)
    return Sum(arrays, factors, pitch_mm, has_base), facts


def _report(job: ReliefJob, counts: Any, swept: list[Swept], facts: HeightFacts, pitch_from: str) -> ReliefReport:
    grid, islands = job.grid, swept[0].islands
    pixels = grid.rows * grid.cols
    motif, _, steep, acting, flat, left_alone, unknowns, held = (int(count) for count in counts)
    about = MotifFacts((grid.rows, grid.cols), motif / pixels, flat / max(motif, 1), left_alone / pixels, held > 0)
    floating = int(np.count_nonzero(islands.loose & (islands.ties == 0)))
    solver = SolverFacts("tiles", unknowns, islands.count, floating, 0)
    pulled = bool((islands.ties > 0).any())
    longer = max(grid.rows, grid.cols)
    steep_share = steep / acting if acting else 0.0
    return report_of(
        job.options, about, job.weights, facts, solver, (job.pitch_mm, pitch_from), steep_share, longer, pulled
    )
