"""Inspect a large map by streaming: every tile is read once; conventions are found in a sample."""

from __future__ import annotations

import dataclasses
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from nmaptool.core.errors import InputError
from nmaptool.core.grid import dilated
from nmaptool.core.progress import Progress
from nmaptool.core.vectors import inner_vertices
from nmaptool.io.stores.grey import open_grey
from nmaptool.io.stores.normal_maps import NormalMapStore, open_normal_map
from nmaptool.io.stores.sampling import sample_of
from nmaptool.io.stores.windows import widened, within
from nmaptool.io.stores.work import WorkFolder
from nmaptool.maps.blocks import shows_blocks
from nmaptool.maps.channels import as_read, color_channels
from nmaptool.maps.conventions import better_swizzle
from nmaptool.maps.doubts import as_warning
from nmaptool.maps.inspect import inspect_map, with_findings
from nmaptool.maps.layouts import LENGTH_OFF
from nmaptool.maps.windows import WINDOW_MARGIN_PX, decode_window_as_stored
from nmaptool.options import ReadOptions, TilingOptions
from nmaptool.solver.tiling.grid import Box, Tile, TileGrid
from nmaptool.tiled.edits import curl_sums, cut, grey_of, map_of, mean_of, pool_of
from nmaptool.tiled.solving import run_step, teller
from nmaptool.tiled.sweep import Records
from nmaptool.types.inspection import Finding, Inspection
from nmaptool.types.plain_arrays import check_sizes
from nmaptool.types.tiled_inspection import TiledInspection

_BYTES_PER_PIXEL = 120
# px around the motif's outline that are not measured, as `nmaptool.inspect_map`
_RIM = 2
_MOST_PROBLEMS = 5
_LONGEST_TEXT = 2000


@dataclass(frozen=True)
class _Job:
    folder: WorkFolder
    grid: TileGrid
    name: str
    reading: ReadOptions
    mask: str | None


def inspect(
    name: str,
    *,
    reading: ReadOptions | None = None,
    mask: str | None = None,
    tiling: TilingOptions | None = None,
    progress: Progress | None = None,
) -> TiledInspection:
    """Measure a large map tile by tile, and list its problems.

    Parameters
    ----------
    name : str
        Zarr store, folder of tiles, TIFF file or other picture; an array, layer or page may follow after a colon.
    reading : ReadOptions, optional
    mask : str, optional
        Grey picture of the same size: where to measure.
    tiling : TilingOptions, optional
        ``work_folder`` holds the records of the tiles; default: a temporary folder, or with ``scheduler`` the name of
        the map with .work.
    progress : callable, optional

    Returns
    -------
    TiledInspection
        Means and shares are those of `nmaptool.inspect_map` on the same decoding, but the mean |curl| leaves out the
        borders between tiles. Tiles that cannot be read are counted, and the others are measured.

    Raises
    ------
    InputError
        If the map cannot be opened or its sample cannot be decoded, or the mask has another size or selects nothing.
    """
    tiling, reading = tiling or TilingOptions(), reading or ReadOptions()
    opened = open_normal_map(name, reading)
    if mask is not None:
        found = open_grey(mask)
        check_sizes(name, (opened.rows, opened.cols), {"the mask": (found.rows, found.cols)})
    made = cut(opened.rows, opened.cols, tiling, overlap=_RIM + WINDOW_MARGIN_PX, bytes_per_pixel=_BYTES_PER_PIXEL)
    with tempfile.TemporaryDirectory() as temporary, pool_of(tiling, made) as pool:
        shared = None if tiling.scheduler is None else f"{name.rstrip('/')}.work"
        folder = WorkFolder(tiling.work_folder or shared or f"{temporary}/work")
        job = _Job(folder, made.grid, name, opened.settled, mask)
        records = run_step(job, pool, "seen", partial(_inspect_tile, job), teller(progress, "inspecting"))
        folder.remove()
    if mask is not None and not any(record["chosen"] for record in records.values() if "chosen" in record):
        raise InputError("the mask selects nothing: paint the motif white (0.5 or more) on black")
    facts = _facts(opened, reading, records)
    findings = facts.findings
    problems = [bytes(record["problem"]).decode() for record in records.values() if "problem" in record]
    if problems:
        findings = (_unreadable(len(problems), len(records), problems[0]), *findings)
    return TiledInspection(
        dataclasses.replace(facts, findings=findings),
        opened.chunk,
        made.grid.tile,
        len(records),
        len(problems),
        tuple(problems[:_MOST_PROBLEMS]),
        findings,
    )


def _unreadable(count: int, of: int, first: str) -> Finding:
    return Finding(
        "unreadable", f"{count} of {of} tiles cannot be read; the first: {first}", "repair the store, or write it again"
    )


