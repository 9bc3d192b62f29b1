"""The passes over the tiles that solve the system, and what the driver does between them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.solver.tiling.borders import Strip, strip_residual
from nmaptool.solver.tiling.coarse import add_block, empty_sum
from nmaptool.solver.tiling.grid import Tile, inside, of_vertices
from nmaptool.solver.tiling.tile import TileSystem, correct, restricted
from nmaptool.solver.tiling.transfer import coarse_box, prolong, restrict
from nmaptool.tiled.assembly import SURFACE, UNKNOWN, add_lines, sum_by_label, tile_labels
from nmaptool.tiled.job import ReliefJob

Records = dict[Tile, dict[str, NDArray[Any]]]


def heights_name(load: str, number: int) -> str:
    """The array with the heights after a sweep; two take turns."""
    return f"{load}_z{number % 2}"


def sweep(job: ReliefJob, load: str, number: int, reduction: float, tile: Tile) -> None:
    """Correct the heights of a tile in sweep ``number`` (1 for the first), store them, and record what remains."""
    grid, folder = job.grid, job.folder
    window = grid.window(tile)
    corners = of_vertices(window)
    state = folder.read("state", corners)
    unknown = (state & UNKNOWN) > 0
    coarse = folder.read(f"{load}_coarse", coarse_box(corners, grid.factor))
    z = prolong(coarse, corners, grid.factor)
    base = folder.read("base", corners) if job.base_of(load) else None
    z[~unknown] = 0 if base is None or number > 1 else base[~unknown]
    if number > 1:
        z += folder.read(heights_name(load, number - 1), corners)
    weight = folder.read("weight", window)
    system = TileSystem(weight, folder.read("beta", corners), unknown, folder.read(load, corners), z)
    done = correct(system, grid, tile, reduction, job.options.solver)
    vertices = grid.vertices(tile)
    folder.check_owner()
    folder.write(heights_name(load, number), vertices, done.z)
    _, labels, count = tile_labels(job, tile, weight, window)
    own_state = state[inside(vertices, corners)]
    above = done.z if base is None else done.z - base[inside(vertices, corners)]
    on_surface = above[(own_state & SURFACE) > 0]
    record: dict[str, Any] = {
        "squares": sum_by_label(labels, count, done.residual * done.residual),
        "range": np.array([on_surface.min(initial=np.inf), on_surface.max(initial=-np.inf)]),
        "iterations": np.array(done.iterations),
    }
    add_lines(record, "z", done.z, 2)
    step, place = f"{load}_sweep{number}", f"{tile.row}_{tile.col}"
    folder.put(f"{step}_blocks/{place}", {"residual": restricted(done.residual, grid, tile)})
    folder.put(f"{step}/{place}", record)


class Remainder:
    """The residual after a sweep, from the records of its tiles.

    Parameters
    ----------
    job : ReliefJob
    load : str
    number : int
        Of the sweep.
    assembled, swept : dict of Tile to mapping
        Records of the first pass and of the sweep.
    numbers : dict of Tile to (count+1,) int32
        The number of each island of a tile among all.
    count : int
        Number of islands.
    """

    def __init__(
        self,
        job: ReliefJob,
        load: str,
        number: int,
        assembled: Records,
        swept: Records,
        numbers: dict[Tile, NDArray[np.int32]],
        count: int,
    ) -> None:
        grid = job.grid
        self._grid, self._load = grid, load
        self._assembled, self._swept, self._numbers = assembled, swept, numbers
        self.squares = np.zeros(count + 1)
        self.coarse: Float64 = empty_sum(grid)
        for tile in grid:
            add_block(self.coarse, job.folder.known(f"{load}_sweep{number}_blocks", tile)["residual"], grid, tile)
            np.add.at(self.squares, numbers[tile], swept[tile]["squares"])
        self._add_borders()

    def _add_borders(self) -> None:
        grid = self._grid
        for row in range(1, grid.down):
            self._add(row, across=True)
        for col in range(1, grid.across):
            self._add(col, across=False)

    def _add(self, number: int, across: bool) -> None:
        """Add the residual along one border; where borders cross, it belongs to those between rows."""
        grid = self._grid
        count = grid.across if across else grid.down
        pairs = [
            (Tile(number - 1, k), Tile(number, k)) if across else (Tile(k, number - 1), Tile(k, number))
            for k in range(count)
        ]
        sides = ("bottom", "top") if across else ("right", "left")

        def line(records: Records, name: str, which: int) -> NDArray[Any]:
            parts = [records[pair[which]][f"{name}_{sides[which]}"] for pair in pairs]
            return np.concatenate(parts, axis=1) if across else np.concatenate([part.T for part in parts], axis=1)

        def middle(name: str) -> NDArray[Any]:
            return np.concatenate([line(self._assembled, name, 0), line(self._assembled, name, 1)])

        strip = Strip(
            np.concatenate([line(self._swept, "z", 0), line(self._swept, "z", 1)]),
            np.ascontiguousarray(
                np.concatenate([line(self._assembled, "weight", 0), line(self._assembled, "weight", 1)[:1]])
            ),
            middle("beta"),
            middle("unknown"),
            middle(self._load),
        )
        residual = strip_residual(strip)
        if not across:
            for row in range(1, grid.down):
                residual[:, row * grid.tile - 1 : row * grid.tile + 1] = 0
        labels = np.concatenate(
            [
                np.concatenate([self._numbers[p[which]][self._labels(p[which], sides[which], across)] for p in pairs])[
                    None
                ]
                for which in (0, 1)
            ]
        )
        self.squares += np.bincount(labels.ravel(), (residual * residual).ravel(), len(self.squares))
        first = number * grid.tile - 1
        place = slice(first, first + 2), slice(0, residual.shape[1])
        box = place if across else (place[1], place[0])
        self.coarse[coarse_box(box, grid.factor)] += restrict(
            residual if across else np.ascontiguousarray(residual.T), box, grid.factor
        )

    def _labels(self, tile: Tile, side: str, across: bool) -> NDArray[Any]:
        line = self._assembled[tile][f"labels_{side}"]
        return line[0] if across else line[:, 0]
