"""The local step: the shape of each face for its target normal, regardless of its neighbours.

Shapes are (3, M, 3) float64: x, y, z of the first, second and third corner of every face, relative to their mean.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64, Mask
from nmaptool.types.mesh import Faces, cross

# below this cosine, the axis of the smallest rotation between two normals is ill-defined
_OPPOSED = -0.99
# cosine of 60 degrees
_FAR = 0.5
_NOTHING = 1e-12


def shapes_of(vertices: Float64, faces: Faces) -> Float64:
    """Return (3, M, 3) float64: the corners of each face relative to their mean."""
    out = np.stack([vertices.take(faces[:, k], axis=0) for k in range(3)])
    out -= out.mean(axis=0)
    return out


def normals_of(shapes: Float64) -> Float64:
    """Return the (M, 3) float64 unit normals by the right-hand rule; zero for faces without area."""
    twice = cross(shapes[1] - shapes[0], shapes[2] - shapes[0])
    length = np.sqrt(np.einsum("ij,ij->i", twice, twice))
    twice /= np.where(length > 0, length, 1)[:, None]
    return twice


def is_opposed(normals: Float64, targets: Float64) -> Mask:
    """Return (M,) bool: faces whose normal is more than a right angle from its target."""
    return np.asarray(np.einsum("ij,ij->i", normals, targets) < 0)


def projected(shapes: Float64, targets: Float64) -> Float64:
    """Project the corners onto the plane through the face's centroid with the target normal (paper, Eq. 2).

    Parameters
    ----------
    shapes : (3, M, 3) float64
    targets : (M, 3) float64
        Unit normals.
    """
    height = np.einsum("kfi,fi->kf", shapes, targets)
    return np.asarray(shapes - height[..., None] * targets)


def rotated(shapes: Float64, normals: Float64, targets: Float64) -> Float64:
    """Rotate the corners by the smallest rotation from normal to target; opposed faces by `flattened_opposed`.

    Parameters
    ----------
    shapes : (3, M, 3) float64
    normals, targets : (M, 3) float64
        Unit normals of the shapes, and their targets.
    """
    axis = cross(normals, targets)
    cosine = np.einsum("ij,ij->i", normals, targets)
    share = 1 / np.maximum(1 + cosine, 1 + _OPPOSED)[:, None]
    out = shapes.copy()
    for corner in range(3):
        once = cross(axis, shapes[corner])
        out[corner] += once + cross(axis, once) * share
    past = np.flatnonzero(cosine < _OPPOSED)
    if len(past):
        out[:, past] = flattened_opposed(shapes[:, past], normals[past], targets[past])
    return out


def target_shapes(shapes: Float64, normals: Float64, targets: Float64) -> Float64:
    """Project the corners; rotate those of faces more than 60 degrees from their targets.

    A projection would shrink such a face to less than half its area, and would not turn over a face that points the
    opposite way.
    """
    out = projected(shapes, targets)
    far = np.flatnonzero(np.einsum("ij,ij->i", normals, targets) < _FAR)
    if len(far):
        out[:, far] = rotated(shapes[:, far], normals[far], targets[far])
    return out


def flattened_opposed(shapes: Float64, normals: Float64, targets: Float64) -> Float64:
    """Return the shapes in the planes of their targets, the right side up, with corners moved as little as possible.

    For a face half a turn from its target, no rotation is the smallest: any axis in its plane would do. This uses the
    one that brings the corners closest to their projections (Procrustes in the plane, without mirroring).

    Parameters
    ----------
    shapes : (3, K, 3) float64
    normals, targets : (K, 3) float64
    """
    flat = projected(shapes, targets)
    # the axes in the plane depend on the face only, so a rotated mesh gives the rotated result
    u = _along(flat, targets)
    v = cross(targets, u)
    here = _in_plane(flat, u, v)
    own = _along(shapes, normals)
    there = _in_plane(shapes, own, cross(normals, own))
    turn = (there.conj() * here).sum(axis=0)
    size = np.abs(turn)
    sure = size > _NOTHING * (np.abs(there) ** 2).sum(axis=0)
    # for an equilateral triangle, all rotations are equally close
    placed = there * np.where(sure, turn / np.where(sure, size, 1), 1)
    return np.asarray(placed.real[..., None] * u + placed.imag[..., None] * v)


def _in_plane(shapes: Float64, u: Float64, v: Float64) -> NDArray[np.complex128]:
    """Return the (3, K) coordinates of the corners along two axes, as complex numbers."""
    return np.asarray(np.einsum("kfi,fi->kf", shapes, u) + 1j * np.einsum("kfi,fi->kf", shapes, v))


def _along(shapes: Float64, normals: Float64) -> Float64:
    """Return (K, 3) unit vectors perpendicular to the normals, towards the farthest corner."""
    farthest = np.einsum("kfi,kfi->kf", shapes, shapes).argmax(axis=0)
    out = np.take_along_axis(shapes, farthest[None, :, None], axis=0)[0]
    scale = np.sqrt(np.einsum("ij,ij->i", out, out))
    out = out - np.einsum("ij,ij->i", out, normals)[:, None] * normals
    size = np.sqrt(np.einsum("ij,ij->i", out, out))
    lost = np.flatnonzero(~(size > _NOTHING * scale))
    if len(lost):
        axes = np.eye(3)[np.abs(normals[lost]).argmin(axis=1)]
        out[lost] = cross(normals[lost], axes)
        size[lost] = np.sqrt(np.einsum("ij,ij->i", out[lost], out[lost]))
    return np.asarray(out / size[:, None])
