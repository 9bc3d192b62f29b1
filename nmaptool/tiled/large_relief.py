"""Make a relief of a map larger than memory."""

from __future__ import annotations

import dataclasses
from contextlib import AbstractContextManager
from functools import partial

import numpy as np

from nmaptool._version import __version__
from nmaptool.core.errors import UsageError
from nmaptool.core.memory import available_bytes
from nmaptool.core.parallel import cores
from nmaptool.core.progress import Progress, Stages
from nmaptool.io.stores.height_output import HeightOutput
from nmaptool.io.stores.work import WorkFolder
from nmaptool.options import HeightsAt, ReadOptions, ReliefFiles, ReliefOptions, TilingOptions
from nmaptool.options.plain_values import plain_values
from nmaptool.reliefs.targets import Weights, to_pixels
from nmaptool.reliefs.window import margin_px
from nmaptool.tiled.finishing import write
from nmaptool.tiled.inputs import Sources, check_background, open_sources
from nmaptool.tiled.job import ReliefJob
from nmaptool.tiled.planning import Plan, plan
from nmaptool.tiled.pools import cluster_pool, local_pool
from nmaptool.tiled.running import run_relief
from nmaptool.tiled.solving import Pool, run_step, teller
from nmaptool.tiled.sweep import Records
from nmaptool.types.height import DEFAULT_LONGER_SIDE_MM
from nmaptool.types.relief import ReliefReport
from nmaptool.types.tiled import TiledReport

# where the system does not report its memory
_ASSUMED_MEMORY = 8_000_000_000
# of the free memory
_SHARE = 0.8


def relief(
    original: str,
    output: str,
    options: ReliefOptions | None = None,
    files: ReliefFiles | None = None,
    *,
    reading: ReadOptions | None = None,
    tiling: TilingOptions | None = None,
    at: HeightsAt = "centers",
    overwrite: bool = False,
    progress: Progress | None = None,
) -> TiledReport:
    """Solve the relief of a map larger than memory, tile by tile, and write its heights to a Zarr store.

    The heights equal those of `nmaptool.relief` within the tolerance. A coarse grid carries what reaches across tiles;
    overlapping tiles correct the rest, sweep by sweep, until the residual of the whole picture is small enough.

    Parameters
    ----------
    original : str
        The map: a Zarr store, a folder of tiles, a TIFF, or any other picture.
    output : str
        Zarr store for the heights in mm.
    options : ReliefOptions, optional
        As for `nmaptool.relief`; ``memory_limit`` applies to all processes together.
    files : ReliefFiles, optional
        Names of the other inputs.
    reading : ReadOptions, optional
    tiling : TilingOptions, optional
        Tiles, workers, cluster, folder for intermediate results. A run that was stopped goes on from that folder.
    at : str
        Heights at pixel "centers" or "corners".
    overwrite : bool
        Replace an output that exists.
    progress : callable, optional
        Called with the name of the stage and the share done.

    Returns
    -------
    TiledReport

    Raises
    ------
    InputError
        If an input cannot be read or changes meanwhile, or the exact height cannot be reached.
    UsageError
        If options contradict each other or are not available for large maps.
    LimitError
        If there is not enough memory or disk space.
    OutputError
        If the output exists or cannot be written, or another run writes it.
    ConvergenceError
        If the residual does not become small enough.
    """
    options, files = options or ReliefOptions(), files or ReliefFiles()
    tiling, stages = tiling or TilingOptions(), Stages(progress)
    _check(options, files)
    with stages.stage("inputs"):
        sources = open_sources(original, files, reading or ReadOptions())
        pitch_mm, pitch_from = _pitch(sources, options)
        if files.surface is not None:
            check_background(files.surface, pitch_mm)
        made = _plan(sources, options, tiling)
    job = _job(sources, options, files, tiling, made, pitch_mm, output)
    target = HeightOutput(output, sources.rows, sources.cols, pitch_mm, at, made.grid.tile, overwrite)
    job.folder.check_room(made.disk_bytes)
    with job.folder.locked() as folder, _pool(tiling, made) as pool:
        job = dataclasses.replace(job, folder=folder)
        resumed = _begin(job, sources, at)
        report, total, shifts = run_relief(job, pool, sources, pitch_from, stages)
        with stages.stage("finish"):
            if not job.folder.has_any("written"):
                target.begin()
            step = partial(write, job, total, shifts, target.partial_name, at)
            records = run_step(job, pool, "written", step, teller(progress, "writing heights"))
            report = _with_background(report, records)
            target.finish(report.height_min_mm, report.height_max_mm)
        sweeps = len(report.history)
        job.folder.remove()
    grid = made.grid
    report = dataclasses.replace(report, seconds=stages.elapsed)
    return TiledReport(
        report,
        output,
        grid.rows,
        grid.cols,
        grid.tile,
        grid.overlap,
        grid.factor,
        len(grid),
        made.workers,
        sweeps,
        resumed,
        sources.warnings,
    )


