"""Split a large map into base and detail by tiles: the filter runs pass by pass, each with the margin that it needs."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float32, Float64, Mask
from nmaptool.core.errors import InputError
from nmaptool.core.progress import Progress, Stages
from nmaptool.core.vectors import FLAT, angles_deg
from nmaptool.filters.image_windows import WindowFilter, border_px
from nmaptool.filters.mixture import fit_histogram, length_histogram
from nmaptool.filters.split import sigma_in_px
from nmaptool.io.stores.map_output import MapLayout
from nmaptool.io.stores.new_stores import NewStore
from nmaptool.io.stores.normal_maps import NormalMapStore, open_normal_map
from nmaptool.io.stores.work import WorkFolder
from nmaptool.maps.detail import encode_detail
from nmaptool.maps.masks import motif_coverage
from nmaptool.options import ReadOptions, SplitOptions, TilingOptions, WriteOptions
from nmaptool.options.plain_values import plain_values
from nmaptool.solver.tiling.grid import Box, Tile, TileGrid
from nmaptool.tiled.edits import Edit, curl_sums, cut, edit, map_of, mean_of, stamps_of, total
from nmaptool.tiled.reporting import has_coverage, recipe_text, tiled_edit
from nmaptool.tiled.sweep import Records
from nmaptool.types.layer_set import LayerReport
from nmaptool.types.mixture import Mixture
from nmaptool.types.picture import Frame
from nmaptool.types.tiled_edit import TiledEdit

LAYERS = ("base", "detail")


@dataclass(frozen=True)
class _Job:
    """What every task knows; ``grid`` is that of the map for the last steps, and of the guide for the filter's."""

    folder: WorkFolder
    grid: TileGrid
    map: str
    reading: ReadOptions
    options: SplitOptions
    filter: WindowFilter
    layout: MapLayout
    target: str


