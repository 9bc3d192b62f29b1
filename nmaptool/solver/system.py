"""The operator and the energy, stated once.

A picture of H x W pixels is a grid of H x W square faces and (H+1) x (W+1) vertices with unit edges; heights z live on
the vertices. Per face f with weight k_f, R = I - 1/4 and target corner heights h_f (of mean 0),

    E(z) = sum_f k_f |R z_f - h_f|^2 + sum_v beta_v (z_v - delta_v)^2            (Wei et al. 2018, Eq. 6 to 8)

is least where (L + diag(beta)) z = g + beta delta, with (L z)_v = sum over the faces f at v of
k_f (z_v - mean of z on f) and g_v the sum of k_f h_f over the corners at v.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from nmaptool.arrays import Float64, Mask
from nmaptool.errors import InputError
from nmaptool.grid import corner_mean, corner_sum

_EIGHT = np.ones((3, 3), bool)


def slope_load(p: Float64, q: Float64) -> Float64:
    """(H+1, W+1) load g of the target corner heights h = -+p/2 -+q/2 (y up, row 0 on top).

    Parameters
    ----------
    p, q : (H, W) float64
        Target slopes, each already multiplied by its face's weight.
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
    """Shape energy sum_f w_f |R(z_f - h_f)|^2 of heights z against slopes p, q; straight from its definition.

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
    """The linear system (L + diag(beta)) z = load, some vertices held.

    Parameters
    ----------
    weight : (H, W) float64
        k_f >= 0 per face; 0 outside the domain.
    beta : (H+1, W+1) float64
        Height weight per vertex, >= 0.
    held : (H+1, W+1) bool
        Vertices whose height is given.

    Raises
    ------
    InputError
        If shapes do not fit, a weight is negative or not finite, or no weight is left.
    """

    weight: Float64
    beta: Float64
    held: Mask

    def __post_init__(self) -> None:
        rows, cols = self.weight.shape
        if self.beta.shape != (rows + 1, cols + 1) or self.held.shape != self.beta.shape:
            raise InputError(
                f"weights of shape {self.weight.shape} need height weights and held vertices of shape "
                f"{(rows + 1, cols + 1)}, found {self.beta.shape} and {self.held.shape}"
            )
        for name, values in (("face", self.weight), ("height", self.beta)):
            if not (np.isfinite(values).all() and values.min() >= 0):
                raise InputError(f"{name} weights must be finite and zero or more")
        if not self.weight.any():
            raise InputError("every face has weight zero: there is nothing to solve")

    def apply(self, z: Float64) -> Float64:
        """(L + diag(beta)) z by two 2x2 box sums; no matrix is made."""
        return (self.around + self.beta) * z - corner_sum(self.weight * corner_mean(z))

    @functools.cached_property
    def around(self) -> Float64:
        """(H+1, W+1) sum of the face weights around each vertex."""
        return corner_sum(self.weight)

    @functools.cached_property
    def unknown(self) -> Mask:
        """(H+1, W+1) bool: vertices to solve for."""
        return ~self.held & ((self.around > 0) | (self.beta > 0))

    def islands(self) -> tuple[NDArray[np.int32], int]:
        """Label of each vertex's island (0: none) and their count; faces that share a vertex are one island."""
        faces, count = ndimage.label(self.weight > 0, _EIGHT)
        labels = np.zeros(self.beta.shape, np.int32)
        for corner in (labels[:-1, :-1], labels[:-1, 1:], labels[1:, :-1], labels[1:, 1:]):
            np.maximum(corner, faces, out=corner)
        return labels, int(count)

    @property
    def is_uniform(self) -> bool:
        """Whether it is a full rectangle with one weight, one beta and nothing held, as the DCT needs."""
        weight = self.weight.flat[0]
        if self.held.any() or weight == 0 or not (self.weight == weight).all():
            return False
        beta = self.beta[1:-1, 1:-1].flat[0] if min(self.weight.shape) > 1 else self.beta.flat[0] * 4
        return bool(np.allclose(self.beta, beta * vertex_share(self.weight.shape), rtol=1e-12, atol=0))


def vertex_share(shape: tuple[int, int]) -> Float64:
    """(H+1, W+1) share of its full four faces that each vertex has: 1, 1/2 on edges, 1/4 at corners."""
    down, across = np.ones(shape[0] + 1), np.ones(shape[1] + 1)
    down[[0, -1]] = across[[0, -1]] = 0.5
    return down[:, None] * across
