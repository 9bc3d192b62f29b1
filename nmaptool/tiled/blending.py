"""Blend large maps by tiles. Every mode works on single pixels, so tiles need no overlap."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from nmaptool.composition.blend import blend_pixels
from nmaptool.core.errors import InputError
from nmaptool.core.progress import Progress, Stages
from nmaptool.io.stores.grey import open_grey
from nmaptool.io.stores.map_output import MapLayout
from nmaptool.io.stores.new_stores import NewStore
from nmaptool.io.stores.normal_maps import NormalMapStore, open_normal_map
from nmaptool.io.stores.work import WorkFolder
from nmaptool.options import BlendOptions, ReadOptions, TilingOptions, WriteOptions
from nmaptool.options.plain_values import plain_values
from nmaptool.solver.tiling.grid import Tile, TileGrid
from nmaptool.tiled.edits import curl_sums, cut, edit, grey_of, map_of, mean_of, stamps_of, total
from nmaptool.tiled.reporting import has_coverage, recipe_text, tiled_edit
from nmaptool.types.composition import ComposeReport
from nmaptool.types.layers import check_mask_size, check_mask_values, mask_is_black
from nmaptool.types.tiled_edit import TiledEdit

# measured: two maps and the result in float32, and the work arrays of a mode
_BYTES_PER_PIXEL = 120


@dataclass(frozen=True)
class _Job:
    folder: WorkFolder
    grid: TileGrid
    base: str
    detail: str
    mask: str | None
    base_reading: ReadOptions
    detail_reading: ReadOptions
    options: BlendOptions
    layout: MapLayout
    target: str


def blend(
    base: str,
    detail: str,
    output: str,
    options: BlendOptions | None = None,
    *,
    mask: str | None = None,
    reading: ReadOptions | None = None,
    writing: WriteOptions | None = None,
    tiling: TilingOptions | None = None,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> TiledEdit[ComposeReport]:
    """Blend a large detail map with a large base map of the same size, tile by tile.

    Parameters
    ----------
    base, detail : str
        Zarr stores, folders of tiles, TIFF files or other pictures; an array, layer or page may follow after a colon.
    output : str
        Zarr store to write; it appears when it is complete.
    options : BlendOptions, optional
        ``fit`` is for maps in memory.
    mask : str, optional
        Grey picture of the same size: factor on the strength.
    reading : ReadOptions, optional
        ``layer`` applies to the base.
    writing : WriteOptions, optional
        Bits "auto" are 16.
    tiling : TilingOptions, optional
    overwrite : bool
        Replace a store that exists.
    progress : callable, optional

    Returns
    -------
    TiledEdit
        With the report of `nmaptool.blend`. The pixels are those of `nmaptool.blend`, bit for bit.

    Raises
    ------
    InputError
        If sizes differ, an input cannot be read or changes meanwhile, or the mask is black.
    OutputError
        If the output exists or cannot be written.
    LimitError
        If there is not enough memory for a tile.
    """
    options, tiling, stages = options or BlendOptions(), tiling or TilingOptions(), Stages(progress)
    store = NewStore(output, "a blended map", overwrite)
    with stages.stage("inputs"):
        below = open_normal_map(base, reading or ReadOptions())
        above = open_normal_map(detail, dataclasses.replace(reading or ReadOptions(), layer=None), like=below)
        _check_sizes(below, above, mask)
        stamps = stamps_of(base, detail, mask)
    made = cut(below.rows, below.cols, tiling, bytes_per_pixel=_BYTES_PER_PIXEL)
    attributes = {"recipe": recipe_text("blend", options)}
    layout = MapLayout(
        *(below.rows, below.cols, below.pitch_mm, made.grid.tile, has_coverage(below)),
        writing or WriteOptions(),
        attributes,
    )
    recipe: dict[str, Any] = {"command": "blend", "options": plain_values(options), "layout": plain_values(layout)}
    recipe |= {"readings": [plain_values(below.settled), plain_values(above.settled)], "mask": mask}
    with edit([store], made, tiling, stamps, recipe, partial(layout.create, store.partial_name), progress) as run:
        readings = below.settled, above.settled
        job = _Job(run.folder, made.grid, base, detail, mask, *readings, options, layout, store.partial_name)
        with stages.stage("blend"):
            records = run.run(job, "written", partial(_blend_tile, job), "blending")
        if mask is not None and not total(records, "mask"):
            run.discard()
            raise mask_is_black(detail, mask)
    overlaps = bool(total(records, "overlap"))
    warnings = () if overlaps else (f"{detail}: does not overlap {base}, so it changes nothing",)
    share = float(total(records, "shown")) / (below.rows * below.cols)
    layer = {"name": detail, "mode": options.mode, "strength": options.strength, "share": share}
    report = ComposeReport(
        command="blend",
        options=plain_values(options),
        layers=(layer,),
        curl_before=mean_of(total(records, "curl_before")),
        curl_after=mean_of(total(records, "curl_after")),
        seconds=stages.seconds(),
        warnings=warnings,
    )
    return tiled_edit(report, output, made, run.resumed, (below, above))


def _check_sizes(base: NormalMapStore, detail: NormalMapStore, mask: str | None) -> None:
    if (base.rows, base.cols) != (detail.rows, detail.cols):
        raise InputError(
            f"{detail.name} is {detail.cols} x {detail.rows}, but {base.name} is {base.cols} x {base.rows}; large maps "
            "are blended only if they have the same size: place the detail with paste"
        )
    if mask is not None:
        found = open_grey(mask)
        check_mask_size(detail.name, (found.rows, found.cols), (base.rows, base.cols), mask)


def _blend_tile(job: _Job, tile: Tile) -> None:
    window = job.grid.faces(tile)
    base = map_of(job.base, job.base_reading).window(*window)
    detail = map_of(job.detail, job.detail_reading).window(*window)
    mask = None
    if job.mask is not None:
        mask = grey_of(job.mask).window(*window)
        check_mask_values(mask, job.detail, job.mask)
    normals, strength = blend_pixels(base, detail, job.options, mask)
    job.layout.write(job.target, window[0].start, window[1].start, normals, base.coverage)
    defined = base.coverage >= 0.5
    shown = np.broadcast_to(np.asarray(strength, np.float32) > 0, defined.shape)
    job.folder.put(
        f"written/{tile.row}_{tile.col}",
        {
            "curl_before": curl_sums(base.normals, defined),
            "curl_after": curl_sums(normals, defined),
            "shown": np.array(np.count_nonzero(shown)),
            "overlap": np.array(np.count_nonzero(detail.coverage * base.coverage)),
            "mask": np.array(0 if mask is None else np.count_nonzero(mask)),
        },
    )
