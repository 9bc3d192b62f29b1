"""Turn large depth pictures into normals by tiles: values, ground, normals; the scale is settled for the whole."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.errors import InputError
from nmaptool.core.progress import Progress, Stages
from nmaptool.depth.settled import (
    EmptyRule,
    SettledDepth,
    most_margin_px,
    settle_depth,
    settle_empty,
)
from nmaptool.depth.source import DepthSource
from nmaptool.depth.warnings import warnings_of
from nmaptool.depth.windows import window_normals, window_surface, window_values
from nmaptool.io.stores.map_output import MapLayout
from nmaptool.io.stores.new_stores import NewStore
from nmaptool.io.stores.opening import open_picture
from nmaptool.io.stores.windows import within
from nmaptool.io.stores.work import WorkFolder
from nmaptool.options import DepthOptions, TilingOptions, WriteOptions
from nmaptool.options.plain_values import plain_values
from nmaptool.solver.tiling.grid import Box, Tile, TileGrid
from nmaptool.tiled.depth_samples import opened_mask, sample_of_depths
from nmaptool.tiled.edits import Edit, curl_sums, cut, edit, grey_of, mean_of, picture_of, stamps_of, total
from nmaptool.tiled.grounds import find_ground, label_low
from nmaptool.tiled.reporting import recipe_text, tiled_edit
from nmaptool.tiled.sweep import Records
from nmaptool.types.depth import DepthReport
from nmaptool.types.picture import Frame, RasterImage
from nmaptool.types.tiled_edit import TiledEdit

# measured: heights, links, slack, a fit with its coarse grids, and normals
_BYTES_PER_PIXEL = 160


@dataclass(frozen=True)
class _Job:
    folder: WorkFolder
    grid: TileGrid
    image: str
    layer: str | None
    mask: str | None
    rule: EmptyRule
    options: DepthOptions
    layout: MapLayout
    target: str

    def window(self, box: Box) -> tuple[RasterImage, Float32 | None]:
        """A window of the picture and of the mask."""
        mask = None if self.mask is None else grey_of(self.mask).window(*box)
        return picture_of(self.image, self.layer, "depth").read(*box), mask


def depth(
    image: str,
    output: str,
    options: DepthOptions | None = None,
    *,
    mask: str | None = None,
    layer: str | None = None,
    writing: WriteOptions | None = None,
    tiling: TilingOptions | None = None,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> TiledEdit[DepthReport]:
    """Turn a large depth or height picture into a normal map, tile by tile.

    What values mean, which are empty, the size of steps and the noise are found in 4 x 4 windows of 512 px; the range
    of the values is that of the whole picture. Holes are filled if they span at most 64 px, or twice ``fill``.

    Parameters
    ----------
    image : str
        Zarr store, folder of tiles, TIFF file or other picture; an array, layer or page may follow after a colon.
    output : str
        Zarr store to write; it appears when it is complete.
    options : DepthOptions, optional
    mask : str, optional
        Grey picture of the same size: where the surface is.
    layer : str, optional
        As after a colon.
    writing : WriteOptions, optional
        Bits "auto" are 16.
    tiling : TilingOptions, optional
    overwrite : bool
        Replace a store that exists.
    progress : callable, optional

    Returns
    -------
    TiledEdit
        With the report of `nmaptool.depth_to_normals`. On clean heights, the pixels are the same, but for rounding;
        docs/large_maps.md states by how much a fitted surface differs.

    Raises
    ------
    InputError
        If the picture is coloured or empty or changes meanwhile, or the mask has another size or selects nothing.
    UsageError
        If a length is in mm and the pitch is unknown, or an option contradicts the file.
    OutputError
        If the output exists or cannot be written.
    LimitError
        If there is not enough memory for a tile with its overlap.
    """
    options, tiling, stages = options or DepthOptions(), tiling or TilingOptions(), Stages(progress)
    store = NewStore(output, "a normal map", overwrite)
    with stages.stage("inputs"):
        picture = open_picture(image, layer, holds="depth")
        frame = Frame(picture.rows, picture.cols, picture.pitch_mm)
        sample = sample_of_depths(picture, frame, opened_mask(image, mask, frame))
        rule, meaning, grey = settle_empty(sample.image, sample.mask, options)
        stamps = stamps_of(image, mask)
    made = cut(frame.rows, frame.cols, tiling, overlap=most_margin_px(options, frame), bytes_per_pixel=_BYTES_PER_PIXEL)
    attributes = {"recipe": recipe_text("depth", options)}
    layout = MapLayout(
        frame.rows, frame.cols, frame.pitch_mm, made.grid.tile, True, writing or WriteOptions(), attributes
    )
    recipe = {"command": "depth", "options": plain_values(options), "layout": plain_values(layout), "mask": mask}
    recipe |= {"rule": plain_values(rule), "layer": layer}
    with edit([store], made, tiling, stamps, recipe, partial(layout.create, store.partial_name), progress) as run:
        job = _Job(run.folder, made.grid, image, layer, mask, rule, options, layout, store.partial_name)
        with stages.stage("reading"):
            values = run.run(job, "values", partial(_read_tile, job), "reading values")
            _check_known(run, image, mask, values)
            ends = min(float(r["ends"][0]) for r in values.values()), max(float(r["ends"][1]) for r in values.values())
            settled, source = settle_depth(sample.image, grey, ends, rule, meaning, options, sample.windows)
        with stages.stage("ground"):
            ground = _ground(job, run, settled, int(total(values, "known")))
        with stages.stage("normals"):
            step = partial(_normals_tile, job, settled, ground)
            records = run.run(job, "written", step, "normals")
    report = _report(options, source, settled, values, records, ground, stages)
    return tiled_edit(report, output, made, run.resumed, (), source.scale.pitch_mm, overlap=settled.margin)


def _read_tile(job: _Job, tile: Tile) -> None:
    image, mask = job.window(job.grid.faces(tile))
    grey, _, counts = window_values(image, job.rule, mask)
    known = grey.known
    sure = known if mask is None else known & (mask >= 0.5)
    record: dict[str, Any] = {
        "ends": np.array([grey.values.min(where=known, initial=np.inf), grey.values.max(where=known, initial=-np.inf)]),
        "known": np.array(np.count_nonzero(known)),
        "sure": np.array(np.count_nonzero(sure)),
        "nothing": np.array(sum(counts.values())),
        "noisy": np.array(grey.noisy_grey),
        "counts": np.frombuffer(json.dumps(counts).encode(), np.uint8),
    }
    job.folder.put(f"values/{tile.row}_{tile.col}", record)


def _check_known(run: Edit, image: str, mask: str | None, values: Records) -> None:
    known, sure = (int(total(values, name)) for name in ("known", "sure"))
    if not known or not sure:
        run.discard()
        if mask is None:
            raise InputError(f"{image}: no pixel has a depth; check that this is the depth picture")
        raise InputError("the mask selects no part of the picture: paint the motif white (0.5 or more) on black")


def _ground(job: _Job, run: Edit, settled: SettledDepth, known: int) -> bool:
    """Find the flat ground and store it; return whether there is any."""
    if job.options.background == "none":
        return False
    job.folder.make_array("low", (job.grid.rows, job.grid.cols), "u1", job.grid.tile, packed=True)
    low = run.run(job, "low", partial(_low_tile, job, settled), "finding the ground")
    return find_ground(job, run, low, known)


def _surface(job: _Job, settled: SettledDepth, tile: Tile) -> tuple[Any, Box, Box]:
    """The surface in the window of a tile, that window, and the place of the tile in it."""
    around = job.grid.window(tile, settled.margin)
    image, mask = job.window(around)
    return window_surface(image, mask, settled), around, within(job.grid.faces(tile), around)


def _low_tile(job: _Job, settled: SettledDepth, tile: Tile) -> None:
    surface, _, own = _surface(job, settled, tile)
    low: Mask = np.ascontiguousarray(surface.low[own])
    job.folder.write("low", job.grid.faces(tile), low.view(np.uint8))
    job.folder.put(f"low/{tile.row}_{tile.col}", label_low(low))


def _normals_tile(job: _Job, settled: SettledDepth, has_ground: bool, tile: Tile) -> None:
    surface, around, own = _surface(job, settled, tile)
    ground: Mask | None = job.folder.read("ground", around).astype(bool) if has_ground else None
    normals, heights = window_normals(surface, ground, settled)
    known = surface.known[own]
    coverage = known.astype(np.float32)
    if surface.cover is not None:
        coverage *= surface.cover[own]
    foreground = coverage >= 0.5
    if ground is not None:
        foreground &= ~ground[own]
        if job.options.background != "flat":
            coverage[ground[own]] = 0
    normals, heights = np.ascontiguousarray(normals[own]), heights[own]
    row, col = (side.start for side in job.grid.faces(tile))
    job.layout.write(job.target, row, col, normals, coverage)
    low, high = heights.min(where=known, initial=np.inf), heights.max(where=known, initial=-np.inf)
    record = {
        "range": np.array([low, high]),
        "curl": curl_sums(normals, foreground),
        "foreground": np.array(np.count_nonzero(foreground)),
        "known": np.array(np.count_nonzero(known)),
        "jumps": np.array(np.count_nonzero(surface.jumps[own])),
        "mixed": np.array(np.count_nonzero(surface.moved[own])),
        "filled": np.array(np.count_nonzero(surface.filled[own])),
    }
    job.folder.put(f"written/{tile.row}_{tile.col}", record)


def _report(
    options: DepthOptions,
    source: DepthSource,
    settled: SettledDepth,
    values: Records,
    records: Records,
    ground: bool,
    stages: Stages,
) -> DepthReport:
    counts: dict[str, int] = {}
    for record in values.values():
        for word, number in json.loads(bytes(record["counts"])).items():
            counts[word] = counts.get(word, 0) + number
    sums = {name: int(total(records, name)) for name in ("foreground", "known", "jumps", "mixed", "filled")}
    low, high = (f([r["range"][k] for r in records.values()]) for k, f in ((0, min), (1, max)))
    kinds = ["empty"] if total(values, "nothing") else []
    kinds += ["flat" if options.background == "flat" else "cut"] if ground else []
    noisy = any(bool(record["noisy"]) for record in values.values())
    doubts = ("the colour channels differ slightly; their mean is used as grey",) if noisy else ()
    facts = source.facts() | {"empty": counts, "fill_px": settled.fill_px, "filled_pixels": sums["filled"]}
    return DepthReport(
        options=options,
        **facts,
        empty_pixels=int(total(values, "nothing")) - sums["filled"],
        range_px=float(high - low),
        tolerance_px=settled.tolerance,
        jump_px=None if settled.jumps is None else settled.jumps.least,
        jumps=sums["jumps"],
        jump_share=sums["jumps"] / max(sums["known"], 1),
        mixed_pixels=sums["mixed"],
        background=", ".join(kinds) or "none",
        background_share=1 - sums["foreground"] / settled.pixels,
        curl=mean_of(total(records, "curl")),
        seconds=stages.seconds(),
        warnings=(*doubts, *warnings_of(source, options, float(high - low))),
    )
