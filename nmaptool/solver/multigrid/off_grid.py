"""Off-grid vertices: no coarse vertex represents them; they stay separate unknowns down to the coarsest level."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import DTypeLike

import nmaptool.solver.multigrid.rows as sparse
from nmaptool.kernels.grid_twins import Values
from nmaptool.solver.multigrid.rows import Places, Rows


@dataclass(eq=False)
class OffGrid:
    """The off-grid vertices of a level and their couplings.

    Attributes
    ----------
    count : int
    near : (n,) int64
        Flat indices of the grid vertices that off-grid vertices are coupled to, ascending.
    to_grid : Rows
        (n, count).
    among : Rows
        (count, count), symmetric, without a diagonal.
    tie : (count,)
        Coupling to fixed heights.
    """

    count: int
    near: Places
    to_grid: Rows
    among: Rows
    tie: Values

    def __post_init__(self) -> None:
        self.from_grid = self.to_grid.transposed()
        self.total = self.from_grid.sums() + self.among.sums()
        self.diagonal = self.total + self.tie
        self.inverse = np.divide(1, self.diagonal, out=np.zeros(self.count, self.tie.dtype), where=self.diagonal > 0)

    def sums_at_grid(self) -> Values:
        """Return the (n,) sums of the couplings of the grid vertices ``near`` to off-grid vertices."""
        return self.to_grid.sums()


def none(dtype: DTypeLike) -> OffGrid:
    """Return an empty set of off-grid vertices."""
    empty = sparse.none(0, 0, dtype)
    return OffGrid(0, np.zeros(0, np.int64), empty, empty, np.zeros(0, dtype))


def _numbered(size: int, *places: Places) -> tuple[Places, Places]:
    """Return all places, ascending and each once, and the (size,) number of each; -1 elsewhere."""
    here = np.zeros(size, bool)
    for some in places:
        here[some] = True
    found = np.flatnonzero(here)
    number = np.full(size, -1, np.int64)
    number[found] = np.arange(len(found))
    return found, number


# the eight neighbours: step down, step across, direction of the coupling, whether it is stored at this vertex
_AROUND = (
    (0, 1, "e", True),
    (0, -1, "e", False),
    (1, 0, "s", True),
    (-1, 0, "s", False),
    (1, 1, "se", True),
    (-1, -1, "se", False),
    (1, -1, "sw", True),
    (-1, 1, "sw", False),
)


def links(couplings: dict[str, Values], shape: tuple[int, int], places: Places) -> tuple[Places, Places, Values]:
    """Return positions in ``places``, flat indices of their grid neighbours, and the couplings, without zeros."""
    cols, edge = shape[1], shape[1] + 1
    whose, where, how = [], [], []
    for down, across, direction, holds in _AROUND:
        step = down * cols + across
        values = couplings[direction][edge + places + (0 if holds else step)]
        found = np.flatnonzero(values)
        whose.append(found)
        where.append(places[found] + step)
        how.append(values[found])
    return np.concatenate(whose), np.concatenate(where), np.concatenate(how)


# the coarse vertices that each kind interpolates from: the weight's name, and the offset from the own coarse vertex
_FROM = {
    0: (),
    1: (("b_w", 0, 0), ("b_e", 0, 1)),
    2: (("u_n", 0, 0), ("u_s", 1, 0)),
    3: (("d_nw", 0, 0), ("d_ne", 0, 1), ("d_sw", 1, 0), ("d_se", 1, 1)),
}


def grid_weights(weights: dict[str, Values], shape: tuple[int, int], places: Places) -> Rows:
    """Return the interpolation between the grids to the vertices at ``places`` of the finer grid, transposed."""
    cols, coarse_rows, coarse_cols = shape[1], (shape[0] + 1) // 2, (shape[1] + 1) // 2
    down, across = np.divmod(places, cols)
    own = (down // 2) * coarse_cols + across // 2
    kind = 2 * (down % 2) + across % 2
    on = np.flatnonzero(kind == 0)
    rows, columns, values = [own[on]], [on], [np.ones(len(on), weights["b_w"].dtype)]
    for number, parts in _FROM.items():
        mine = np.flatnonzero(kind == number)
        for name, step_down, step_across in parts:
            value = weights[name][coarse_cols + 1 + own[mine]]
            found = np.flatnonzero(value)
            rows.append(own[mine[found]] + step_down * coarse_cols + step_across)
            columns.append(mine[found])
            values.append(value[found])
    return sparse.from_entries(
        np.concatenate(rows), np.concatenate(columns), np.concatenate(values), (coarse_rows * coarse_cols, len(places))
    )


@dataclass(eq=False)
class OffGridTransfer:
    """Interpolation from the off-grid vertices of the next level to this level.

    Attributes
    ----------
    kept : int
        Number of off-grid vertices of this level; on the next level they come first.
    rows : (n,) int64
        Flat indices of the grid vertices that interpolate from off-grid vertices, including those that become off-grid;
        ascending.
    weights : Rows
        (n, off-grid vertices of the next level).
    """

    kept: int
    rows: Places
    weights: Rows

    def __post_init__(self) -> None:
        self.back = self.weights.transposed()


def transfer(
    off_grid: OffGrid,
    couplings: dict[str, Values],
    shape: tuple[int, int],
    became: Places,
    scale: Values,
) -> OffGridTransfer:
    """Return the interpolation of grid vertices from off-grid vertices.

    Parameters
    ----------
    off_grid : OffGrid
        Off-grid vertices of this level.
    couplings : mapping of str to flat arrays with margins
    shape : (int, int)
        Shape of this level.
    became : (m,) int64
        Flat indices of the vertices that become off-grid, ascending.
    scale : (rows * cols)
        Factor from off-grid couplings to weights; 0 for coarse vertices and new off-grid ones.
    """
    kept, added = off_grid.count, len(became)
    old = off_grid.to_grid
    rows, columns, values = [off_grid.near[old.row]], [old.column], [old.value]
    whose, where, how = links(couplings, shape, became)
    # only diagonal vertices interpolate from other kinds: from those beside and under, which are settled before them
    diagonal = (where // shape[1] % 2 == 1) & (where % shape[1] % 2 == 1)
    between = ~((became // shape[1] % 2 == 1) & (became % shape[1] % 2 == 1))
    seen = diagonal & between[whose]
    seen &= (where // shape[1] == became[whose] // shape[1]) | (where % shape[1] == became[whose] % shape[1])
    rows.append(where[seen])
    columns.append(kept + whose[seen])
    values.append(how[seen])
    row, column = np.concatenate(rows), np.concatenate(columns)
    value = np.concatenate(values) * scale[row]
    found = np.flatnonzero(value)
    row = np.concatenate([row[found], became])
    column = np.concatenate([column[found], kept + np.arange(added)])
    value = np.concatenate([value[found], np.ones(added, scale.dtype)])
    places, number = _numbered(shape[0] * shape[1], row)
    weights = sparse.from_entries(number[row], column, value, (len(places), kept + added))
    return OffGridTransfer(kept, places, weights)


def coarse_off_grid(
    off_grid: OffGrid,
    moved: OffGridTransfer,
    couplings: dict[str, Values],
    shape: tuple[int, int],
    grid: dict[str, Values],
    total: Values,
    rest: Values,
    lack: Values,
) -> OffGrid:
    """Return the off-grid vertices of the next level with the couplings P^T A P.

    Parameters
    ----------
    off_grid, moved, couplings, shape
        As in `transfer`.
    grid : mapping of str to flat arrays with margins
        Weights of the interpolation between the grids.
    total : (rows * cols)
        Sum of the couplings of each vertex.
    rest, lack : (rows * cols)
        Ties that remain after interpolation, and 1 minus the sum of its weights; see `galerkin.coarse_ties`.
    """
    kept, count, moving = moved.kept, moved.weights.count, len(moved.rows)
    whose, where, how = links(couplings, shape, moved.rows)
    near = off_grid.near
    places, number = _numbered(shape[0] * shape[1], where, moved.rows, near)
    ones = np.ones(len(near), total.dtype)
    # (A P) at the grid vertices
    on_grid = sparse.from_entries(
        number[np.concatenate([where, moved.rows, near])],
        np.concatenate([whose, np.arange(moving + len(near))]),
        np.concatenate([how, -total[moved.rows], ones]),
        (len(places), moving + len(near)),
    ).product(sparse.below_each_other([moved.weights, off_grid.to_grid], count))
    coarse = grid_weights(grid, shape, places).product(on_grid)
    coarse = coarse.where(coarse.value > 0)
    among = _among(off_grid, moved, on_grid, number)
    tie = moved.back.times(rest[moved.rows])
    tie[:kept] += off_grid.tie + off_grid.from_grid.times(lack[near])
    has_any = np.diff(coarse.start) > 0
    to_grid = Rows(np.append(coarse.start[:-1][has_any], coarse.start[-1]), coarse.column, coarse.value, count)
    return OffGrid(count, np.flatnonzero(has_any), to_grid, among, np.maximum(tie, 0))


def _among(off_grid: OffGrid, moved: OffGridTransfer, on_grid: Rows, number: Places) -> Rows:
    """Return the couplings among the off-grid vertices of the next level.

    ``number`` gives the row of ``on_grid``, which is (A P), for the vertices of the grid.
    """
    back, among, from_grid, count = moved.back, off_grid.among, off_grid.from_grid, moved.weights.count
    _, moving = _numbered(len(number), moved.rows)
    near = moving[off_grid.near[from_grid.column]]
    found = near >= 0
    product = sparse.from_entries(
        np.concatenate([back.row, from_grid.row[found], among.row]),
        np.concatenate(
            [
                number[moved.rows[back.column]],
                len(on_grid) + near[found],
                len(on_grid) + len(moved.rows) + among.column,
            ]
        ),
        np.concatenate([back.value, from_grid.value[found], among.value]),
        (count, len(on_grid) + len(moved.rows) + count),
    ).product(sparse.below_each_other([on_grid, moved.weights, sparse.identity(count, back.value.dtype)], count))
    return product.where((product.row != product.column) & (product.value > 0))
