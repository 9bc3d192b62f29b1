"""What edits of large maps share: the cut into tiles, and the run, which goes on where an earlier one was stopped."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool._version import __version__
from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.errors import InputError, LimitError, UsageError
from nmaptool.core.memory import available_bytes
from nmaptool.core.parallel import cores
from nmaptool.core.progress import Progress
from nmaptool.core.units import memory_text
from nmaptool.core.vectors import inner_vertices, mean_abs_curl
from nmaptool.io.pictures.layer_names import Holds
from nmaptool.io.stores.grey import GreyStore, open_grey
from nmaptool.io.stores.names import ZARR_FILES, split_name
from nmaptool.io.stores.new_stores import NewStore
from nmaptool.io.stores.normal_maps import NormalMapStore, reopen_normal_map
from nmaptool.io.stores.opening import open_picture
from nmaptool.io.stores.work import WorkFolder
from nmaptool.options import ReadOptions, TilingOptions
from nmaptool.solver.tiling.grid import Tile, TileGrid
from nmaptool.tiled.job import TileJob
from nmaptool.tiled.pools import HerePool, cluster_pool, local_pool
from nmaptool.tiled.solving import Pool, run_step, teller
from nmaptool.tiled.sweep import Records
from nmaptool.types.windows import PictureStore

# where the system does not report its memory; and the share of the free memory that a run may use
_ASSUMED_MEMORY = 8_000_000_000
_SHARE = 0.8
# Python with its libraries, per process
_BYTES_PER_PROCESS = 250_000_000
_TILES = (2048, 1024, 512)
# with fewer tiles for each worker, starting the workers takes longer than the work
_LEAST_TILES = 2


@dataclass(frozen=True)
class Cut:
    """How an edit is cut.

    Attributes
    ----------
    grid : TileGrid
    workers : int
        Processes; 0 for a run in this one.
    worker_bytes : int
        Estimated memory of each.
    """

    grid: TileGrid
    workers: int
    worker_bytes: int


def cut(rows: int, cols: int, tiling: TilingOptions, *, overlap: int = 0, bytes_per_pixel: int = 100) -> Cut:
    """Cut a picture into the largest tiles for which there is memory.

    Parameters
    ----------
    rows, cols : int
    tiling : TilingOptions
    overlap : int
        Pixels around a tile that its result depends on.
    bytes_per_pixel : int
        Memory of the work on a pixel of a tile with its overlap.

    Raises
    ------
    LimitError
        If there is not enough memory for one worker.
    """
    free = available_bytes()
    memory = _ASSUMED_MEMORY if free is None else int(_SHARE * free)
    whole = -(-max(rows, cols) // 64) * 64
    least = 0
    for side in _TILES if tiling.tile is None else (tiling.tile,):
        grid = TileGrid(rows, cols, min(side, whole), overlap, 1)
        window = min(grid.tile + 2 * overlap, rows) * min(grid.tile + 2 * overlap, cols)
        each = least = window * bytes_per_pixel + _BYTES_PER_PROCESS
        if tiling.scheduler is not None:  # the memory of those workers is not known
            return Cut(grid, 0, each)
        most = min(tiling.workers or cores(), max(1, len(grid) // _LEAST_TILES))
        if memory >= each and (tiling.tile is not None or tiling.workers is None or most * each <= memory):
            count = min(most, memory // each)
            return Cut(grid, count if count > 1 else 0, each)
    raise LimitError(
        f"{cols} x {rows} px by tiles: one tile with its overlap of {overlap} px needs about {memory_text(least)} of "
        f"memory, but only {memory_text(memory)} may be used; use a smaller `tile`, fewer `workers` or a machine with "
        "more memory"
    )


def map_of(name: str, settled: ReadOptions) -> NormalMapStore:
    """A normal map, opened once in each process."""
    return _map(name, settled, _written(name))


def grey_of(name: str) -> GreyStore:
    """A mask, opened once in each process."""
    return _grey(name, _written(name))


def picture_of(name: str, layer: str | None, holds: Holds) -> PictureStore:
    """A picture, opened once in each process."""
    return _picture(name, layer, holds, _written(name))


@lru_cache(maxsize=8)
def _map(name: str, settled: ReadOptions, written: int) -> NormalMapStore:
    return reopen_normal_map(name, settled)


@lru_cache(maxsize=8)
def _grey(name: str, written: int) -> GreyStore:
    return open_grey(name)


@lru_cache(maxsize=8)
def _picture(name: str, layer: str | None, holds: Holds, written: int) -> PictureStore:
    return open_picture(name, layer, holds=holds)


def _written(name: str) -> int:
    """When a store was created, or a file written, for those on this machine; workers may live longer than a store."""
    place = split_name(name)
    if place.path is None:
        return 0
    within = place.path / (place.layer or "")
    for file in (*(within / entry for entry in ZARR_FILES), place.path):
        with contextlib.suppress(OSError):
            return file.stat().st_mtime_ns
    return 0


def stamps_of(*names: str | None) -> dict[str, str]:
    """For each input, a text that changes when it does."""
    return {name: open_picture(name).stamp() for name in names if name is not None}


def refuse_input(output: str, stamps: Mapping[str, str]) -> None:
    """Refuse to write over an input.

    Raises
    ------
    UsageError
    """
    place = output.rstrip("/")
    if any(split_name(name).place.rstrip("/") == place for name in stamps):
        raise UsageError(f"{output}: is also an input; give another name for the output")


class Edit:
    """A run of an edit: its pool, and the tiles that are finished.

    Attributes
    ----------
    folder : WorkFolder
    pool : Pool
    resumed : int
        Tiles that an earlier run finished.
    """

    def __init__(
        self, folder: WorkFolder, stores: Sequence[NewStore], pool: Pool, resumed: int, progress: Progress | None
    ) -> None:
        self.folder, self.pool, self.resumed = folder, pool, resumed
        self._stores, self._progress = stores, progress

    def run(self, job: TileJob, step: str, work: Callable[[Tile], object], stage: str) -> Records:
        """Do a step for all tiles that have no record of it; return the records of all."""
        return run_step(job, self.pool, step, work, teller(self._progress, stage))

    def discard(self) -> None:
        """Remove what was written, because running again would not help."""
        for store in self._stores:
            store.remove_partial()
        self.folder.remove()


@contextlib.contextmanager
def edit(
    stores: Sequence[NewStore],
    made: Cut,
    tiling: TilingOptions,
    stamps: Mapping[str, str],
    recipe: Mapping[str, Any],
    create: Callable[[], object],
    progress: Progress | None,
) -> Iterator[Edit]:
    """Run an edit: create its stores, or go on with those of a run that was stopped, and name them at the end.

    Parameters
    ----------
    stores : sequence of NewStore
        The first names the work folder.
    made : Cut
    tiling : TilingOptions
    stamps : mapping
        As `stamps_of`.
    recipe : mapping
        What else the result depends on, as plain values.
    create : callable
        Creates the stores under their partial names.
    progress : callable, optional

    Raises
    ------
    InputError
        If an input changes meanwhile.
    OutputError
        If another run writes the same store.
    """
    for store in stores:
        refuse_input(store.place, stamps)
    if len({store.place for store in stores}) < len(stores):
        raise UsageError(f"{stores[0].place}: two outputs have the same name")
    folder = WorkFolder(tiling.work_folder or f"{stores[0].place}.work")
    whole = {"version": __version__, "inputs": dict(stamps), "grid": dataclasses.asdict(made.grid), **recipe}
    with folder.locked():
        if folder.recipe() == whole and all(store.has_partial() for store in stores):
            resumed = folder.finished()
        else:
            folder.clear()
            create()
            folder.begin(whole)
            resumed = 0
        with pool_of(tiling, made) as pool:
            yield Edit(folder, stores, pool, resumed, progress)
        for name, stamp in stamps.items():
            if open_picture(name).stamp() != stamp:
                raise InputError(f"{name}: changed while it was read; wait until it is complete, and run again")
        for store in stores:
            store.finish()
        folder.remove()


def pool_of(tiling: TilingOptions, made: Cut) -> contextlib.AbstractContextManager[Pool]:
    """The workers of a run: those of a cluster, of this machine, or this process."""
    if tiling.scheduler is not None:
        return cluster_pool(tiling.scheduler)
    if not made.workers:
        return contextlib.nullcontext(HerePool())
    return local_pool(made.workers, 2 * made.worker_bytes)


def curl_sums(normals: Float32, mask: Mask) -> NDArray[np.float64]:
    """(2,): the sum of |curl| over the vertices inside a mask, and their number."""
    count = int(np.count_nonzero(inner_vertices(mask)))
    return np.array([count * mean_abs_curl(normals, mask), count], np.float64)


def total(records: Mapping[Tile, Mapping[str, NDArray[Any]]], name: str) -> NDArray[np.float64]:
    """The sum of an entry over all records."""
    parts = [record[name] for record in records.values()]
    return np.asarray(np.sum(parts, axis=0, dtype=np.float64), np.float64)


def mean_of(sums: Sequence[float] | NDArray[np.float64]) -> float:
    """A sum divided by a count; 0 if there is nothing."""
    return float(sums[0] / sums[1]) if sums[1] else 0.0
