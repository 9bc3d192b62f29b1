"""The one place for pyamg's hierarchy: engines that share nothing else share it."""

from __future__ import annotations

from typing import Any

from scipy import sparse

_COARSEST = 500


def hierarchy_of(matrix: sparse.csr_matrix) -> Any:
    """Ruge and Stueben's hierarchy of a matrix, by pyamg."""
    import pyamg

    # the second pass of coarsening nearly halves the iterations on ragged masks
    return pyamg.ruge_stuben_solver(
        matrix, CF=("RS", {"second_pass": True}), max_coarse=_COARSEST, coarse_solver="splu"
    )
