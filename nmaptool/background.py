"""Where a picture's background is and what it is: alpha, white, grey, black or flat.

Also the rim that anti-aliasing leaves around a motif, where the stored vector is part surface and part background.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from nmaptool.arrays import Float32, Mask
from nmaptool.codec import flat_codes
from nmaptool.model import RasterImage

# smallest patch of an impossible colour that is called background, and smallest share of the picture's edge that a
# flat background must hold (flat is a valid normal, so it needs more proof)
_MIN_PATCH_PIXELS = 16
_MIN_PATCH_SHARE = 2e-4
_MIN_TOTAL_SHARE = 2e-3
_MIN_FLAT_EDGE_SHARE = 0.1
_LOSSY_TOLERANCE = 8.0  # 8-bit codes around a colour in JPEG
_HALF_TOLERANCE = 3e-4
_DATA_ALPHA_SHARE = 0.3
_RIM_PX = 2
_RIM_LENGTH_TOLERANCE = 0.03
# a rim vector of unit length is still a mixture where it lies this near the line from the normal inside it to the
# background, and this far along it
_MIXTURE_OFF_LINE = 0.35
_MIXTURE_ALONG = 0.08
_EIGHT = np.ones((3, 3), bool)


@dataclass(frozen=True, eq=False)
class Background:
    """A background: its kind, where it is (H, W bool), and the stored vector it decodes to (None for alpha)."""

    kind: str
    mask: Mask
    codes: tuple[float, ...] | None = None


def alpha_is_data(image: RasterImage) -> bool:
    """Whether alpha varies like a height or gloss channel rather than covering a motif; never in our own files."""
    alpha = image.alpha
    if alpha is None or image.attributes.get("kind") == "normal":
        return False
    partial = (alpha > 0.02) & (alpha < 0.98)
    return bool(partial.mean() > _DATA_ALPHA_SHARE)


def _candidates(image: RasterImage) -> Iterator[tuple[str, tuple[float, ...]]]:
    """Stored colours that files use for "nothing here"."""
    if image.is_float:
        yield "white", (1.0, 1.0, 1.0)
        yield "black", (0.0, 0.0, 0.0)
        yield "flat", (0.0, 0.0, 1.0)
        for middle in (0.5, 128 / 255, 127 / 255):  # as it is, or as 8-bit codes were
            yield "grey", (middle, middle, middle)
            yield "flat", (middle, middle, 1.0)
        return
    top = image.max_code
    middle = (top + 1) // 2
    yield "white", (top, top, top)
    yield "black", (0, 0, 0)
    yield "grey", (middle, middle, middle)
    yield "grey", (middle - 1, middle - 1, middle - 1)
    for codes in flat_codes(top).values():
        yield "flat", codes
    if top == 65535:  # 8-bit codes widened to 16 bits
        yield "grey", (128 * 257,) * 3
        yield "grey", (127 * 257,) * 3
        yield "flat", (128 * 257, 128 * 257, top)
        yield "flat", (127 * 257, 127 * 257, top)


def _hex_codes(text: str, image: RasterImage, order: tuple[int, ...]) -> tuple[float, ...]:
    eight = [int(text[1 + 2 * channel : 3 + 2 * channel], 16) for channel in order]
    return tuple(c / 255 if image.is_float else float(c * (image.max_code // 255)) for c in eight)


def _matches(xyz: NDArray[Any], codes: tuple[float, ...], image: RasterImage) -> Mask:
    slack = _LOSSY_TOLERANCE if image.lossy else 0.0
    if slack or image.is_float:
        slack = slack or (1e-6 if image.bits == 32 else _HALF_TOLERANCE)
        near = np.abs(xyz.astype(np.float32) - np.array(codes, np.float32)) <= slack
    else:
        near = xyz == np.array(codes, xyz.dtype)
    return np.asarray(near.all(axis=-1))


def _edge(mask: Mask) -> NDArray[np.bool_]:
    return np.concatenate([mask[0], mask[-1], mask[1:-1, 0], mask[1:-1, -1]])


def _patches(mask: Mask, kind: str) -> Mask:
    """The parts of ``mask`` that can be background: big enough, and for flat, reaching the picture's edge."""
    labels, count = ndimage.label(mask, _EIGHT)
    if count == 0:
        return mask
    if kind == "flat":
        keep = np.zeros(count + 1, bool)
        keep[_edge(labels)] = True
    else:
        keep = np.bincount(labels.ravel()) >= max(_MIN_PATCH_PIXELS, _MIN_PATCH_SHARE * mask.size)
    keep[0] = False
    return np.asarray(keep[labels])