def _with_background(report: ReliefReport, records: Records) -> ReliefReport:
    """The report with what only the finished heights tell: how they lie to the background."""
    if report.options.background == "surface":
        low = min(float(record["range"][0]) for record in records.values())
        high = max(float(record["range"][1]) for record in records.values())
        report = dataclasses.replace(report, height_min_mm=low, height_max_mm=high, height_range_mm=high - low)
    if report.options.background not in ("plane", "surface"):
        return report
    below, motif = np.sum([record["below"] for record in records.values()], axis=0)
    return dataclasses.replace(report, below_background_share=float(below / motif))


def _check(options: ReliefOptions, files: ReliefFiles) -> None:
    """Refuse what needs the whole picture at once."""
    if options.edge != "blend" or files.wall_mask is not None:
        raise UsageError(
            f"`edge={options.edge!r}`: walls are not available for large maps; use `edge='blend'`, or a smaller map"
        )
    if (options.background == "surface") != (files.surface is not None):
        raise UsageError("`background='surface'` and `surface` go together; give both or neither")
    if options.solver == "dct":
        raise UsageError("`solver='dct'`: needs the whole picture; use `solver='auto'`")


def _pitch(sources: Sources, options: ReliefOptions) -> tuple[float, str]:
    longer = max(sources.rows, sources.cols)
    if options.width is not None:
        return options.width.to_mm(1.0, longer) / sources.cols, "given"
    if sources.pitch_mm is not None:
        return sources.pitch_mm, "file"
    return DEFAULT_LONGER_SIDE_MM / longer, "assumed"


def _plan(sources: Sources, options: ReliefOptions, tiling: TilingOptions) -> Plan:
    memory = options.memory_limit_bytes
    if memory is None:
        free = available_bytes()
        memory = _ASSUMED_MEMORY if free is None else int(_SHARE * free)
    loads = 1 if options.fit == "scale" else 2
    workers = tiling.workers if tiling.scheduler is None else 1
    return plan(sources.rows, sources.cols, cores(), memory, tile=tiling.tile, workers=workers, loads=loads)


def _job(
    sources: Sources,
    options: ReliefOptions,
    files: ReliefFiles,
    tiling: TilingOptions,
    made: Plan,
    pitch_mm: float,
    output: str,
) -> ReliefJob:
    beta, delta = to_pixels(options.beta, options.delta, max(sources.rows, sources.cols), options.per_pixel)
    mu = options.mu if files.detail is not None else 0.0
    folder = WorkFolder(tiling.work_folder or f"{output.rstrip('/')}.work")
    return ReliefJob(
        folder,
        made.grid,
        sources.original,
        files,
        sources.greys,
        sources.reading,
        sources.detail_reading,
        options,
        Weights(mu, beta, delta),
        pitch_mm,
        margin_px(options, pitch_mm),
    )


def _pool(tiling: TilingOptions, made: Plan) -> AbstractContextManager[Pool]:
    if tiling.scheduler is not None:
        return cluster_pool(tiling.scheduler)
    return local_pool(made.workers, 2 * made.worker_bytes)


def _begin(job: ReliefJob, sources: Sources, at: str) -> int:
    """Start the folder, or go on with that of a run that was stopped; return how many steps of tiles it finished."""
    recipe = {
        "version": __version__,
        "inputs": sources.stamps,
        "files": plain_values(job.files),
        "reading": plain_values(job.reading),
        "options": {key: value for key, value in plain_values(job.options).items() if key != "memory_limit"},
        "pitch_mm": job.pitch_mm,
        "grid": dataclasses.asdict(job.grid),
        "at": at,
    }
    if job.folder.recipe() == recipe:
        return job.folder.finished()
    job.folder.clear()
    job.folder.begin(recipe)
    return 0
