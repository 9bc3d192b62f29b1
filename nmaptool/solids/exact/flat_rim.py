"""Flat places along an exact outline, where a few large triangles of the strip replace pixels."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.grid import dilated, touching_vertices
from nmaptool.solids.exact.inner import joined_at_sides

# a surface is flat where heights bend less, in mm
_FLAT_MM = 1e-9
# the strip between flat blocks and the outline is at most as wide as a block, otherwise as this, in px
STRIP_PX = 3
_BLOCK_PX = 8


def bent_nearby(heights: Sequence[Float64], over: Mask) -> Mask:
    """(H+1, W+1) bool: vertices with places nearby where slopes change.

    Parameters
    ----------
    heights : sequence of (H+1, W+1) float64
    over : (H, W) bool
        Pixels that are looked at.
    """
    known = touching_vertices(over)
    bent = np.zeros(known.shape, bool)
    for z_mm in heights:
        for along in (0, 1):
            z, seen = np.moveaxis(z_mm, along, 0), np.moveaxis(known, along, 0)
            bends = np.abs(z[:-2] - 2 * z[1:-1] + z[2:]) > _FLAT_MM
            np.moveaxis(bent, along, 0)[1:-1] |= bends & seen[:-2] & seen[1:-1] & seen[2:]
        twists = np.abs(z_mm[1:, 1:] - z_mm[1:, :-1] - z_mm[:-1, 1:] + z_mm[:-1, :-1]) > _FLAT_MM
        bent[1:, 1:] |= twists & over
    return dilated(bent, STRIP_PX)


def without_flat_rim(inner: Mask, bent: Mask) -> Mask:
    """The inner pixels of a plate without those of blocks that the outline cuts where the surface is flat.

    Parameters
    ----------
    inner : (H, W) bool
    bent : (H+1, W+1) bool
        From `bent_nearby`.
    """
    kept, is_bent = _blocks(inner), _blocks(bent[1:, 1:] | bent[1:, :-1] | bent[:-1, 1:] | bent[:-1, :-1])
    flat = np.logical_not(kept.all(axis=(1, 3)) | is_bent.any(axis=(1, 3)))
    kept = kept & ~np.asarray(flat)[:, None, :, None]
    rows, cols = inner.shape
    return joined_at_sides(kept.reshape(kept.shape[0] * _BLOCK_PX, -1)[:rows, :cols])


def _blocks(mask: Mask) -> Mask:
    """(m, block, n, block) bool: a mask in square blocks, with False beyond its right and lower border."""
    rows, cols = (-side % _BLOCK_PX for side in mask.shape)
    padded = np.pad(mask, ((0, rows), (0, cols)))
    return padded.reshape(padded.shape[0] // _BLOCK_PX, _BLOCK_PX, padded.shape[1] // _BLOCK_PX, _BLOCK_PX)
