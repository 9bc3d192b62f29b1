"""The work on one tile: the system of its window, the correction of its heights, and what remains."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Float64, Mask
from nmaptool.solver.prepare import prepare
from nmaptool.solver.system import QuadSystem
from nmaptool.solver.tiling.grid import Box, Tile, TileGrid, inside, of_vertices
from nmaptool.solver.tiling.transfer import restrict


@dataclass(frozen=True, eq=False)
class TileSystem:
    """The system in the window of a tile, with the heights found so far.

    Attributes
    ----------
    weight : (h, w) float32
    beta : (h+1, w+1) float32
    unknown : (h+1, w+1) bool
        Vertices whose height is unknown in the whole picture.
    load : (h+1, w+1) float64
    z : (h+1, w+1) float64
        Heights; those of held vertices are final.
    """

    weight: Float32
    beta: Float32
    unknown: Mask
    load: Float64
    z: Float64


@dataclass(frozen=True, eq=False)
class Lines:
    """The outermost two rows and columns of the vertices that a tile owns.

    Attributes
    ----------
    top, bottom : (2, w) array
    left, right : (h, 2) array
    """

    top: NDArray[Any]
    bottom: NDArray[Any]
    left: NDArray[Any]
    right: NDArray[Any]


def lines_of(values: NDArray[Any], width: int = 2) -> Lines:
    """Return copies of the outermost rows and columns."""
    return Lines(values[:width].copy(), values[-width:].copy(), values[:, :width].copy(), values[:, -width:].copy())


@dataclass(frozen=True, eq=False)
class Correction:
    """New heights of the vertices that a tile owns, and their residual where no other tile affects it.

    Attributes
    ----------
    z : (h, w) float64
        Heights of the vertices of the tile.
    residual : (h, w) float64
        0 at held vertices and along borders to other tiles.
    iterations : int
    """

    z: Float64
    residual: Float64
    iterations: int


def correct(
    system: TileSystem, grid: TileGrid, tile: Tile, reduction: float, solver: str = "multigrid", most: int = 100
) -> Correction:
    """Solve a tile's window, with its border towards other tiles held at the present heights.

    Parameters
    ----------
    system : TileSystem
    grid : TileGrid
    tile : Tile
    reduction : float
        By how much to reduce the residual of the window.
    solver : str
        A `nmaptool.options.SolverName`.
    most : int
        Largest number of iterations.

    Raises
    ------
    ConvergenceError
        If the solver does not reach the reduction.
    """
    window = grid.window(tile)
    held = ~system.unknown
    _set_border(held, True, window, grid)
    z, iterations = system.z, 0
    left = np.empty(system.load.shape)
    whole = None
    if system.weight.any():
        whole = QuadSystem(system.weight, system.beta, ~system.unknown)
        inner = QuadSystem(system.weight, system.beta, held)
        if inner.residual(system.load, z, left) > 0:
            name = "multigrid" if solver == "dct" else solver
            solution = prepare(inner, name).solve(left, tolerance=reduction, max_iterations=most)
            z = z + solution.z
            iterations = solution.iterations
        whole.residual(system.load, z, left)
    else:
        left[...] = 0
    own = inside(grid.vertices(tile), of_vertices(window))
    residual = left[own].copy()
    # there it depends on heights of other tiles; see nmaptool.solver.tiling.borders
    _set_border(residual, 0, grid.faces(tile), grid)
    return Correction(np.ascontiguousarray(z[own]), residual, iterations)


def _set_border(values: NDArray[Any], value: Any, box: Box, grid: TileGrid) -> None:
    """Set the values along those sides of a box that are not sides of the picture."""
    rows, cols = box
    if rows.start > 0:
        values[0] = value
    if rows.stop < grid.rows:
        values[-1] = value
    if cols.start > 0:
        values[:, 0] = value
    if cols.stop < grid.cols:
        values[:, -1] = value


def restricted(values: Float64, grid: TileGrid, tile: Tile) -> Float64:
    """Values of a tile's vertices, summed into the coarse vertices around it."""
    return restrict(values, grid.vertices(tile), grid.factor)


def face_means(weight: Float32, grid: TileGrid) -> Float64:
    """(h/f, w/f) float64: mean weight of the faces in each coarse face; faces outside the picture count as 0."""
    factor = grid.factor
    rows, cols = (-(-size // factor) * factor for size in weight.shape)
    padded = np.zeros((rows, cols))
    padded[: weight.shape[0], : weight.shape[1]] = weight
    out: Float64 = padded.reshape(rows // factor, factor, cols // factor, factor).mean(axis=(1, 3))
    return out
