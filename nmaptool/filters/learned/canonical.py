"""Rotate descriptors to a canonical frame, so the learned filter does not depend on the orientation of the mesh."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float32, Float64


def canonical_frames(descriptors: Float32) -> Float32:
    """Return each face's frame: eigenvectors of the summed outer products of its filtered normals (paper, Sec. 3.2).

    Parameters
    ----------
    descriptors : (M, K, 4) float32
        Unit normals and their agreement.

    Returns
    -------
    (M, 3, 3) float32
        Orthonormal, one axis per row, the largest eigenvalue first; each axis points to the side of the mean normal. A
        mirrored descriptor has a mirrored frame, so frames may be left-handed.
    """
    filtered = descriptors[..., :3]
    products = np.einsum("mki,mkj->mij", filtered, filtered, dtype=np.float64)
    axes = np.linalg.eigh(products)[1].swapaxes(-1, -2)[:, ::-1]
    along = np.einsum("mij,mj->mi", axes, filtered.mean(axis=1, dtype=np.float64))
    return (axes * np.where(along < 0, -1, 1)[..., None]).astype(np.float32)


def in_canonical_frame(normals: Float64, descriptors: Float32) -> tuple[Float32, Float32]:
    """Return the `canonical_frames` of faces, and the inputs of the networks in these frames."""
    frames = canonical_frames(descriptors)
    return frames, in_frames(normals, descriptors, frames)


def in_frames(normals: Float64, descriptors: Float32, frames: Float32) -> Float32:
    """Return the inputs of the networks: each face's normal and filtered normals, in its frame, then the agreements.

    Parameters
    ----------
    normals : (M, 3) float64
        The normals of the faces.
    descriptors : (M, K, 4) float32
        Unit normals and their agreement.
    frames : (M, 3, 3) float32

    Returns
    -------
    (M, 3 + 4 K) float32
    """
    turned = frames.swapaxes(-1, -2)
    own = np.matmul(normals.astype(np.float32)[:, None], turned)[:, 0]
    filtered = np.matmul(descriptors[..., :3], turned).reshape(len(normals), -1)
    return np.hstack([own, filtered, descriptors[..., 3]])
