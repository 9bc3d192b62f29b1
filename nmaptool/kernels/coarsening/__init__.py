"""The next coarser level of the multigrid solver, in NumPy: the twins of ``coarsening.h``, for any float type.

A band of a level is sorted by kind of vertex (`split`); then come the weights of the interpolation (`interpolation`)
and the couplings and ties of the coarser level (`galerkin`).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from nmaptool.kernels.coarsening.finest_couplings import finest_couplings
from nmaptool.kernels.coarsening.galerkin import coarse_couplings, coarse_ties
from nmaptool.kernels.coarsening.interpolation import WEIGHTS as WEIGHTS
from nmaptool.kernels.coarsening.interpolation import interpolate
from nmaptool.kernels.coarsening.split import DIRECTIONS as DIRECTIONS
from nmaptool.kernels.coarsening.split import HALO, KINDS, Split, sorted_rows
from nmaptool.kernels.grid_twins import Values

# fields of a level that `coarsen_coarse` finds, in the order of its last four results
BACK = ("stray", "scale", "lack", "rest")


def coarsen_finest(
    inputs: tuple[Values, Values, NDArray[np.bool_]],
    results: tuple[Values, ...],
    rows: int,
    cols: int,
    first: int,
    last: int,
    holds: bool,
) -> float:
    """Write rows ``first`` to ``last`` of the first coarse level; returns 0.

    Parameters
    ----------
    inputs : tuple
        A quarter of the weight of each face (flat with margins), and beta and whether a vertex is unknown (flat).
    results : tuple of 13 flat arrays with margins
        Weights of the interpolation (`WEIGHTS`), couplings (`DIRECTIONS`) and ties, in the layout of the coarse grid.
    rows, cols : int
        Vertices of the finest level.
    first, last : int
    holds : bool
        Whether couplings to vertices that are not unknown are ties.
    """
    quarter, beta, unknown = inputs
    coarse = (rows + 1) // 2, (cols + 1) // 2
    top, bottom = max(2 * (first - HALO) - 2, 0), min(2 * (last + HALO) + 2, rows)
    couplings = finest_couplings(quarter, beta, unknown if holds else None, (rows, cols), top, bottom)
    split = _sorted(couplings, top, coarse, first, last)
    for kind, _, _ in KINDS:
        split.keep(f"out_{kind}")
    _write(split, results, first, last)
    return 0.0


def coarsen_coarse(
    inputs: tuple[Values, ...], results: tuple[Values, ...], rows: int, cols: int, first: int, last: int
) -> float:
    """Write rows ``first`` to ``last`` of the level below a coarse level; returns 0.

    Parameters
    ----------
    inputs : tuple of 6 flat arrays
        Couplings to the east, south, south-east and south-west and ties, with margins; couplings to off-grid vertices,
        without margins, or an empty array if there are none.
    results : tuple of 17 flat arrays
        The first 13 as for `coarsen_finest`; then, at the vertices of the level, without margins: 1 for a vertex that
        becomes off-grid, the factor from its couplings to off-grid vertices to weights, 1 minus the sum of its weights,
        and its ties that remain after interpolation. The compiled loop leaves these at 0 in blocks without off-grid
        vertices.
    rows, cols, first, last : int
    """
    *linked, out = inputs
    coarse = (rows + 1) // 2, (cols + 1) // 2
    top, bottom = max(2 * (first - HALO), 0), min(2 * (last + HALO), rows)
    here = slice(cols + 1 + top * cols, cols + 1 + bottom * cols)
    grids = {name: values[here] for name, values in zip((*DIRECTIONS, "tie"), linked, strict=True)}
    grids["out"] = out[top * cols : bottom * cols] if out.size else np.zeros((bottom - top) * cols, grids["tie"].dtype)
    split = _sorted({name: values.reshape(-1, cols) for name, values in grids.items()}, top, coarse, first, last)
    _write(split, results[:13], first, last)
    for name, into in zip(BACK, results[13:], strict=True):
        level = into.reshape(rows, cols)
        for kind, down, across in KINDS:
            if f"{name}_{kind}" in split.arrays:
                where = level[2 * first + down : 2 * last : 2, across::2]
                values = split(f"{name}_{kind}").reshape(-1, split.cols)
                where[:] = values[: where.shape[0], : where.shape[1]]
    return 0.0


def _sorted(grids: Mapping[str, Values], top: int, coarse: tuple[int, int], first: int, last: int) -> Split:
    arrays = {}
    for name, values in grids.items():
        for kind, part in sorted_rows(values, top, coarse, first, last).items():
            arrays[f"{name}_{kind}"] = part
    return Split(arrays, coarse[1], last - first)


def _write(split: Split, results: tuple[Values, ...], first: int, last: int) -> None:
    """Write weights, couplings and ties; leaves the current rows of ``split`` at the band."""
    interpolate(split)
    couplings = coarse_couplings(split)
    ties = coarse_ties(split)
    found = [*(split(name) for name in WEIGHTS), *(couplings[name] for name in DIRECTIONS), ties]
    rows = slice(split.cols + 1 + first * split.cols, split.cols + 1 + last * split.cols)
    for values, into in zip(found, results, strict=True):
        into[rows] = values
