"""A common interface to all solvers: the library's own and the ones compared with it.

Solvers that are not dependencies of the library are measured if they are installed. On Debian and Ubuntu:
``apt-get install libsuitesparse-dev`` and ``pip install "scikit-sparse<0.5"`` (0.5 needs SuiteSparse 7) for CHOLMOD,
``pip install pypardiso`` for MKL's PARDISO.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy import fft, sparse

from nmaptool.core.arrays import Float64, Mask
from nmaptool.solver import QuadSystem, prepare
from nmaptool.solver.amg import assemble
from nmaptool.solver.islands import Islands
from nmaptool.solver.system import vertex_share

OURS = ("multigrid", "dct", "amg")
Solve = Callable[[Float64, float], tuple[Float64, int]]  # from a load and a tolerance to heights and iterations
_MOST_ITERATIONS = 20_000


def ours(method: str) -> Callable[[QuadSystem], Solve]:
    """The library with one of its methods."""

    def make(system: QuadSystem) -> Solve:
        solver = prepare(system, method)

        def solve(load: Float64, tolerance: float) -> tuple[Float64, int]:
            solution = solver.solve(load, tolerance=tolerance)
            return solution.z, solution.iterations

        return solve

    return make


def _assembled(system: QuadSystem) -> tuple[sparse.csr_matrix, Mask]:
    """The matrix without held vertices and without one vertex of each free part."""
    unknown = system.unknown & ~Islands(system).anchors
    return assemble(system, unknown), unknown


def _direct(unknown: Mask, solve: Callable[[Float64], Float64]) -> Solve:
    def solved(load: Float64, tolerance: float) -> tuple[Float64, int]:
        z = np.zeros(load.shape)
        z[unknown] = solve(load[unknown])
        return z, 1

    return solved


def superlu(system: QuadSystem) -> Solve:
    """SciPy's sparse LU."""
    from scipy.sparse.linalg import splu

    matrix, unknown = _assembled(system)
    # symmetric mode uses diagonal pivots, which the matrix allows: half the time of splu's default here
    factors = splu(matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    return _direct(unknown, factors.solve)


def cholmod(system: QuadSystem) -> Solve:
    """CHOLMOD's supernodal factors by scikit-sparse; AMD's ordering was the fastest of four here."""
    from sksparse.cholmod import cholesky

    matrix, unknown = _assembled(system)
    return _direct(unknown, cholesky(matrix.tocsc(), ordering_method="amd", mode="supernodal"))


def pardiso(system: QuadSystem) -> Solve:
    """MKL's PARDISO by pypardiso, for symmetric positive definite matrices."""
    from pypardiso import PyPardisoSolver

    matrix, unknown = _assembled(system)
    solver = PyPardisoSolver(mtype=2)
    upper = sparse.triu(matrix, format="csr")
    solver.factorize(upper)
    return _direct(unknown, lambda b: solver.solve(upper, b))


def _conjugate_gradients(apply: Any, unknown: Mask, preconditioner: Any) -> Solve:
    from scipy.sparse.linalg import cg

    def solve(load: Float64, tolerance: float) -> tuple[Float64, int]:
        steps = 0

        def count(_: Float64) -> None:
            nonlocal steps
            steps += 1

        z = np.zeros(load.shape)
        z[unknown], _ = cg(
            apply, load[unknown], rtol=tolerance, maxiter=_MOST_ITERATIONS, M=preconditioner, callback=count
        )
        return z, steps

    return solve


def jacobi(system: QuadSystem) -> Solve:
    """SciPy's conjugate gradients with the diagonal as preconditioner."""
    matrix, unknown = _assembled(system)
    return _conjugate_gradients(matrix, unknown, sparse.diags(1 / matrix.diagonal()))


def smoothed_aggregation(system: QuadSystem) -> Solve:
    """Conjugate gradients with pyamg's aggregation hierarchy as preconditioner."""
    import pyamg

    matrix, unknown = _assembled(system)
    np.random.seed(0)  # noqa: NPY002 - pyamg draws its start vectors from there
    hierarchy = pyamg.smoothed_aggregation_solver(matrix, max_coarse=500, coarse_solver="splu")

    def solve(load: Float64, tolerance: float) -> tuple[Float64, int]:
        z, left = np.zeros(load.shape), []
        with warnings.catch_warnings(record=True):
            z[unknown] = hierarchy.solve(load[unknown], tol=tolerance, maxiter=200, accel="cg", residuals=left)
        return z, len(left) - 1

    return solve


def dct_preconditioned(system: QuadSystem) -> Solve:
    """Conjugate gradients on the library's operator, preconditioned by a cosine transform with mean weights."""
    from scipy.sparse.linalg import LinearOperator

    rows, cols = system.weight.shape
    unknown = system.unknown & ~Islands(system).anchors
    k = float(system.weight[system.weight > 0].mean())
    beta = float(system.beta[unknown].mean())
    fall_x = 2 * np.sin(np.pi * np.arange(cols + 1) / (2 * cols)) ** 2
    fall_y = (2 * np.sin(np.pi * np.arange(rows + 1) / (2 * rows)) ** 2)[:, None]
    eigenvalues = k * ((2 - fall_x) * fall_y + fall_x * (2 - fall_y) + fall_x * fall_y) + beta
    eigenvalues[0, 0] = max(eigenvalues[0, 0], eigenvalues[0, 1])
    count = int(unknown.sum())
    spread, share = np.zeros(unknown.shape), vertex_share((rows, cols))

    def apply(values: Float64) -> Float64:
        spread[unknown] = values
        return system.apply(spread)[unknown]

    def precondition(values: Float64) -> Float64:
        spread[unknown] = values
        spectrum = fft.dctn(spread / share, type=1, workers=-1, overwrite_x=True)
        spectrum /= eigenvalues
        return fft.idctn(spectrum, type=1, workers=-1, overwrite_x=True)[unknown]

    shape = (count, count)
    return _conjugate_gradients(
        LinearOperator(shape, matvec=apply), unknown, LinearOperator(shape, matvec=precondition)
    )


SOLVERS: dict[str, Callable[[QuadSystem], Solve]] = {
    **{name: ours(name) for name in OURS},
    "dct + CG": dct_preconditioned,
    "aggregation": smoothed_aggregation,
    "cholmod": cholmod,
    "pardiso": pardiso,
    "superlu": superlu,
    "Jacobi-CG": jacobi,
}


def maker(name: str) -> Callable[[QuadSystem], Solve]:
    """One of `SOLVERS`, or "auto", the library's own choice."""
    return ours("auto") if name == "auto" else SOLVERS[name]