def _inspect_tile(job: _Job, tile: Tile) -> None:
    own, whole = job.grid.faces(tile), (job.grid.rows, job.grid.cols)
    record: dict[str, Any] = {}
    for around in (widened(own, job.grid.overlap, whole), own):  # a neighbour that cannot be read does not count
        try:
            record = _measured(job, own, around)
            break
        except InputError as error:
            record = {"problem": np.frombuffer(str(error).encode()[:_LONGEST_TEXT], np.uint8)}
    job.folder.put(f"seen/{tile.row}_{tile.col}", record)


def _measured(job: _Job, own: Box, around: Box) -> dict[str, Any]:
    """Sums over a tile, from a window around it."""
    store = map_of(job.name, job.reading)
    image = store.picture.read(*around)
    first = around[0].start, around[1].start
    decoded, repaired = decode_window_as_stored(image, store.settled, store.decoding, first)
    normal_map, place = decoded.normal_map, within(own, around)
    foreground = normal_map.foreground
    if job.mask is not None:
        foreground = foreground & (grey_of(job.mask).window(*around) >= 0.5)
    core = (foreground & ~dilated(~foreground, _RIM))[place]
    foreground = foreground[place]
    normals, stored = normal_map.normals[place], decoded.stored[place]
    sums: dict[str, Any] = {"pixels": np.array(core.size), "foreground": np.array(np.count_nonzero(foreground))}
    sums["rim"] = np.array(np.count_nonzero(repaired[place]))
    sums["coverage"] = np.array(normal_map.coverage[place].sum(dtype=np.float64))
    for word, mask in (("core", core), ("all", foreground)):
        error = np.abs(np.linalg.norm(stored[mask].astype(np.float64), axis=1) - 1)
        away = np.count_nonzero(normals[..., 2][mask] <= 0)
        sums[word] = np.array([error.sum(), np.count_nonzero(error > LENGTH_OFF), away, len(error)], np.float64)
        sums[f"{word}_curl"] = curl_sums(normals, mask) if inner_vertices(mask).any() else np.zeros(2)
    if image.pixels.dtype == np.uint8:
        sums["blocks"] = np.array(shows_blocks(color_channels(as_read(image, decoded.channels))[place]))
    chosen = None if job.mask is None else grey_of(job.mask).window(*own) >= 0.5
    return sums if chosen is None else {**sums, "chosen": np.array(np.count_nonzero(chosen))}


def _facts(opened: NormalMapStore, reading: ReadOptions, records: Records) -> Inspection:
    """The measurements of the whole, from those of its tiles."""
    seen: list[Mapping[str, Any]] = [record for record in records.values() if "problem" not in record]
    if not seen:
        raise InputError(f"{opened.name}: no tile of it can be read; restore its chunks, or write it again")

    def summed(key: str) -> Any:
        return np.sum([record[key] for record in seen], axis=0, dtype=np.float64)

    pixels = float(summed("pixels"))
    word = "core" if summed("core")[3] else "all"  # a motif of lines has no core
    error, off, away, count = summed(word)
    count = max(float(count), 1.0)
    blocks = [bool(record["blocks"]) for record in seen if "blocks" in record]
    sample = inspect_map(sample_of(opened.picture, lambda image, first: None)[0], reading)
    measured = dataclasses.replace(
        sample,
        name=opened.name,
        cols=opened.cols,
        rows=opened.rows,
        pitch_mm=opened.pitch_mm,
        decoding=dataclasses.replace(opened.decoding, rim_pixels=int(summed("rim"))),
        outline_sign=opened.decoding.outline_sign,
        better_swizzle=better_swizzle(opened.decoding),
        neutral_bias_px=_over_longer_side(sample, opened),
        foreground_share=float(summed("foreground")) / pixels,
        coverage_mean=float(summed("coverage")) / pixels,
        unit_length_error=float(error) / count,
        off_length_share=float(off) / count,
        away_share=float(away) / count,
        mean_abs_curl=mean_of(summed(f"{word}_curl")),
        has_blocks=2 * sum(blocks) > len(blocks),
    )
    return with_findings(measured, _doubts(sample, opened))


def _over_longer_side(sample: Inspection, opened: NormalMapStore) -> float | None:
    """The tilt of a flat map over the longer side of the whole."""
    tilt = sample.neutral_bias_px
    return None if tilt is None else tilt / max(sample.cols, sample.rows) * max(opened.cols, opened.rows)


def _doubts(sample: Inspection, opened: NormalMapStore) -> Iterator[Finding]:
    """The doubts of the decoder, and those about reading by windows."""
    told = [as_warning(found) for found in sample.findings]
    yield from (found for found in sample.findings if as_warning(found) in opened.decoding.warnings)
    for warning in opened.decoding.warnings:
        if warning not in told:
            message, _, remedy = warning.partition("; ")
            yield Finding("reading", message, remedy)
