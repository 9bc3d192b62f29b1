"""Paste layers on a large background by tiles: only those that a layer touches are composed, others are copied."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from nmaptool.composition.compositor import canvas_of, covers_nothing, is_clipped, lay, nothing_below
from nmaptool.core.errors import UsageError
from nmaptool.core.progress import Progress, Stages
from nmaptool.core.units import Length
from nmaptool.io.stores.map_output import MapLayout, create_grey, write_grey
from nmaptool.io.stores.new_stores import NewStore
from nmaptool.io.stores.normal_maps import open_normal_map
from nmaptool.io.stores.work import WorkFolder
from nmaptool.options import CanvasOptions, ReadOptions, TilingOptions, WriteOptions
from nmaptool.options.plain_values import plain_values
from nmaptool.solver.tiling.grid import Tile, TileGrid
from nmaptool.tiled.edits import curl_sums, cut, edit, map_of, mean_of, stamps_of, total
from nmaptool.tiled.layers import PlacedLayer, place_files
from nmaptool.tiled.reporting import has_coverage, recipe_text, tiled_edit
from nmaptool.tiled.sweep import Records
from nmaptool.types.composition import ComposeReport
from nmaptool.types.layer_files import LayerFile
from nmaptool.types.picture import Frame
from nmaptool.types.tiled_edit import TiledEdit

# measured: the background, the canvas, a layer and the work arrays of a mode, in float32
_BYTES_PER_PIXEL = 160


@dataclass(frozen=True)
class _Job:
    folder: WorkFolder
    grid: TileGrid
    background: str
    reading: ReadOptions
    layers: tuple[PlacedLayer, ...]
    layout: MapLayout
    target: str
    placed: str | None
    walls: str | None


def paste(
    background: str,
    layers: Sequence[LayerFile | str],
    output: str,
    *,
    width: Length | None = None,
    placed: str | None = None,
    walls: str | None = None,
    reading: ReadOptions | None = None,
    writing: WriteOptions | None = None,
    tiling: TilingOptions | None = None,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> TiledEdit[ComposeReport]:
    """Paste layers on a large background, tile by tile.

    Parameters
    ----------
    background : str
        Zarr store, folder of tiles, TIFF file or other picture; an array, layer or page may follow after a colon.
    layers : sequence of LayerFile or str
        From the lowest to the topmost, of any size. Large layers are read by windows if their pixels become pixels, in
        moves, mirrors and quarter turns; those that are scaled or rotated otherwise are placed in memory once.
    output : str
        Zarr store to write; it appears when it is complete.
    width : Length, optional
        Width of the whole picture in mm, for lengths given in mm. Default: from the pitch of the background.
    placed, walls : str, optional
        Zarr stores for the coverage of the layers, and of those with ``edge="wall"``.
    reading : ReadOptions, optional
        ``layer`` applies to the background.
    writing : WriteOptions, optional
        Bits "auto" are 16.
    tiling : TilingOptions, optional
    overwrite : bool
        Replace stores that exist.
    progress : callable, optional

    Returns
    -------
    TiledEdit
        With the report of `nmaptool.paste`. The pixels are those of `nmaptool.paste`, bit for bit.

    Raises
    ------
    InputError
        If an input cannot be read or changes meanwhile, or a layer is outside the canvas, covers nothing or has nothing
        below it to change.
    UsageError
        If there is no layer, or a length is in mm and the pitch is unknown.
    OutputError
        If an output exists or cannot be written.
    LimitError
        If there is not enough memory for a tile, or for a layer that must be placed in memory.
    """
    tiling, reading, stages = tiling or TilingOptions(), reading or ReadOptions(), Stages(progress)
    files = tuple(LayerFile(layer) if isinstance(layer, str) else layer for layer in layers)
    if not files:
        raise UsageError("no layers given: add one or more after the background")
    store = NewStore(output, "the composed map", overwrite)
    beside = {name: NewStore(place, f"`{name}`", overwrite) for name, place in _given(placed=placed, walls=walls)}
    with stages.stage("inputs"):
        below = open_normal_map(background, reading)
        pitch_mm = below.pitch_mm if width is None else width.to_mm(1.0, 1) / below.cols
        frame = Frame(below.rows, below.cols, pitch_mm)
        own_reading = dataclasses.replace(reading, layer=None)
        made_layers, inputs, warnings = place_files(files, frame, own_reading)
        stamps = stamps_of(background, *(file.map for file in files), *(file.mask for file in files))
    reach = max(layer.placing.reach for layer in made_layers)
    made = cut(frame.rows, frame.cols, tiling, overlap=reach, bytes_per_pixel=_BYTES_PER_PIXEL)
    text = recipe_text("paste", CanvasOptions(width=width), placing=[plain_values(file.options) for file in files])
    layout = MapLayout(
        *(frame.rows, frame.cols, pitch_mm, made.grid.tile, has_coverage(below)),
        writing or WriteOptions(),
        {"recipe": text},
    )
    recipe: dict[str, Any] = {
        "command": "paste",
        "layout": plain_values(layout),
        "reading": plain_values(below.settled),
    }
    recipe |= {"layers": [plain_values(file) for file in files], "beside": sorted(beside)}

    def create() -> None:
        layout.create(store.partial_name)
        for one in beside.values():
            create_grey(one.partial_name, frame.rows, frame.cols, made.grid.tile, pitch_mm)

    with edit([store, *beside.values()], made, tiling, stamps, recipe, create, progress) as run:
        names = {name: one.partial_name for name, one in beside.items()}
        job = _Job(
            *(run.folder, made.grid, background, below.settled, made_layers, layout, store.partial_name),
            names.get("placed"),
            names.get("walls"),
        )
        with stages.stage("place"):
            for layer in made_layers:
                layer.store(run.folder, frame, own_reading, made.grid.tile)
        with stages.stage("compose"):
            records = run.run(job, "written", partial(_paste_tile, job), "composing")
        problem = _problem(made_layers, records, walls)
        if problem is not None:
            run.discard()
            raise problem
    report = ComposeReport(
        command="paste",
        options=plain_values(CanvasOptions(width=width)),
        layers=tuple(_layer_report(layer, frame, records) for layer in made_layers),
        curl_before=mean_of(total(records, "curl_before")),
        curl_after=mean_of(total(records, "curl_after")),
        seconds=stages.seconds(),
        warnings=warnings,
    )
    done, touched = tiled_edit(report, output, made, run.resumed, (below,), pitch_mm), int(total(records, "touched"))
    return dataclasses.replace(done, inputs=(*done.inputs, *inputs), touched=touched)


def _given(**names: str | None) -> list[tuple[str, str]]:
    return [(name, value) for name, value in names.items() if value is not None]


def _problem(layers: Sequence[PlacedLayer], records: Records, walls: str | None) -> Exception | None:
    """The error about a layer that changes nothing; only the whole shows that."""
    if walls is not None and not total(records, "walls"):
        return UsageError(f"{walls}: no layer has walls; give one `edge='wall'`")
    for layer in layers:
        covered, overlap, _ = total(records, f"layer{layer.number}")
        if not covered:
            return covers_nothing(layer.file.name)
        if is_clipped(layer.options) and not overlap:
            return nothing_below(layer.file.name, layer.options.mode)
    return None


def _layer_report(layer: PlacedLayer, frame: Frame, records: Records) -> dict[str, Any]:
    rows, cols = layer.box
    top, left = max(rows.start, 0), max(cols.start, 0)
    bottom, right = min(rows.stop, frame.rows), min(cols.stop, frame.cols)
    share = float(total(records, f"layer{layer.number}")[2]) / (frame.rows * frame.cols)
    o = layer.options
    box = [left, top, right - left, bottom - top]
    return {"name": layer.file.name, "mode": o.mode, "strength": o.strength, "box_px": box, "share": share}


def _paste_tile(job: _Job, tile: Tile) -> None:
    window = job.grid.faces(tile)
    base = map_of(job.background, job.reading).window(*window)
    record: dict[str, Any] = {"curl_before": curl_sums(base.normals, base.coverage >= 0.5)}
    canvas, touched = canvas_of(base, base.frame), False
    for layer in job.layers:
        found = layer.piece(job.folder, window)
        sums = np.zeros(3)
        if found is not None:
            piece, own = found
            o, rows, cols = layer.options, *piece.coverage.shape
            below = canvas.coverage[piece.top : piece.top + rows, piece.left : piece.left + cols]
            sums[:2] = np.count_nonzero(piece.coverage), np.count_nonzero(piece.coverage * below)
            if sums[0]:
                touched = True
                sums[2] = lay(canvas, piece, own, o, is_clipped(o), np.float32(o.edge == "wall"))
        record[f"layer{layer.number}"] = sums
    row, col = window[0].start, window[1].start
    job.layout.write(job.target, row, col, canvas.normals, canvas.coverage)
    for name, values in ((job.placed, canvas.placed), (job.walls, canvas.walls)):
        if name is not None:
            write_grey(name, row, col, values)
    record["walls"] = np.array(np.count_nonzero(canvas.walls))
    record["touched"] = np.array(touched)
    record["curl_after"] = curl_sums(canvas.normals, canvas.coverage >= 0.5) if touched else record["curl_before"]
    job.folder.put(f"written/{tile.row}_{tile.col}", record)
