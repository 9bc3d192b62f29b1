"""The pyamg hierarchy, with the settings that the relief solvers and the mesh reconstruction share."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from scipy import sparse

_COARSEST = 500


def hierarchy_of(matrix: sparse.csr_matrix) -> Any:
    """Return pyamg's Ruge-Stueben hierarchy of a matrix."""
    import pyamg

    # the second pass of coarsening nearly halves the iterations on ragged masks
    return pyamg.ruge_stuben_solver(
        matrix, CF=("RS", {"second_pass": True}), max_coarse=_COARSEST, coarse_solver="splu"
    )
