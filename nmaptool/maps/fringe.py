"""Repair the rim that anti-aliasing leaves around a motif, where a stored vector mixes surface and background."""

from __future__ import annotations

import cv2
import numpy as np

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.grid import dilated
from nmaptool.core.nearest import nearest_places
from nmaptool.core.parallel import for_each_band

# width in which a rim is looked for, and width up to which it is followed inwards while lengths are off
_RIM_PX = 2
_WIDEST_RIM_PX = 6
_LENGTH_TOLERANCE = 0.03
# a rim vector of unit length also counts as a mixture if it lies near the line from the normal inside it to the
# background (off the line by less than this share of its move) and has moved along at least this share of that line
_MIXTURE_OFF_LINE = 0.35
_MIXTURE_ALONG = 0.08
_VECTORS_AT_ONCE = 1 << 16
# in windows of a large map, a rim is followed along the outline, and its normals are looked for, only so far; a pixel
# then depends on no pixel farther than this, so that windows with this margin agree
_CHAIN_PX, _NEAREST_PX = 20, 12
RIM_MARGIN_PX = max(_CHAIN_PX + _WIDEST_RIM_PX, 2 * _NEAREST_PX + _RIM_PX)


def repair_rim(
    vectors: Float32,
    outside: Mask,
    background: Float32 | None,
    *,
    is_normal: bool = False,
    mixed: Float32 | None = None,
    in_window: bool = False,
) -> tuple[Float32, Float32, Mask]:
    """Give the anti-aliased rim of a motif the normals just inside it, and compute its coverage.

    A rim pixel stores c n + (1 - c) b, with n a unit normal, b the background's vector and c its coverage. It is
    detected by its length, or because it lies on the line from the normals inside to b. It lies within 2 px of the
    background, or up to 6 px if it is connected to such pixels and its length is off. n is taken from the nearest pixel
    that is not a mixture; c follows from n and b.

    Parameters
    ----------
    vectors : (H, W, 3) float32
        Decoded vectors, not yet normalised.
    outside : (H, W) bool
        Background.
    background : (K,) float32 or None
        Vector that the background decodes to, or its K stored components; None if alpha already gives the coverage.
    is_normal : bool
        The background is itself a normal (flat). Vectors between it and the motif may be surface, so only lengths are
        used.
    mixed : (H, W, K) float32, optional
        The stored components that anti-aliasing mixed, if the vectors were computed from them. Default: the vectors.
    in_window : bool
        The vectors are a window of a large map. A rim is then followed over 20 px at most, and takes its normals from
        at most 12 px away, so that a pixel depends on those within ``RIM_MARGIN_PX`` only.

    Returns
    -------
    vectors : (H, W, 3) float32
        A copy with the rim replaced.
    coverage : (H, W) float32
        0 outside, 1 inside, in between on the rim (1 there if ``background`` is None).
    rim : (H, W) bool
        The pixels that were replaced.
    """
    mixed = vectors if mixed is None else mixed
    coverage = (~outside).astype(np.float32)
    near = dilated(outside, _RIM_PX) & ~outside
    if not near.any():
        return vectors, coverage, near
    sound = ~outside & _of_unit_length(vectors)
    wide = _off_length_rim(near & ~sound, outside, sound, _CHAIN_PX if in_window else None)
    if background is not None and not is_normal and (sound & ~near).any():
        at = _within_reach(near & sound, sound & ~near) if in_window else near & sound
        inner = mixed[nearest_places(sound & ~near, at)]
        share, off_line = _unmix(mixed[at], inner, background)
        sound[at] = (1 - share < _MIXTURE_ALONG) | (off_line > _MIXTURE_OFF_LINE)
    rim = (near & ~sound) | wide
    rim = _within_reach(rim, sound) if in_window else rim
    if not rim.any() or not sound.any():
        return vectors, coverage, np.zeros(rim.shape, bool)
    nearest = nearest_places(sound, rim)
    fixed = vectors.copy()
    fixed[rim] = vectors[nearest]
    if background is not None:
        coverage[rim] = _unmix(mixed[rim], mixed[nearest], background)[0]
    return fixed, coverage, rim


def _within_reach(at: Mask, sought: Mask) -> Mask:
    """(H, W) bool: those pixels of ``at`` that have one of ``sought`` close enough."""
    if not at.any():
        return at
    steps = np.arange(-_NEAREST_PX, _NEAREST_PX + 1)
    disc = (steps[:, None] ** 2 + steps**2 <= _NEAREST_PX**2).astype(np.uint8)
    return np.asarray(at & cv2.dilate(sought.view(np.uint8), disc).view(np.bool_))


def _off_length_rim(start: Mask, outside: Mask, sound: Mask, most_steps: int | None) -> Mask:
    """(H, W) bool: ``start`` and the pixels of wrong length connected to it, up to the widest rim and so many steps."""
    if not start.any():
        return start
    off_length = dilated(outside, _WIDEST_RIM_PX) & ~outside & ~sound
    if most_steps is not None:
        reached = start
        for _ in range(most_steps):
            reached = dilated(reached, 1) & off_length
        return reached
    count, patches = cv2.connectedComponents(off_length.view(np.uint8), connectivity=8, ltype=cv2.CV_32S)
    connected = np.zeros(count, bool)
    connected[patches[start]] = True
    return np.asarray(connected[patches])


def _of_unit_length(vectors: Float32) -> Mask:
    """(H, W) bool: where vectors are of unit length."""
    found = np.empty(vectors.shape[:2], bool)

    def look(band: slice) -> None:
        length = np.sqrt(np.einsum("ijk,ijk->ij", vectors[band], vectors[band]))
        found[band] = np.abs(length - 1) <= _LENGTH_TOLERANCE

    for_each_band(len(found), max(1, _VECTORS_AT_ONCE // vectors.shape[1]), look)
    return found


def _unmix(mixed: Float32, inner: Float32, background: Float32) -> tuple[Float32, Float32]:
    """Share of ``inner`` in each mixture, 0 to 1, and its distance from the line to the background over its move."""
    span = inner - background
    size = np.maximum(np.einsum("ik,ik->i", span, span), np.float32(1e-6))
    share = (np.einsum("ik,ik->i", mixed - background, span) / size).clip(0, 1)
    off = np.linalg.norm(mixed - background - share[:, None] * span, axis=1)
    moved = np.linalg.norm(mixed - inner, axis=1)
    return share.astype(np.float32), (off / np.maximum(moved, 1e-6)).astype(np.float32)
