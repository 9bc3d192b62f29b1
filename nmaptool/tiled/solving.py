"""Solve the system of a relief by sweeps over its tiles until the residual is small enough."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import ConvergenceError
from nmaptool.core.progress import Progress
from nmaptool.solver.tiling.coarse import CoarseProblem, add_block, empty_sum
from nmaptool.solver.tiling.grid import Tile
from nmaptool.solver.tiling.islands import merge
from nmaptool.tiled.assembly import assemble
from nmaptool.tiled.job import ReliefJob, TileJob
from nmaptool.tiled.sweep import Records, Remainder, heights_name, sweep
from nmaptool.types.shown import counted

# by how much a tile reduces its residual in one sweep; more would be lost at the borders
_REDUCTION = 1e-4
# a load this small compared to its level is rounding error
_ROUNDING = 1e-15


class Pool(Protocol):
    """Runs tasks, in this process or on workers."""

    def each(self, work: Callable[[Tile], object], tiles: Iterable[Tile], done: Callable[[], object]) -> None:
        """Call ``work`` with every tile, and ``done`` as each is finished."""


@dataclass(frozen=True, eq=False)
class Islands:
    """The islands of the whole picture.

    Attributes
    ----------
    numbers : dict of Tile to (count+1,) int32
        Number among all of each island of a tile.
    count : int
    level : (count+1,) float64
        The constant that solves each island in sum; 0 where vertices are held.
    scale : (count+1,) float64
        Norm of the load without that level.
    ties, sizes : (count+1,) float64
        Sum of beta, and number of vertices.
    loose : (count+1,) bool
        Islands without held vertices.
    """

    numbers: dict[Tile, NDArray[np.int32]]
    count: int
    level: Float64
    scale: Float64
    ties: Float64
    sizes: Float64
    loose: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Swept:
    """The heights of one load after the last sweep.

    Attributes
    ----------
    array : str
        Name of the array in the folder.
    records : dict of Tile to mapping
        Those of the last sweep.
    residual : float
        Relative, the largest over the islands.
    iterations : int
        Largest number of iterations of a tile, summed over the sweeps.
    history : tuple of float
    islands : Islands
    """

    array: str
    records: Records
    residual: float
    iterations: int
    history: tuple[float, ...]
    islands: Islands


def run_step(
    job: TileJob, pool: Pool, step: str, work: Callable[[Tile], object], tell: Callable[[float], object]
) -> Records:
    """Run one step for all tiles that have no record of it yet, and return all records."""
    folder, grid = job.folder, job.grid
    known: Records = {}
    for tile in grid:
        record = folder.get(f"{step}/{tile.row}_{tile.col}")
        if record is not None:
            known[tile] = record
    missing = [tile for tile in grid if tile not in known]
    finished = len(known)

    def done() -> None:
        nonlocal finished
        finished += 1
        tell(finished / len(grid))

    pool.each(work, missing, done)
    for tile in missing:
        record = folder.get(f"{step}/{tile.row}_{tile.col}")
        assert record is not None
        known[tile] = record
    return known


def assembled(job: ReliefJob, pool: Pool, progress: Progress | None) -> Records:
    """Run the first pass."""
    grid, folder = job.grid, job.folder
    vertices = grid.rows + 1, grid.cols + 1
    tile = grid.tile
    folder.make_array("weight", (grid.rows, grid.cols), "f4", tile, packed=True)
    folder.make_array("beta", vertices, "f4", tile, packed=True)
    folder.make_array("state", vertices, "u1", tile, packed=True)
    if job.files.surface is not None:
        folder.make_array("base", vertices, "f8", tile)
    rows, cols = grid.coarse_shape
    for load in job.loads:
        folder.make_array(load, vertices, "f8", tile)
        folder.make_array(f"{load}_coarse", (rows + 2, cols + 2), "f8", tile)
        for number in (0, 1):
            folder.make_array(heights_name(load, number), vertices, "f8", tile)
    return run_step(job, pool, "assembled", partial(assemble, job), teller(progress, "reading maps"))


def coarse_problem(job: ReliefJob) -> CoarseProblem:
    """Return the coarse problem."""
    grid = job.grid
    weight, tie, reach = np.zeros(grid.coarse_shape), empty_sum(grid), empty_sum(grid)
    for tile in grid:
        rows, cols = grid.faces(tile)
        blocks = job.folder.known("assembled_blocks", tile)
        mean = blocks["mean"]
        first, left = rows.start // grid.factor, cols.start // grid.factor
        weight[first : first + mean.shape[0], left : left + mean.shape[1]] = mean
        add_block(tie, blocks["tie"], grid, tile)
        add_block(reach, blocks["reach"], grid, tile)
    return CoarseProblem(weight, tie, reach)


def islands_of(job: ReliefJob, records: Records, load: str) -> Islands:
    """Merge the islands of all tiles, and sum their loads."""
    grid = job.grid
    tiles = list(grid)
    place = {tile: k for k, tile in enumerate(tiles)}
    pairs = []
    for tile in tiles:
        for other, side, there in (
            (Tile(tile.row - 1, tile.col), "top", "bottom"),
            (Tile(tile.row, tile.col - 1), "left", "right"),
        ):
            if other in place:
                pair = records[tile][f"faces_{side}"], records[other][f"faces_{there}"]
                pairs.append((place[tile], pair[0], place[other], pair[1]))
    numbers, count = merge([int(records[tile]["islands"]) for tile in tiles], pairs)
    sums = np.zeros((count + 1, 7))
    for tile in tiles:
        np.add.at(sums, numbers[place[tile]], records[tile][f"{load}_sums"])
    sums[0] = 0
    squares, loads, ties, products, beta2, held, sizes = sums.T
    loose = held == 0
    loose[0] = False
    tied = loose & (ties > 0)
    level = np.divide(loads, ties, out=np.zeros(count + 1), where=tied)
    rest = squares - 2 * level * products + level * level * beta2
    scale = np.sqrt(np.maximum(rest, 0))
    scale[scale <= _ROUNDING * np.sqrt(squares)] = 0
    return Islands(dict(zip(tiles, numbers, strict=True)), count, level, scale, ties, sizes, loose)


def solve(
    job: ReliefJob, pool: Pool, load: str, records: Records, coarse: CoarseProblem, progress: Progress | None
) -> Swept:
    """Solve for one load.

    Raises
    ------
    ConvergenceError
        If the residual does not become small enough.
    """
    grid, options = job.grid, job.options
    islands = islands_of(job, records, load)
    total = empty_sum(grid)
    for tile in grid:
        add_block(total, job.folder.known("assembled_blocks", tile)[load], grid, tile)
    history: list[float] = []
    iterations = 0
    tell = teller(progress, "solving")
    for number in range(1, options.max_iterations + 1):
        _send_coarse(job, load, coarse.solve(total))
        step = f"{load}_sweep{number}"
        at = _share_done(history, options.tolerance)
        swept = run_step(
            job,
            pool,
            step,
            partial(sweep, job, load, number, _REDUCTION),
            lambda share, at=at: tell(at + share * (1 - at) / 3),  # type: ignore[misc]
        )
        left = Remainder(job, load, number, records, swept, islands.numbers, islands.count)
        relative = np.sqrt(left.squares[1:]) / np.where(islands.scale[1:] > 0, islands.scale[1:], np.inf)
        history.append(float(relative.max(initial=0.0)))
        iterations += max(int(record["iterations"]) for record in swept.values())
        if history[-1] <= options.tolerance:
            return Swept(heights_name(load, number), swept, history[-1], iterations, tuple(history), islands)
        if number > 4 and min(history[-3:]) > 0.9 * min(history[:-3]):
            break
        total = left.coarse
    raise ConvergenceError(
        f"the tiles stopped at a relative residual of {history[-1]:.1e} after {counted(len(history), 'sweep')}, but "
        f"the tolerance is {options.tolerance:.0e}; raise `max_iterations` or `tolerance`, or use a larger `beta` "
        f"(history: {' '.join(f'{r:.1e}' for r in history[-8:])})",
        tuple(history),
    )


def _send_coarse(job: ReliefJob, load: str, values: Any) -> None:
    job.folder.write(f"{load}_coarse", (slice(0, values.shape[0]), slice(0, values.shape[1])), values)


def _share_done(history: list[float], tolerance: float) -> float:
    """Share of the way to the tolerance, on a logarithmic scale."""
    return 0.0 if not history else float(np.clip(np.log(history[-1]) / np.log(tolerance), 0, 1))


def teller(progress: Progress | None, stage: str) -> Callable[[float], object]:
    """A callback for the share done of a stage."""
    return (lambda _: None) if progress is None else (lambda share: progress(stage, min(share, 1.0)))
