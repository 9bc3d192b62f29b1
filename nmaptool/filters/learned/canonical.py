"""Descriptors turned into a frame of their own, so that what is learned does not depend on how a mesh lies."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float32, Float64


def canonical_frames(descriptors: Float32) -> Float32:
    """The frame of each face: eigenvectors of the summed outer products of its filtered normals (paper, Sec. 3.2).

    Parameters
    ----------
    descriptors : (M, K, 4) float32
        Unit normals and their agreement.

    Returns
    -------
    (M, 3, 3) float32
        Orthonormal, an axis a row, the one with most of the normals first; each points to the side of their mean. A
        mirrored descriptor has a mirrored frame, left-handed or not.
    """
    filtered = descriptors[..., :3]
    products = np.einsum("mki,mkj->mij", filtered, filtered, dtype=np.float64)
    axes = np.linalg.eigh(products)[1].swapaxes(-1, -2)[:, ::-1]
    along = np.einsum("mij,mj->mi", axes, filtered.mean(axis=1, dtype=np.float64))
    return (axes * np.where(along < 0, -1, 1)[..., None]).astype(np.float32)


def in_canonical_frame(normals: Float64, descriptors: Float32) -> tuple[Float32, Float32]:
    """`canonical_frames` of described faces, and the inputs of the networks in them."""
    frames = canonical_frames(descriptors)
    return frames, in_frames(normals, descriptors, frames)


def in_frames(normals: Float64, descriptors: Float32, frames: Float32) -> Float32:
    """The inputs of the networks: a face's own normal and its filtered normals, in its frame; then the agreements.

    Parameters
    ----------
    normals : (M, 3) float64
        The normals that were described.
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
