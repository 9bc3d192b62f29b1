"""How a large map is cut, within a memory limit: the coarse grid, the tiles, their overlap, the number of workers."""

from __future__ import annotations

from dataclasses import dataclass

from nmaptool.core.errors import LimitError
from nmaptool.core.units import memory_text
from nmaptool.solver.tiling.grid import TileGrid

# measured by bench.tiled at the peak of each pass, per vertex of a window and per vertex of the coarse grid
BYTES_PER_VERTEX = 110
BYTES_PER_COARSE_VERTEX = 115
# Python with its libraries, per process
_BYTES_PER_PROCESS = 200_000_000
# vertices of the coarse grid that the overlap spans: errors at the sides of a window shrink by e^-2 pi within about ten
_COARSE_OVERLAP = 32
_FACTORS = (4, 8, 16, 32, 64)
_TILES = (4096, 2048, 1024, 512)
# tiles are multiples of this, so that they consist of large chunks
_SMALLEST = 64
# fewer tiles for each worker leave workers idle at the end of a pass
_LEAST_TILES = 8


@dataclass(frozen=True)
class Plan:
    """How a run is cut, and its memory.

    Attributes
    ----------
    grid : TileGrid
    workers : int
        0 for a run in one process.
    worker_bytes, coarse_bytes : int
        Estimated memory of a worker, and of the coarse grid.
    disk_bytes : int
        Space that the work folder needs.
    """

    grid: TileGrid
    workers: int
    worker_bytes: int
    coarse_bytes: int
    disk_bytes: int

    @property
    def work(self) -> float:
        """Estimated time of a sweep, relative to that of one worker without overlap and coarse grid."""
        grid = self.grid
        side = grid.tile + 2 * grid.overlap
        return (side / grid.tile) ** 2 / max(1, self.workers) + 1 / grid.factor**2

    @property
    def total_bytes(self) -> int:
        """Estimated memory of the run on this machine; the coarse grid is solved while the workers rest."""
        return max(1, self.workers) * self.worker_bytes + self.coarse_bytes


def plan(
    rows: int,
    cols: int,
    cores: int,
    memory_bytes: int,
    *,
    tile: int | None = None,
    workers: int | None = None,
    loads: int = 1,
) -> Plan:
    """Cut a picture.

    Parameters
    ----------
    rows, cols : int
        In faces.
    cores : int
        Most workers, unless ``workers`` says otherwise.
    memory_bytes : int
        Memory of the machine that the run may use.
    tile : int, optional
        Side of a tile. Default: the largest for which there is memory.
    workers : int, optional
    loads : int
        Number of loads to solve for.

    Raises
    ------
    LimitError
        If even the smallest plan needs more memory.
    """
    counts = range(cores, 0, -1) if workers is None else (workers,)
    sides = _TILES if tile is None else (tile,)
    plans = [
        _plan_of(rows, cols, side, factor, count, loads) for factor in _FACTORS for count in counts for side in sides
    ]
    small = _TILES[-1]
    busy = [found for found in plans if found.grid.tile <= small or len(found.grid) >= _LEAST_TILES * found.workers]
    fitting = [found for found in (busy or plans) if found.total_bytes <= memory_bytes]
    if fitting:
        return min(fitting, key=lambda found: found.work)
    least = min(plans, key=lambda found: found.total_bytes)
    raise LimitError(
        f"{cols} x {rows} px by tiles: needs about {memory_text(least.total_bytes)} of memory, "
        f"`memory_limit` allows {memory_text(memory_bytes)}; raise it to {memory_text(least.total_bytes * 21 // 20)}"
    )


def _plan_of(rows: int, cols: int, tile: int, factor: int, workers: int, loads: int) -> Plan:
    overlap = _COARSE_OVERLAP * factor
    side = min(tile, -(-max(rows, cols) // _SMALLEST) * _SMALLEST)
    grid = TileGrid(rows, cols, side, overlap, factor)
    window = (min(side + 2 * overlap, rows) + 1) * (min(side + 2 * overlap, cols) + 1)
    coarse_shape = grid.coarse_shape
    coarse = (coarse_shape[0] + 2) * (coarse_shape[1] + 2)
    pixels = rows * cols
    disk = pixels * (5 + 24 * loads)
    return Plan(
        grid,
        workers,
        window * BYTES_PER_VERTEX + _BYTES_PER_PROCESS,
        coarse * BYTES_PER_COARSE_VERTEX + _BYTES_PER_PROCESS,
        disk,
    )
