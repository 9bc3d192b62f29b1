"""Normals and slopes: the two ways to say how a surface leans, and how far a field of them is from a surface."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.arrays import Float32, Mask

FLAT = (0.0, 0.0, 1.0)


def unit(vectors: NDArray[Any]) -> Float32:
    """Vectors scaled to unit length; those already within float32 rounding of it keep their bits, zero becomes flat.

    Parameters
    ----------
    vectors : (..., 3) float
        Finite vectors.

    Returns
    -------
    (..., 3) float32

    Examples
    --------
    >>> unit(np.array([[3.0, 0.0, 4.0], [0.0, 0.0, 0.0]])).tolist()
    [[0.6000000238418579, 0.0, 0.800000011920929], [0.0, 0.0, 1.0]]
    """
    out = vectors.astype(np.float32)
    length = np.sqrt(np.einsum("...k,...k->...", out, out, dtype=np.float64))
    off = np.abs(length - 1) > 4e-7
    zero = length < 1e-12
    factor = np.where(off & ~zero, 1 / np.where(zero, 1, length), 1).astype(np.float32)
    out *= factor[..., None]
    out[zero] = FLAT
    return out


def slopes(normals: Float32, cap: float) -> tuple[Float32, Float32]:
    """Slopes p = -nx/nz (dz/dx) and q = -ny/nz (dz/dy, y up), no steeper than ``cap``.

    A normal that grazes or faces away (nz <= 0) keeps its direction in the picture and gets the slope ``cap``.

    Parameters
    ----------
    normals : (..., 3) float32
        Unit normals in eye space.
    cap : float
        Largest slope, rise per run, > 0.

    Returns
    -------
    p, q : (...) float32

    Examples
    --------
    >>> p, q = slopes(np.array([-0.6, 0.0, 0.8], np.float32), cap=3.0)
    >>> round(float(p), 6), float(q)
    (0.75, 0.0)
    """
    nx, ny, nz = normals[..., 0], normals[..., 1], normals[..., 2]
    across = np.hypot(nx, ny)
    steep = across >= cap * nz  # also every nz <= 0 with a direction
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = np.where(steep, cap / across, 1 / nz)
    factor[~np.isfinite(factor)] = 0  # (0, 0, -1) has no direction: call it flat
    factor = factor.astype(np.float32)
    # + 0: flat gives 0, not -0
    return -nx * factor + np.float32(0), -ny * factor + np.float32(0)


def curl(p: Float32, q: Float32) -> Float32:
    """Curl dq/dx - dp/dy (y up) at the inner vertices: how far slopes are from those of a surface.

    Parameters
    ----------
    p, q : (H, W) float32
        Slopes.

    Returns
    -------
    (H-1, W-1) float32
        Slope per px.
    """
    q_x = (q[:-1, 1:] - q[:-1, :-1] + q[1:, 1:] - q[1:, :-1]) / 2
    p_y = (p[:-1, :-1] - p[1:, :-1] + p[:-1, 1:] - p[1:, 1:]) / 2
    return np.asarray(q_x - p_y, np.float32)


def inner_vertices(mask: Mask) -> Mask:
    """(H-1, W-1) bool: vertices all of whose four pixels are in the (H, W) mask."""
    return mask[:-1, :-1] & mask[:-1, 1:] & mask[1:, :-1] & mask[1:, 1:]


def mean_abs_curl(normals: Float32, mask: Mask, cap: float = 1.0) -> float:
    """Mean |curl| over vertices inside the mask, in slope per px; 0 where there is none.

    Slopes are capped low so that silhouettes and jumps inside the motif do not drown the rest.
    """
    inside = inner_vertices(mask)
    if not inside.any():
        return 0.0
    return float(np.abs(curl(*slopes(normals, cap))[inside]).mean())


def mean_abs_curls(layers: Mapping[str, Float32], mask: Mask) -> dict[str, float]:
    """`mean_abs_curl` of several (H, W, 3) layers, by name."""
    return {name: mean_abs_curl(normals, mask) for name, normals in layers.items()}


def mean_angle_deg(first: Float32, second: Float32) -> float:
    """Mean angle between (N, 3) unit vectors, in degrees; accurate for small angles."""
    step = first.astype(np.float64) - second
    chord = np.sqrt(np.einsum("ij,ij->i", step, step))
    return float(np.degrees(2 * np.arcsin((chord / 2).clip(0, 1))).mean())
