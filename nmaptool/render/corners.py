"""Normals at the corners of faces, for smooth shading that keeps creases sharp."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.types.mesh import Mesh, sum_by


def corner_normals(mesh: Mesh, directions: Float64, crease: float) -> Float64:
    """Average the normals of the faces around each corner, weighted by their angles at the vertex.

    Parameters
    ----------
    mesh : Mesh
        Cleaned and welded.
    directions : (M, 3) float64
        Unit normals of the faces: the mesh's own, or a base layer's.
    crease : float
        Degrees; faces whose normals differ by more are not averaged with each other.

    Returns
    -------
    (M, 3, 3) float64
        Unit normals, one for each corner of each face.
    """
    weights = corner_angles(mesh)
    vertex = mesh.faces.ravel()
    face = np.repeat(np.arange(len(mesh.faces)), 3)
    weighted = directions.take(face, axis=0) * weights.ravel()[:, None]
    total = sum_by(vertex, weighted, len(mesh.vertices))
    length = np.sqrt(np.einsum("ij,ij->i", total, total))
    mean = total / np.where(length > 1e-12, length, 1)[:, None]
    out = mean.take(vertex, axis=0)
    # if every face is within half the crease angle of the mean, all of them are averaged
    off = np.einsum("ij,ij->i", directions.take(face, axis=0), out) < np.cos(np.radians(min(crease, 180) / 2))
    sharp = np.zeros(len(mesh.vertices), bool)
    sharp[vertex[off]] = True
    chosen = np.flatnonzero(sharp[vertex])
    if len(chosen):
        out[chosen] = _within_crease(vertex[chosen], directions[face[chosen]], weighted[chosen], crease)
    return np.asarray(out.reshape(-1, 3, 3))


def _within_crease(vertex: NDArray[np.integer], own: Float64, weighted: Float64, crease: float) -> Float64:
    """For each corner, the unit sum over the corners at its vertex whose faces are within the crease angle."""
    order = np.argsort(vertex, kind="stable")
    starts = np.flatnonzero(np.diff(vertex[order], prepend=-1))
    sizes = np.diff(np.append(starts, len(vertex)))
    size = np.repeat(sizes, sizes)  # number of corners at the vertex of each corner
    first = np.repeat(np.arange(len(vertex)), size)
    begin = np.repeat(np.repeat(starts, sizes), size)
    within = np.arange(len(first)) - np.repeat(np.cumsum(size) - size, size)
    one, other = order[first], order[begin + within]
    alike = np.einsum("ij,ij->i", own[one], own[other]) >= np.cos(np.radians(crease)) - 1e-9
    total = sum_by(one[alike], weighted[other[alike]], len(vertex))
    length = np.sqrt(np.einsum("ij,ij->i", total, total))
    lost = length < 1e-12
    return np.where(lost[:, None], own, total / np.where(lost, 1, length)[:, None])


def corner_angles(mesh: Mesh) -> Float64:
    """(M, 3) float64: the angle in radians at each corner."""
    corner = mesh.corners
    out = np.empty(mesh.faces.shape)
    for k in range(3):
        u, v = corner[:, (k + 1) % 3] - corner[:, k], corner[:, (k + 2) % 3] - corner[:, k]
        uu, vv, uv = (np.einsum("ij,ij->i", a, b) for a, b in ((u, u), (v, v), (u, v)))
        out[:, k] = np.arccos((uv / np.sqrt(uu * vv)).clip(-1, 1))
    return out