def find_background(
    image: RasterImage, xyz: NDArray[Any], wanted: str, order: tuple[int, ...] = (0, 1, 2)
) -> Background:
    """Find the background of a picture.

    Parameters
    ----------
    image : RasterImage
        Gives alpha, the range of codes and whether they are lossy.
    xyz : (H, W, 3)
        The stored codes of the three components.
    wanted : str
        "auto", "none", a kind, or "#rrggbb".
    order : tuple of int
        Which of the channels R, G, B each component came from.

    Returns
    -------
    Background
        Kind "none" with an empty mask where nothing is found.
    """
    nothing = Background("none", np.zeros(xyz.shape[:2], bool))
    if wanted == "none":
        return nothing
    alpha = image.alpha
    if wanted == "alpha" or (wanted == "auto" and alpha is not None and not alpha_is_data(image)):
        see_through = alpha < 0.5 if alpha is not None else nothing.mask
        if wanted == "alpha" or see_through.any():
            return Background("alpha", see_through)
    if wanted.startswith("#"):
        codes = _hex_codes(wanted, image, order)
        return Background(wanted, _matches(xyz, codes, image), codes)
    best, best_score = nothing, 0.0
    for kind, codes in _candidates(image):
        if wanted not in ("auto", kind):
            continue
        mask = _patches(_matches(xyz, codes, image), kind)
        edge_share, total_share = float(_edge(mask).mean()), float(mask.mean())
        if wanted == "auto" and (
            total_share < _MIN_TOTAL_SHARE or (kind == "flat" and edge_share < _MIN_FLAT_EDGE_SHARE)
        ):
            continue
        score = edge_share + total_share
        if score > best_score:
            best, best_score = Background(kind, mask, codes), score
    return best


def repair_rim(vectors: Float32, outside: Mask, background: Float32 | None) -> tuple[Float32, Float32, int]:
    """Give the anti-aliased rim of a motif the normals just inside it, and its coverage by un-mixing.

    A rim pixel is one within 2 px of the background that stores c n + (1 - c) b, with n a unit normal and b the
    background's vector: its length is off, or it lies on the way from the normals inside to b. n is taken from the
    nearest sound pixel, which leaves c to be read off.

    Parameters
    ----------
    vectors : (H, W, 3) float32
        Decoded vectors, not yet normalised.
    outside : (H, W) bool
        Background.
    background : (3,) float32 or None
        Vector that the background decodes to; None where alpha tells coverage already.

    Returns
    -------
    vectors : (H, W, 3) float32
        A copy with the rim replaced.
    coverage : (H, W) float32
        0 outside, 1 inside, between on the rim (1 there where ``background`` is None).
    count : int
        Rim pixels replaced.
    """
    coverage = (~outside).astype(np.float32)
    near = ndimage.binary_dilation(outside, _EIGHT, iterations=_RIM_PX) & ~outside
    length = np.sqrt(np.einsum("ijk,ijk->ij", vectors, vectors))
    sound = ~outside & (np.abs(length - 1) <= _RIM_LENGTH_TOLERANCE)
    if background is not None and (sound & ~near).any():
        at = near & sound
        inner = _nearest(vectors, sound & ~near, at)
        share, off_line = _unmix(vectors[at], inner, background)
        sound[at] = (1 - share < _MIXTURE_ALONG) | (off_line > _MIXTURE_OFF_LINE)
    rim = near & ~sound
    if not rim.any() or not sound.any():
        return vectors, coverage, 0
    inner = _nearest(vectors, sound, rim)
    fixed = vectors.copy()
    fixed[rim] = inner
    if background is not None:
        coverage[rim] = _unmix(vectors[rim], inner, background)[0]
    return fixed, coverage, int(rim.sum())


def _nearest(vectors: Float32, sound: Mask, at: Mask) -> Float32:
    """(N, 3) the vector of the sound pixel nearest to each of the N pixels of ``at``."""
    rows, cols = ndimage.distance_transform_edt(~sound, return_distances=False, return_indices=True)
    found: Float32 = vectors[rows[at], cols[at]]
    return found


def _unmix(mixed: Float32, inner: Float32, background: Float32) -> tuple[Float32, Float32]:
    """Share of ``inner`` in each mixture, 0..1, and how far off the line to the background it lies, as a share too."""
    span = inner - background
    size = np.maximum(np.einsum("ik,ik->i", span, span), np.float32(1e-6))
    share = (np.einsum("ik,ik->i", mixed - background, span) / size).clip(0, 1)
    off = np.linalg.norm(mixed - background - share[:, None] * span, axis=1)
    moved = np.linalg.norm(mixed - inner, axis=1)
    return share.astype(np.float32), (off / np.maximum(moved, 1e-6)).astype(np.float32)