def split(
    name: str,
    output: str,
    options: SplitOptions | None = None,
    *,
    reading: ReadOptions | None = None,
    writing: WriteOptions | None = None,
    tiling: TilingOptions | None = None,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> TiledEdit[LayerReport]:
    """Split a large map into base and detail, tile by tile.

    Parameters
    ----------
    name : str
        Zarr store, folder of tiles, TIFF file or other picture; an array, layer or page may follow after a colon.
    output : str
        Zarr group to write, with the arrays ``base`` and ``detail``; it appears when it is complete.
    options : SplitOptions, optional
    reading : ReadOptions, optional
    writing : WriteOptions, optional
        Bits "auto" are 16.
    tiling : TilingOptions, optional
        The work folder needs 24 bytes per pixel.
    overwrite : bool
        Replace a store that exists.
    progress : callable, optional

    Returns
    -------
    TiledEdit
        With the report of `nmaptool.split`; the pixels differ from those of `nmaptool.split` by rounding.

    Raises
    ------
    InputError
        If the map cannot be read, covers nothing or changes meanwhile.
    UsageError
        If sigma_s is in mm and the pitch is unknown, or below 0.3 px.
    OutputError
        If the output exists or cannot be written.
    LimitError
        If there is not enough memory for a tile with its margin.
    """
    options, tiling, stages = options or SplitOptions(), tiling or TilingOptions(), Stages(progress)
    store = NewStore(output, "a split map", overwrite)
    with stages.stage("inputs"):
        opened = open_normal_map(name, reading or ReadOptions())
        frame = Frame(opened.rows, opened.cols, opened.pitch_mm)
        sigma_s_px = sigma_in_px(options.sigma_s, frame, name)
        stamps = stamps_of(name)
    whole = WindowFilter(sigma_s_px, options.sigma_r, frame.shape)
    overlap = max(whole.margin, whole.blur_margin)
    made = cut(*frame.shape, tiling, overlap=overlap, bytes_per_pixel=whole.bytes_per_pixel + 60)
    layout = MapLayout(
        *(*frame.shape, frame.pitch_mm, made.grid.tile, has_coverage(opened)),
        writing or WriteOptions(),
        {"recipe": recipe_text("split", options)},
    )
    recipe = {"command": "split", "options": plain_values(options), "layout": plain_values(layout)}
    recipe["reading"] = plain_values(opened.settled)

    def create() -> None:
        for layer in LAYERS:
            layout.create(f"{store.partial_name}:{layer}")

    with edit([store], made, tiling, stamps, recipe, create, progress) as run:
        job = _Job(run.folder, made.grid, name, opened.settled, options, whole, layout, store.partial_name)
        with stages.stage("filter"):
            job, guide = _filtered(job, run, opened)
        with stages.stage("threshold"):
            measured = run.run(job, "measured", partial(_measure, job, guide), "finding the threshold")
            mixture = fit_histogram(total(measured, "mass"), total(measured, "inner"))
        with stages.stage("write"):
            records = run.run(job, "written", partial(_write, job, guide, mixture.theta), "writing")
    report = _report(options, mixture, records, frame, sigma_s_px, stages)
    return tiled_edit(report, output, made, run.resumed, (opened,))


def _filtered(job: _Job, run: Edit, opened: NormalMapStore) -> tuple[_Job, str]:
    """Run all passes of the filter; return the job with the box of the motif, and the array of the last guide."""
    border, grid = border_px(job.filter.sigma_s_px), job.grid
    around = TileGrid(grid.rows + 2 * border, grid.cols + 2 * border, grid.tile, grid.overlap, 1)
    outer = dataclasses.replace(job, grid=around)
    for name in _guides(1)[0], _guides(1)[1]:
        run.folder.make_array(name, (around.rows, around.cols, 3), "f4", grid.tile, packed=True)
    passes = job.options.iterations
    first = run.run(outer, "pass1", partial(_blur, outer), f"pass 1 of {passes}")
    box = _extent(first)
    if box is None:
        run.discard()
        raise InputError(f"{opened.name}: no pixel is covered, so there is nothing to split")
    found = dataclasses.replace(job.filter, shape=(box[1] - box[0], box[3] - box[2]))
    outer, job = dataclasses.replace(outer, filter=found), dataclasses.replace(job, filter=found)
    for number in range(2, passes + 1):
        run.run(outer, f"pass{number}", partial(_follow, outer, number), f"pass {number} of {passes}")
    return job, _guides(passes)[1]


def _guides(number: int) -> tuple[str, str]:
    """The arrays that a pass reads and writes; two take turns."""
    names = ("guide0", "guide1")
    return names[(number - 1) % 2], names[number % 2]


def _extent(records: Records) -> tuple[int, int, int, int] | None:
    """First and end row and column of the covered pixels, from those of the tiles."""
    boxes = np.array([record["box"] for record in records.values() if len(record["box"])])
    if not len(boxes):
        return None
    low, high = boxes.min(axis=0), boxes.max(axis=0)
    return int(low[0]), int(high[1]), int(low[2]), int(high[3])


def _weighted(job: _Job, window: Box) -> Float32:
    """(h, w, 3): normals times coverage in a window of the guide, which may reach beyond the map."""
    border = border_px(job.filter.sigma_s_px)
    rows, cols = (slice(side.start - border, side.stop - border) for side in window)
    whole = job.layout.rows, job.layout.cols
    inner = tuple(
        slice(min(max(side.start, 0), size), min(max(side.stop, 0), size))
        for side, size in zip((rows, cols), whole, strict=True)
    )
    out = np.zeros((rows.stop - rows.start, cols.stop - cols.start, 3), np.float32)
    if inner[0].start < inner[0].stop and inner[1].start < inner[1].stop:
        part = map_of(job.map, job.reading).window(*inner)
        place = tuple(slice(a.start - b.start, a.stop - b.start) for a, b in zip(inner, (rows, cols), strict=True))
        out[place] = part.normals * motif_coverage(part)[..., None]
    return out


def _window(job: _Job, tile: Tile, margin: int) -> tuple[Box, Box]:
    """The window of a tile with a margin on all sides, even beyond the picture, and the place of the tile in it."""
    rows, cols = job.grid.faces(tile)
    window = slice(rows.start - margin, rows.stop + margin), slice(cols.start - margin, cols.stop + margin)
    own = slice(margin, margin + rows.stop - rows.start), slice(margin, margin + cols.stop - cols.start)
    return window, own


def _blur(job: _Job, tile: Tile) -> None:
    window, own = _window(job, tile, job.filter.blur_margin)
    vectors = _weighted(job, window)
    job.folder.write(_guides(1)[1], job.grid.faces(tile), job.filter.first(vectors, own))
    seen: Mask = (vectors[own] != 0).any(axis=2)
    rows, cols = (np.flatnonzero(seen.any(axis=axis)) for axis in (1, 0))
    at = job.grid.faces(tile)
    box = [] if not rows.size else [rows[0] + at[0].start, rows[-1] + 1 + at[0].start]
    box += [] if not rows.size else [cols[0] + at[1].start, cols[-1] + 1 + at[1].start]
    job.folder.put(f"pass1/{tile.row}_{tile.col}", {"box": np.array(box, np.int64)})


def _follow(job: _Job, number: int, tile: Tile) -> None:
    window, own = _window(job, tile, job.filter.margin)
    before, after = _guides(number)
    guide = np.zeros((window[0].stop - window[0].start, window[1].stop - window[1].start, 3), np.float32)
    inner = tuple(
        slice(max(side.start, 0), min(side.stop, size))
        for side, size in zip(window, (job.grid.rows, job.grid.cols), strict=True)
    )
    place = tuple(slice(a.start - b.start, a.stop - b.start) for a, b in zip(inner, window, strict=True))
    guide[place] = job.folder.read(before, (inner[0], inner[1]))
    found = job.filter.following(_weighted(job, window), guide, own)
    job.folder.write(after, job.grid.faces(tile), found)
    job.folder.put(f"pass{number}/{tile.row}_{tile.col}", {})


def _parts(job: _Job, guide: str, tile: Tile) -> tuple[Float32, Float32, Float32, Float32, Float64]:
    """Original and filtered normals of a tile, its coverage and that of the motif, and the residual's lengths."""
    rows, cols = job.grid.faces(tile)
    part = map_of(job.map, job.reading).window(rows, cols)
    coverage = motif_coverage(part)
    border = border_px(job.filter.sigma_s_px)
    box = slice(rows.start + border, rows.stop + border), slice(cols.start + border, cols.stop + border)
    filtered = np.where((coverage > 0)[..., None], job.folder.read(guide, box), np.array(FLAT, np.float32))
    residual = part.normals.astype(np.float64) - filtered
    return part.normals, filtered, part.coverage, coverage, np.sqrt(np.einsum("ijk,ijk->ij", residual, residual))


def _measure(job: _Job, guide: str, tile: Tile) -> None:
    _, _, _, coverage, length = _parts(job, guide, tile)
    seen = coverage > 0
    mass, inner = length_histogram(length[seen], coverage[seen].astype(np.float64))
    job.folder.put(f"measured/{tile.row}_{tile.col}", {"mass": mass, "inner": inner})


def _write(job: _Job, guide: str, theta: float, tile: Tile) -> None:
    original, filtered, shown, coverage, length = _parts(job, guide, tile)
    seen: Mask = coverage > 0
    is_detail = seen & (length > theta)
    replaced = is_detail if job.options.filter == "grnf" else seen
    base = np.where(replaced[..., None], filtered, original)
    detail = encode_detail(original, base, job.options.detail_encoding)
    row, col = (side.start for side in job.grid.faces(tile))
    for name, normals in zip(LAYERS, (base, detail), strict=True):
        job.layout.write(f"{job.target}:{name}", row, col, normals, shown)
    angles = angles_deg(original[seen], base[seen])
    record: Mapping[str, Any] = {
        "detail": np.array([coverage[is_detail].sum(dtype=np.float64), coverage.sum(dtype=np.float64)]),
        "angle": np.array([angles.sum(), angles.size], np.float64),
        **{
            f"curl_{name}": curl_sums(n, seen)
            for name, n in (("original", original), ("base", base), ("detail", detail))
        },
    }
    job.folder.put(f"written/{tile.row}_{tile.col}", record)


def _report(
    options: SplitOptions, mixture: Mixture, records: Records, frame: Frame, sigma_s_px: float, stages: Stages
) -> LayerReport:
    return LayerReport(
        options=plain_values(options),
        mixture=mixture,
        detail_share=mean_of(total(records, "detail")),
        detail_angle_deg=mean_of(total(records, "angle")),
        pitch_from="file" if frame.pitch_mm is not None else "",
        sigma_s_px=sigma_s_px,
        curl={name: mean_of(total(records, f"curl_{name}")) for name in ("original", *LAYERS)},
        seconds=stages.seconds(),
    )
