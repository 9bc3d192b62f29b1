"""Off-grid vertices: no coarse vertex represents them; they stay separate unknowns down to the coarsest level."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import DTypeLike, NDArray
from scipy import sparse

from nmaptool.solver.multigrid.values import Values

Places = NDArray[np.int64]


@dataclass(eq=False)
class OffGrid:
    """The off-grid vertices of a level and their couplings.

    Attributes
    ----------
    count : int
    near : (n,) int64
        Flat indices of the grid vertices that off-grid vertices are coupled to, ascending.
    to_grid : (n, count) CSR
    among : (count, count) CSR
        Symmetric, without a diagonal.
    tie : (count,)
        Coupling to fixed heights.
    """

    count: int
    near: Places
    to_grid: sparse.csr_matrix
    among: sparse.csr_matrix
    tie: Values

    def __post_init__(self) -> None:
        self.from_grid = self.to_grid.T.tocsr()
        self.total = np.asarray(self.from_grid.sum(axis=1) + self.among.sum(axis=1), self.tie.dtype).ravel()
        self.diagonal = self.total + self.tie
        self.inverse = np.divide(1, self.diagonal, out=np.zeros(self.count, self.tie.dtype), where=self.diagonal > 0)

    def sums_at_grid(self) -> Values:
        """Return the (n,) sums of the couplings of the grid vertices ``near`` to off-grid vertices."""
        return np.asarray(self.to_grid.sum(axis=1), self.tie.dtype).ravel()


def none(dtype: DTypeLike) -> OffGrid:
    """Return an empty set of off-grid vertices."""
    empty = sparse.csr_matrix((0, 0), dtype=dtype)
    return OffGrid(0, np.zeros(0, np.int64), empty, empty, np.zeros(0, dtype))


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


def grid_weights(weights: dict[str, Values], shape: tuple[int, int], places: Places) -> sparse.csr_matrix:
    """Return the rows of the interpolation between the grids for the vertices at ``places`` of the finer grid."""
    cols, coarse_rows, coarse_cols = shape[1], (shape[0] + 1) // 2, (shape[1] + 1) // 2
    down, across = places // cols, places % cols
    own = (down // 2) * coarse_cols + across // 2
    kind = 2 * (down % 2) + across % 2
    rows, columns, values = (
        [np.flatnonzero(kind == 0)],
        [own[kind == 0]],
        [np.ones(int((kind == 0).sum()), weights["b_w"].dtype)],
    )
    for number, parts in _FROM.items():
        mine = np.flatnonzero(kind == number)
        for name, step_down, step_across in parts:
            value = weights[name][coarse_cols + 1 + own[mine]]
            found = np.flatnonzero(value)
            rows.append(mine[found])
            columns.append(own[mine[found]] + step_down * coarse_cols + step_across)
            values.append(value[found])
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    return sparse.csr_matrix(entries, shape=(len(places), coarse_rows * coarse_cols))


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
    weights : (n, off-grid vertices of the next level) CSR
    """

    kept: int
    rows: Places
    weights: sparse.csr_matrix

    def __post_init__(self) -> None:
        self.back = self.weights.T.tocsr()


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
    old = off_grid.to_grid.tocoo()
    rows, columns, values = [off_grid.near[old.row]], [old.col], [old.data]
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
    places, position = np.unique(row, return_inverse=True)
    weights = sparse.csr_matrix((value, (position, column)), shape=(len(places), kept + added))
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
    kept, count = moved.kept, moved.weights.shape[1]
    whose, where, how = links(couplings, shape, moved.rows)
    places = np.unique(np.concatenate([where, moved.rows, off_grid.near]))
    size = len(places)

    def at(what: Places) -> Places:
        return np.searchsorted(places, what)

    pull = sparse.csr_matrix((how, (at(where), whose)), shape=(size, len(moved.rows)))
    mine = sparse.csr_matrix((-total[moved.rows], (at(moved.rows), np.arange(len(moved.rows)))), shape=pull.shape)
    near = off_grid.to_grid.tocoo()
    widened = sparse.csr_matrix((near.data, (at(off_grid.near)[near.row], near.col)), shape=(size, count))
    on_grid = (pull + mine) @ moved.weights + widened  # (A P) at the grid vertices
    coarse = (grid_weights(grid, shape, places).T @ on_grid).tocoo()
    # at the off-grid vertices
    spread = sparse.csr_matrix(
        (np.ones(len(moved.rows), total.dtype), (at(moved.rows), np.arange(len(moved.rows)))), shape=pull.shape
    )
    own = widened[:, :kept].T @ (spread @ moved.weights) + _padded(off_grid.among, kept, count)
    among = moved.back @ (spread.T @ on_grid)
    among = among + sparse.vstack([own, sparse.csr_matrix((count - kept, count), dtype=total.dtype)])
    among = among.tocoo()
    link = (among.row != among.col) & (among.data > 0)
    tie = moved.back @ rest[moved.rows]
    tie[:kept] += off_grid.tie + off_grid.from_grid @ lack[off_grid.near]
    found = coarse.data > 0
    near_places, position = np.unique(coarse.row[found], return_inverse=True)
    return OffGrid(
        count,
        near_places.astype(np.int64),
        sparse.csr_matrix((coarse.data[found], (position, coarse.col[found])), shape=(len(near_places), count)),
        sparse.csr_matrix((among.data[link], (among.row[link], among.col[link])), shape=(count, count)),
        np.maximum(tie, 0),
    )


def _padded(values: sparse.csr_matrix, rows: int, cols: int) -> sparse.csr_matrix:
    return sparse.csr_matrix((values.data, values.indices, values.indptr), shape=(rows, cols))
