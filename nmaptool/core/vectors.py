"""Normals and slopes of surfaces, their curl, and the angles between them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Float64, Mask
from nmaptool.core.parallel import for_each_band

FLAT = (0.0, 0.0, 1.0)
# small enough for the cache
_VECTORS_AT_ONCE = 1 << 16


def unit(vectors: NDArray[Any]) -> Float32:
    """Scale vectors to unit length; those already within float32 rounding of it keep their bits, zero becomes flat.

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
    out = np.array(vectors, np.float32, order="C")
    flat = out.reshape(-1, 3)
    for_each_band(len(flat), _VECTORS_AT_ONCE, lambda band: _scale_to_unit(flat[band]))
    return out


def _scale_to_unit(vectors: Float32) -> None:
    """Scale (N, 3) vectors in place."""
    length = np.zeros(len(vectors))
    for axis in range(3):
        length += np.square(vectors[:, axis], dtype=np.float64)
    np.sqrt(length, out=length)
    off = np.abs(length - 1) > 4e-7
    if not off.any():
        return
    zero = length < 1e-12
    factor = np.where(off & ~zero, 1 / np.where(zero, 1, length), 1).astype(np.float32)
    for axis in range(3):
        vectors[:, axis] *= factor
    vectors[zero] = FLAT


def make_flat(vectors: Float32, where: Mask) -> None:
    """Set (..., 3) vectors to flat in place, where a mask says so."""
    for axis, component in enumerate(FLAT):  # several times as fast as by rows of three
        np.copyto(vectors[..., axis], np.float32(component), where=where)


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
    steepest = cap * nz
    steep = np.asarray(nx * nx + ny * ny >= steepest * np.maximum(steepest, 0))  # also every nz <= 0
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = np.asarray(-1 / nz, np.float32)
        if steep.any():
            factor[steep] = -cap / np.hypot(nx[steep], ny[steep])
            factor[~np.isfinite(factor)] = 0  # (0, 0, -1) has no direction in the picture: flat
    p, q = nx * factor, ny * factor
    p += np.float32(0)  # flat gives 0, not -0
    q += np.float32(0)
    return p, q


def curl(p: Float32, q: Float32) -> Float32:
    """Curl dq/dx - dp/dy (y up) at the inner vertices; 0 for the slopes of a surface.

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
    """Mean |curl| over vertices inside the mask, in slope per px; 0 if there are none.

    Slopes are capped low so that silhouettes and jumps inside the motif do not dominate the mean.
    """
    inside = inner_vertices(mask)
    ends = np.cumsum(np.count_nonzero(inside, axis=1))
    if not (ends.size and ends[-1]):
        return 0.0
    found = np.empty(ends[-1], np.float32)

    def fill(band: slice) -> None:
        size = np.abs(curl(*slopes(normals[band.start : band.stop + 1], cap)))
        first = ends[band.start - 1] if band.start else 0
        found[first : ends[band.stop - 1]] = size[inside[band]]

    for_each_band(len(inside), max(1, _VECTORS_AT_ONCE // mask.shape[1]), fill)
    return float(found.mean())


def mean_abs_curls(layers: Mapping[str, Float32], mask: Mask) -> dict[str, float]:
    """`mean_abs_curl` of several (H, W, 3) layers, by name."""
    return {name: mean_abs_curl(normals, mask) for name, normals in layers.items()}


def angles_deg(first: NDArray[np.floating], second: NDArray[np.floating]) -> Float64:
    """(N,) float64: degrees between (N, 3) unit vectors; accurate for small angles."""
    step = first.astype(np.float64) - second
    chord = np.sqrt(np.einsum("ij,ij->i", step, step))
    return np.asarray(np.degrees(2 * np.arcsin((chord / 2).clip(0, 1))))


def mean_angle_deg(first: NDArray[np.floating], second: NDArray[np.floating]) -> float:
    """Mean of `angles_deg`."""
    return float(angles_deg(first, second).mean())
