"""The operator and the energy, defined once.

A picture of H x W pixels is a grid of H x W square faces and (H+1) x (W+1) vertices with unit edges; the heights z are
those of the vertices. With R = I - 1/4, and with the weight k_f and the target corner heights h_f (of mean 0) of each
face f, the energy

    E(z) = sum_f k_f |R z_f - h_f|^2 + sum_v beta_v (z_v - delta_v)^2            (Wei et al. 2018, Eq. 6 to 8)

is minimal where (L + diag(beta)) z = g + beta delta. Here (L z)_v is the sum over the faces f at v of
k_f (z_v - mean of z on f), and g_v the sum of k_f h_f over the corners at v.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.errors import InputError
from nmaptool.core.grid import corner_mean, touching_vertices
from nmaptool.core.parallel import for_each_band
from nmaptool.solver.operator import Operator, Weights, rows_at_once

# called with a band of rows and its (rows * (W+1),) float64 values
See = Callable[[slice, Float64], None]

_MOST_SPAN = 1e3


def slope_load(p: Float64, q: Float64) -> Float64:
    """Return the (H+1, W+1) load g of the target corner heights h = -+p/2 -+q/2 (y up, row 0 at the top).

    Parameters
    ----------
    p, q : (H, W) float64
        Target slopes, each multiplied by the weight of its face.
    """
    rows, cols = p.shape
    rising, falling = (p + q) / 2, (p - q) / 2
    load = np.zeros((rows + 1, cols + 1))
    load[:-1, :-1] -= falling
    load[:-1, 1:] += rising
    load[1:, :-1] -= rising
    load[1:, 1:] += falling
    return load


def energy(z: Float64, weight: Float64, p: Float64, q: Float64) -> float:
    """Return the shape energy sum_f w_f |R(z_f - h_f)|^2 of heights z for target slopes p, q, by its definition.

    Parameters
    ----------
    z : (H+1, W+1) float64
    weight, p, q : (H, W) float64
    """
    mean = corner_mean(z)
    corners = (
        (z[:-1, :-1], -p / 2 + q / 2),
        (z[:-1, 1:], p / 2 + q / 2),
        (z[1:, :-1], -p / 2 - q / 2),
        (z[1:, 1:], p / 2 - q / 2),
    )
    return float(sum((weight * (corner - mean - target) ** 2).sum() for corner, target in corners))


@dataclass(frozen=True, eq=False)
class QuadSystem:
    """The linear system (L + diag(beta)) z = load, where some vertices may be held.

    Parameters
    ----------
    weight : (H, W) float32 or float64
        k_f >= 0 per face; 0 outside the domain. Not copied.
    beta : (H+1, W+1) float32 or float64
        Height weight per vertex, >= 0. Not copied.
    held : (H+1, W+1) bool
        Vertices whose height is prescribed.

    Raises
    ------
    InputError
        If shapes do not match, a weight is negative or not finite, or the weights of all faces are zero.
    """

    weight: Weights
    beta: Weights
    held: Mask

    def __post_init__(self) -> None:
        rows, cols = self.weight.shape
        if self.beta.shape != (rows + 1, cols + 1) or self.held.shape != self.beta.shape:
            raise InputError(
                f"face weights of shape {self.weight.shape} need height weights and held vertices of shape "
                f"{(rows + 1, cols + 1)}; found {self.beta.shape} and {self.held.shape}"
            )
        for name in ("weight", "beta"):  # bands are flat slices of them
            values = getattr(self, name)
            if values.dtype not in (np.float32, np.float64) or not values.flags.c_contiguous:
                kept = values.dtype if values.dtype == np.float32 else np.float64
                object.__setattr__(self, name, np.ascontiguousarray(values, kept))
        object.__setattr__(self, "held", np.ascontiguousarray(self.held, bool))
        for name, (least, most) in (("face", self.weight_range), ("height", extremes(self.beta))):
            if not (least >= 0 and most < np.inf):
                raise InputError(f"{name} weights must be finite and zero or more")
        if self.weight_range[1] == 0:
            raise InputError("every face has weight zero: there is nothing to solve")

    @functools.cached_property
    def weight_range(self) -> tuple[float, float]:
        """Smallest and largest weight of a face."""
        return extremes(self.weight)

    @functools.cached_property
    def has_wide_weights(self) -> bool:
        """Whether the weights of the faces differ so much that a preconditioner in float32 is not accurate enough."""
        least, most = self.weight_range
        if least == 0:
            least = float(np.min(self.weight, where=self.weight > 0, initial=most))
        return most > _MOST_SPAN * least

    @functools.cached_property
    def operator(self) -> Operator:
        """Computes A z in bands."""
        return Operator(self.weight, self.beta)

    def apply(self, z: Float64) -> Float64:
        """Return (L + diag(beta)) z as (H+1, W+1) float64, without building a matrix."""
        out = np.empty(self.beta.shape)

        def keep(band: slice, product: Float64, _: Float64) -> None:
            out[band].reshape(-1)[:] = product

        self.operator.each(np.ascontiguousarray(z, np.float64), keep)
        return out

    def residual(
        self,
        load: Float64,
        z: Float64 | None,
        out: NDArray[Any] | None,
        *,
        less: See | None = None,
        see: See | None = None,
    ) -> float:
        """Write load - A z to ``out`` at unknown vertices and 0 elsewhere; computed in float64.

        Parameters
        ----------
        load, z : (H+1, W+1) float64, C order
            z None means 0 everywhere.
        out : (H+1, W+1) float32 or float64, C order, or None
            None: compute only the norm.
        less : callable, optional
            Called with every band and its load - A z; subtracts in place what does not count.
        see : callable, optional
            Called with every band and its residual.

        Returns
        -------
        float
            Euclidean norm of the residual.
        """
        squares = np.zeros(self.beta.shape[0])

        def finish(band: slice, product: Float64, other: Float64) -> None:
            left = np.subtract(load[band].reshape(-1), product, out=product)
            if less is not None:
                less(band, left)
            left *= self.unknown[band].reshape(-1)
            squares[band.start] = np.multiply(left, left, out=other).sum()  # not BLAS: it would start its own threads
            if see is not None:
                see(band, left)
            if out is not None:
                out[band].reshape(-1)[:] = left

        self.operator.each(z, finish, self.unknown)
        return float(np.sqrt(squares.sum()))

    @functools.cached_property
    def unknown(self) -> Mask:
        """(H+1, W+1) bool: unknown vertices."""
        if self.weight_range[0] > 0:
            return ~self.held
        out = touching_vertices(self.weight > 0)

        def free(band: slice) -> None:
            out[band] |= self.beta[band] > 0
            out[band] &= ~self.held[band]

        for_each_band(len(out), rows_at_once(out.shape[1]), free)
        return out

    def faces(self) -> tuple[NDArray[np.int32] | Mask, int]:
        """Return the (H, W) label of the island of each face (0: none) and the number of islands.

        Faces that share a vertex belong to the same island. If there is only one island, the labels are a mask.
        """
        if self.weight_range[0] > 0:
            return np.broadcast_to(np.True_, self.weight.shape), 1
        import cv2

        acting = self.weight > 0
        found, labels = cv2.connectedComponents(acting.view(np.uint8), connectivity=8, ltype=cv2.CV_32S)
        return (acting, 1) if found == 2 else (labels, found - 1)

    def islands(self) -> tuple[NDArray[np.int32], int]:
        """Return the (H+1, W+1) label of the island of each vertex (0: none) and the number of islands."""
        faces, count = self.faces()
        labels = np.zeros(self.beta.shape, np.int32)
        for corner in (labels[:-1, :-1], labels[:-1, 1:], labels[1:, :-1], labels[1:, 1:]):
            np.maximum(corner, faces, out=corner)
        return labels, count

    @functools.cached_property
    def is_uniform(self) -> bool:
        """Whether it is a full rectangle with one weight, one beta and nothing held, as the DCT needs."""
        if self.weight_range[0] != self.weight_range[1] or self.held.any():
            return False
        inner = self.beta[1:-1, 1:-1]
        beta = float(inner.flat[0] if inner.size else self.beta.flat[0] * 4)
        slack = (1e-6 if self.beta.dtype == np.float32 else 1e-12) * beta
        sides = (self.beta[0, 1:-1], self.beta[-1, 1:-1], self.beta[1:-1, 0], self.beta[1:-1, -1])
        corners = self.beta[[0, 0, -1, -1], [0, -1, 0, -1]]
        parts = ((inner, 1.0), (corners, 0.25), *((side, 0.5) for side in sides))
        return all(
            abs(extreme - share * beta) <= share * slack
            for part, share in parts
            if part.size
            for extreme in extremes(np.atleast_2d(part))
        )


def extremes(values: NDArray[Any]) -> tuple[float, float]:
    """Return the smallest and largest value of a 2-D array; NaN if it contains one."""
    found = np.empty((len(values), 2))
    step = rows_at_once(values.shape[1])

    def look(band: slice) -> None:
        found[band.start] = values[band].min(), values[band].max()

    for_each_band(len(values), step, look)
    return float(found[::step, 0].min()), float(found[::step, 1].max())


def vertex_share(shape: tuple[int, int]) -> Float64:
    """Return the (H+1, W+1) share of four faces that each vertex has: 1 inside, 1/2 on edges, 1/4 at corners."""
    down, across = np.ones(shape[0] + 1), np.ones(shape[1] + 1)
    down[[0, -1]] = across[[0, -1]] = 0.5
    return down[:, None] * across
