"""The global step: stitch the separately shaped faces to a mesh, in the least-squares sense."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from scipy import sparse

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.errors import ConvergenceError
from nmaptool.solver.amg_hierarchy import hierarchy_of
from nmaptool.types.mesh import Faces

# up to this many unknowns, a sparse LU is set up as fast as a hierarchy
_DIRECT = 20_000
_MOST_CYCLES = 200
Solve = Callable[[Float64], Float64]


class Stitch(Protocol):
    """A global step that is set up once."""

    def move(self, pull: Float64, moved: Float64) -> Float64:
        """Return the moves of the vertices, (N, 3) float64.

        Parameters
        ----------
        pull : (3, M, 3) float64
            Target minus current position of each corner, both relative to the mean of the face.
        moved : (N, 3) float64
            Current minus original positions of the vertices.
        """
        ...


class Average:
    """Moves each vertex to the mean of its projections: Eq. 3 of the paper, solved vertex by vertex.

    Parameters
    ----------
    faces : (M, 3) int32
    held : (N,) bool
        Vertices that do not move.
    """

    def __init__(self, faces: Faces, held: Mask) -> None:
        self._gather = _gathering(faces, len(held))
        corners = np.bincount(faces.ravel(), minlength=len(held))
        self._share = np.where(held, 0, 1 / np.maximum(corners, 1))[:, None]

    def move(self, pull: Float64, moved: Float64) -> Float64:
        """See `Stitch.move`; ``moved`` is not used."""
        return np.asarray(self._share * (self._gather @ pull.reshape(-1, 3)))


class ShapeStitch:
    """Minimises over x: sum over faces |x - p|^2 in the face's measure + sum over vertices closeness |x - x0|^2.

    The measure weights all corners equally, R = I - 1/3, or integrates the squared difference of the gradients over the
    face. With the latter and gradients for p, this is Poisson's (G^T M G + closeness) x = G^T M g + closeness x0.

    One factorisation is used for all steps and all three coordinates. For a large mesh, it is one multigrid hierarchy:
    either cycles down to a residual, or a single cycle, which is symmetric, positive and close to the inverse, so the
    steps converge to the same result.

    Parameters
    ----------
    faces : (M, 3) int32
    stiffness : (M, 3, 3) float64 or None
        The measure of each face, such as `gradient_stiffness`; None is R.
    closeness : (N,) float64
        Greater than zero.
    held : (N,) bool
        Vertices that do not move.
    residual : float or None
        Relative residual of each solve; None means one cycle.
    """

    def __init__(
        self, faces: Faces, stiffness: Float64 | None, closeness: Float64, held: Mask, residual: float | None = None
    ) -> None:
        self._closeness = closeness
        # multiplying by R would change nothing, since the mean of the pull is 0
        self._gather = _gathering(faces, len(held)) if stiffness is None else _weighing(faces, stiffness, len(held))
        self._free = np.flatnonzero(~held)
        even = np.broadcast_to(np.eye(3) - 1 / 3, (len(faces), 3, 3))
        matrix = assembled(faces, even if stiffness is None else stiffness, closeness)[self._free][:, self._free]
        self._solve = direct(matrix) if matrix.shape[0] <= _DIRECT else _by_hierarchy(matrix, residual)

    def move(self, pull: Float64, moved: Float64) -> Float64:
        """See `Stitch.move`."""
        load = self._gather @ pull.reshape(-1, 3) - self._closeness[:, None] * moved
        out = np.zeros_like(moved)
        out[self._free] = self._solve(load[self._free])
        return out


def gradient_stiffness(shapes: Float64) -> Float64:
    """Return (M, 3, 3) float64: integrals over each face of products of its corners' gradients (half cotangents)."""
    edge = [shapes[(k + 2) % 3] - shapes[(k + 1) % 3] for k in range(3)]
    dots = np.stack([np.einsum("fi,fi->f", a, b) for a in edge for b in edge], axis=1).reshape(-1, 3, 3)
    # Gram's determinant is the square of twice the area
    twice = np.sqrt(np.maximum(dots[:, 0, 0] * dots[:, 1, 1] - dots[:, 0, 1] ** 2, 0))
    least = 1e-10 * np.einsum("fii->f", dots)
    return np.asarray(dots / (2 * np.maximum(twice, least))[:, None, None])


def assembled(faces: Faces, stiffness: Float64, diagonal: Float64) -> sparse.csr_matrix:
    """Return the (N, N) sum of the (M, 3, 3) face matrices and a diagonal (N,)."""
    count = len(diagonal)
    rows, columns = np.repeat(faces, 3, axis=1).ravel(), np.tile(faces, (1, 3)).ravel()
    summed = sparse.csr_matrix((stiffness.ravel(), (rows, columns)), shape=(count, count))
    return (summed + sparse.diags(diagonal)).tocsr()


def direct(matrix: sparse.csr_matrix) -> Solve:
    """Return the inverse of a symmetric positive matrix, by a sparse LU."""
    if not matrix.shape[0]:
        return lambda load: load
    from scipy.sparse.linalg import splu

    solve: Solve = splu(
        matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    ).solve
    return solve


def _gathering(faces: Faces, count: int) -> sparse.csr_matrix:
    """Return the (N, 3 M) matrix that sums over the corners at each vertex; all first corners come first."""
    corners = np.arange(faces.size)
    return sparse.csr_matrix((np.ones(faces.size), (faces.T.ravel(), corners)), shape=(count, faces.size))


def _weighing(faces: Faces, stiffness: Float64, count: int) -> sparse.csr_matrix:
    """Return the (N, 3 M) matrix that multiplies the corners of each face by its matrix, then sums as `_gathering`."""
    rows, columns = np.repeat(faces, 3, axis=1), np.arange(faces.size).reshape(3, -1).T
    entries = (stiffness.ravel(), (rows.ravel(), np.tile(columns, (1, 3)).ravel()))
    return sparse.csr_matrix(entries, shape=(count, faces.size))


def _by_hierarchy(matrix: sparse.csr_matrix, residual: float | None) -> Solve:
    cycle = hierarchy_of(matrix).aspreconditioner(cycle="V")

    def solve(load: Float64) -> Float64:
        columns = [np.ascontiguousarray(column) for column in load.T]
        return np.column_stack(
            [cycle @ b if residual is None else _solved(matrix, cycle, b, residual) for b in columns]
        )

    return solve


def _solved(matrix: sparse.csr_matrix, cycle: Any, load: Float64, residual: float) -> Float64:
    from pyamg import krylov

    size = float(np.linalg.norm(load))
    if size == 0:
        return np.zeros_like(load)
    # hides pyamg's warnings about small curvature: the residual decides
    with warnings.catch_warnings(record=True):
        x, _ = krylov.cg(matrix, load, tol=residual / 2, maxiter=_MOST_CYCLES, M=cycle)
    left = float(np.linalg.norm(load - matrix @ x)) / size
    if not left <= 10 * residual:
        raise ConvergenceError(
            f"`scheme='poisson'`: the residual is {left:.1e} after {_MOST_CYCLES} iterations, but {residual:.0e} is "
            "needed; the faces may be too thin: use `scheme='gsfg-gradient'` or a larger `closeness`",
            (left,),
        )
    return np.asarray(x)
