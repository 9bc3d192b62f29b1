"""Couplings and ties of the finest level, from the weights of faces."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nmaptool.kernels.grid_twins import Values


def finest_couplings(
    quarter: Values, beta: Values, unknown: NDArray[np.bool_] | None, shape: tuple[int, int], top: int, bottom: int
) -> dict[str, Values]:
    """Return the couplings "e", "s", "se" and "sw" and the "tie" of rows ``top`` to ``bottom``, each (rows, cols).

    Parameters
    ----------
    quarter : flat with margins
        A quarter of the weight of each face, at its upper left vertex.
    beta : flat
    unknown : flat bool, optional
        Couplings to other vertices are ties. None: all are unknown.
    shape : (int, int)
    top, bottom : int
    """
    cols = shape[1]
    start, stop = top * cols, bottom * cols
    count = stop - start
    around = quarter[start : stop + 2 * (cols + 1)]  # with a margin
    here, beside = around[cols + 1 : cols + 1 + count], around[cols : cols + count]
    full = {"e": here + around[1 : 1 + count], "s": here + beside, "se": here, "sw": beside}
    grids = {name: values.reshape(-1, cols) for name, values in full.items()}
    tie = np.array(beta[start:stop], quarter.dtype).reshape(-1, cols)
    if unknown is None:
        return {**grids, "tie": tie}
    return {**_unknown_only(grids, tie, unknown.reshape(shape), top, bottom), "tie": tie}


def _unknown_only(
    full: dict[str, Values], ties: Values, unknown: NDArray[np.bool_], top: int, bottom: int
) -> dict[str, Values]:
    """Return the couplings between unknown vertices; those to held vertices are added to ``ties``."""
    rows, cols = unknown.shape
    padded = np.zeros((bottom - top + 2, cols + 2), ties.dtype)
    above, below = max(top - 1, 0), min(bottom + 1, rows)
    padded[above - top + 1 : below - top + 1, 1:-1] = unknown[above:below]
    own = padded[1:-1, 1:-1]
    out = {}
    for name, down, across in (("e", 0, 1), ("s", 1, 0), ("se", 1, 1), ("sw", 1, -1)):
        values = full[name]
        other = padded[1 + down : padded.shape[0] - 1 + down, 1 + across : padded.shape[1] - 1 + across]
        out[name] = values * own * other
        ties += values * own * (1 - other)
        # the lower end of the coupling
        lower = values * (1 - own) * other
        ties[down:, max(across, 0) : cols + min(across, 0)] += lower[
            : lower.shape[0] - down, max(-across, 0) : cols - max(across, 0)
        ]
    ties *= own
    return out
