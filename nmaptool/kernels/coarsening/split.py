"""A band of a level, sorted by the position of its vertices relative to the next coarser grid.

Vertex (2i, 2j) of a level is vertex (i, j) of the coarser one. Three others belong to it: the one beside it
(2i, 2j+1), the one below (2i+1, 2j) and the diagonal one (2i+1, 2j+1). Their kinds are called o for the vertex itself,
b beside, u under, d diagonal. Each kind is stored in an array with the layout of the coarse grid, so every neighbour is
at a constant offset in flat memory.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import DTypeLike

from nmaptool.kernels.grid_twins import Values

# each kind and its offset in the level, rows down and columns across, from the coarse vertex
KINDS = (("o", 0, 0), ("b", 0, 1), ("u", 1, 0), ("d", 1, 1))
# rows above and below the band that the computation of its own rows reads
HALO = 2
# couplings by direction: east, south, south-east, south-west
DIRECTIONS = ("e", "s", "se", "sw")


def sorted_rows(fine: Values, top: int, coarse_shape: tuple[int, int], first: int, last: int) -> dict[str, Values]:
    """Return rows ``first - HALO`` to ``last + HALO`` of each kind in the coarse layout, flat; 0 outside the grid.

    Parameters
    ----------
    fine : (n, cols)
        Values at a level's vertices, from its row ``top`` on.
    top : int
    coarse_shape : (int, int)
        Shape of the coarser grid: half of rows and columns, rounded up.
    first, last : int
        The band in rows of the coarser grid.
    """
    rows, cols = coarse_shape
    out = {}
    begin, end = max(first - HALO, 0), min(last + HALO, rows)
    skip = begin - (first - HALO)
    for kind, down, across in KINDS:
        part = fine[2 * begin + down - top : 2 * end - top : 2, across::2]
        values = _zeros(last - first, cols, fine.dtype)
        values[1:-1].reshape(-1, cols)[skip : skip + part.shape[0], : part.shape[1]] = part
        out[kind] = values
    return out


def _zeros(rows: int, cols: int, dtype: DTypeLike) -> Values:
    """Return zeros for a band of coarse rows with their halo, and one more element at both ends for steps across."""
    return np.zeros((rows + 2 * HALO) * cols + 2, dtype)


class Split:
    """Couplings of a band by kind and direction, and other values at its vertices.

    ``split(name, down, across)`` is a view of an array over the current rows, shifted by that many coarse rows down and
    columns across. Names of couplings are direction and kind, such as "se_o".

    Parameters
    ----------
    arrays : mapping of str to flat arrays
        Arrays as returned by `sorted_rows`.
    cols : int
        Columns of the coarse grid.
    rows : int
        Rows of the band.
    """

    def __init__(self, arrays: dict[str, Values], cols: int, rows: int) -> None:
        self.arrays, self.cols, self.rows = arrays, cols, rows
        self.dtype = arrays["e_o"].dtype
        self.reach(0)

    def reach(self, margin: int) -> None:
        """Set the current rows to the band and ``margin`` rows above and below it."""
        self._start = 1 + (HALO - margin) * self.cols
        self._stop = 1 + (HALO + self.rows + margin) * self.cols

    def __call__(self, name: str, down: int = 0, across: int = 0) -> Values:
        """Return a view of an array."""
        step = down * self.cols + across
        return self.arrays[name][self._start + step : self._stop + step]

    def keep(self, name: str) -> Values:
        """Add an array of zeros under a name; return its current rows."""
        self.arrays[name] = _zeros(self.rows, self.cols, self.dtype)
        return self(name)


# the eight neighbours of each kind as (kind, down, across, coupling, down, across); a coupling is stored at one end
Link = tuple[str, int, int, str, int, int]
LINKS: dict[str, tuple[Link, ...]] = {
    "o": (
        ("b", 0, 0, "e_o", 0, 0),
        ("b", 0, -1, "e_b", 0, -1),
        ("u", 0, 0, "s_o", 0, 0),
        ("u", -1, 0, "s_u", -1, 0),
        ("d", 0, 0, "se_o", 0, 0),
        ("d", 0, -1, "sw_o", 0, 0),
        ("d", -1, -1, "se_d", -1, -1),
        ("d", -1, 0, "sw_d", -1, 0),
    ),
    "b": (
        ("o", 0, 0, "e_o", 0, 0),
        ("o", 0, 1, "e_b", 0, 0),
        ("d", 0, 0, "s_b", 0, 0),
        ("d", -1, 0, "s_d", -1, 0),
        ("u", 0, 1, "se_b", 0, 0),
        ("u", 0, 0, "sw_b", 0, 0),
        ("u", -1, 0, "se_u", -1, 0),
        ("u", -1, 1, "sw_u", -1, 1),
    ),
    "u": (
        ("o", 0, 0, "s_o", 0, 0),
        ("o", 1, 0, "s_u", 0, 0),
        ("d", 0, 0, "e_u", 0, 0),
        ("d", 0, -1, "e_d", 0, -1),
        ("b", 1, 0, "se_u", 0, 0),
        ("b", 1, -1, "sw_u", 0, 0),
        ("b", 0, -1, "se_b", 0, -1),
        ("b", 0, 0, "sw_b", 0, 0),
    ),
    "d": (
        ("b", 0, 0, "s_b", 0, 0),
        ("b", 1, 0, "s_d", 0, 0),
        ("u", 0, 0, "e_u", 0, 0),
        ("u", 0, 1, "e_d", 0, 0),
        ("o", 0, 0, "se_o", 0, 0),
        ("o", 0, 1, "sw_o", 0, 1),
        ("o", 1, 0, "sw_d", 0, 0),
        ("o", 1, 1, "se_d", 0, 0),
    ),
}
