"""The local step: what each face would be, were it alone with its target normal.

Shapes are (3, M, 3) float64: first, second and third corner of every face, x, y, z each, measured from their mean.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64, Mask
from nmaptool.types.mesh import Faces, cross

# beyond this cosine the least rotation between two normals has no axis to speak of
_OPPOSED = -0.99
# cosine of 60 degrees
_FAR = 0.5
_NOTHING = 1e-12


def shapes_of(vertices: Float64, faces: Faces) -> Float64:
    """(3, M, 3) float64: the corners of each face from their mean."""
    out = np.stack([vertices.take(faces[:, k], axis=0) for k in range(3)])
    out -= out.mean(axis=0)
    return out


def normals_of(shapes: Float64) -> Float64:
    """(M, 3) float64 unit normals by the right-hand rule; zero where a face has no area."""
    twice = cross(shapes[1] - shapes[0], shapes[2] - shapes[0])
    length = np.sqrt(np.einsum("ij,ij->i", twice, twice))
    twice /= np.where(length > 0, length, 1)[:, None]
    return twice


def is_opposed(normals: Float64, targets: Float64) -> Mask:
    """(M,) bool: whose normal is more than a right angle from its target."""
    return np.asarray(np.einsum("ij,ij->i", normals, targets) < 0)


def projected(shapes: Float64, targets: Float64) -> Float64:
    """Corners projected on the plane through the face's centroid with the target normal (paper, Eq. 2).

    Parameters
    ----------
    shapes : (3, M, 3) float64
    targets : (M, 3) float64
        Unit normals.
    """
    height = np.einsum("kfi,fi->kf", shapes, targets)
    return np.asarray(shapes - height[..., None] * targets)


def rotated(shapes: Float64, normals: Float64, targets: Float64) -> Float64:
    """Corners turned by the least rotation that takes the normal to its target; opposed ones are `flattened_opposed`.

    Parameters
    ----------
    shapes : (3, M, 3) float64
    normals, targets : (M, 3) float64
        Unit normals of the shapes, and where they should look.
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
    """Corners projected; those of a face more than 60 degrees from its target turned.

    A projection halves such a face and worse, and leaves one that looks the other way looking so.
    """
    out = projected(shapes, targets)
    far = np.flatnonzero(np.einsum("ij,ij->i", normals, targets) < _FAR)
    if len(far):
        out[:, far] = rotated(shapes[:, far], normals[far], targets[far])
    return out


def flattened_opposed(shapes: Float64, normals: Float64, targets: Float64) -> Float64:
    """The shapes on the planes of their targets, the right side up, corners as near as that allows.

    Half a turn from its target a face has no least rotation: any axis in its plane would do. The one is taken that
    brings its corners nearest to their projections (Procrustes in the plane, without mirroring).

    Parameters
    ----------
    shapes : (3, K, 3) float64
    normals, targets : (K, 3) float64
    """
    flat = projected(shapes, targets)
    # axes in the plane come from the face alone, so that a turned mesh gives the turned answer
    u = _along(flat, targets)
    v = cross(targets, u)
    here = _in_plane(flat, u, v)
    own = _along(shapes, normals)
    there = _in_plane(shapes, own, cross(normals, own))
    turn = (there.conj() * here).sum(axis=0)
    size = np.abs(turn)
    sure = size > _NOTHING * (np.abs(there) ** 2).sum(axis=0)
    # of a regular triangle all turns are equally near
    placed = there * np.where(sure, turn / np.where(sure, size, 1), 1)
    return np.asarray(placed.real[..., None] * u + placed.imag[..., None] * v)


def _in_plane(shapes: Float64, u: Float64, v: Float64) -> NDArray[np.complex128]:
    """(3, K): corners along two axes."""
    return np.asarray(np.einsum("kfi,fi->kf", shapes, u) + 1j * np.einsum("kfi,fi->kf", shapes, v))


def _along(shapes: Float64, normals: Float64) -> Float64:
    """(K, 3) unit vectors across the normals, towards the corner that lies farthest out."""
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
