"""Detect what an editor did to codes as if they were colours: fewer bits, tone curves, premultiplied edges."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Mask
from nmaptool.maps.codec import decode_shares, encode_shares
from nmaptool.workspace.signature import Signature

_PARTIAL_PIXELS = 50
_SAMPLE = 100_000
# mean length error due to 16-bit codes, rims and small brush strokes
_LENGTH_NOISE = 0.01
_SHIFT = 0.01

Curve = Callable[[NDArray[np.float64]], NDArray[np.float64]]


def holds_eight_bits(pixels: NDArray[Any], covered: Mask) -> bool:
    """Whether 16-bit codes have only 8-bit steps: nearly all are multiples of 257, or nearly all of 256."""
    if pixels.dtype != np.uint16 or not covered.any():
        return False
    codes = pixels[..., :3][covered]
    codes = codes[:: max(1, len(codes) // _SAMPLE)]
    if len(np.unique(codes)) < 4:  # too few codes to decide
        return False
    return any(bool(((codes % step) == 0).all(axis=1).mean() > 0.9) for step in (257, 256))


def lengths(codes: NDArray[Any]) -> NDArray[np.float64]:
    """(N,) lengths of the vectors of (N, 3) stored shares."""
    return np.asarray(np.linalg.norm(decode_shares(codes.astype(np.float64)), axis=-1))


def is_premultiplied(codes: Float32, alpha: Float32, signed: bool) -> bool:
    """Whether stored colours were multiplied by alpha, so that dividing by alpha restores unit vectors."""
    partial = (alpha > 0.1) & (alpha < 0.9)
    if partial.sum() < _PARTIAL_PIXELS:
        return False
    color, a = codes[partial].astype(np.float64), alpha[partial].astype(np.float64)
    if not signed and np.mean(color <= a[:, None] + 2 / 255) < 0.95:
        return False
    straight = np.abs(lengths(color) - 1)
    divided = np.abs(lengths(unmultiplied(color, a, signed)) - 1)
    return bool(np.median(divided) < 0.5 * np.median(straight) and np.median(straight) > _LENGTH_NOISE)


def unmultiplied(codes: NDArray[Any], alpha: NDArray[Any], signed: bool) -> NDArray[Any]:
    """Divide codes by alpha (for floats, vectors) where alpha is large enough."""
    a = np.maximum(alpha, 0.02)[..., None]
    divided = encode_shares(decode_shares(codes) / a) if signed else codes / a
    return np.where(alpha[..., None] > 0.02, divided, codes).clip(0, 1)


def _encode_srgb(x: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 1e-9) ** (1 / 2.4) - 0.055)


def _decode_srgb(x: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


# what editors apply, and its inverse
_KNOWN: dict[str, tuple[Curve, Curve]] = {
    "linear to sRGB": (_encode_srgb, _decode_srgb),
    "sRGB to linear": (_decode_srgb, _encode_srgb),
    "gamma 1/2.2": (lambda x: x ** (1 / 2.2), lambda x: x**2.2),
    "gamma 2.2": (lambda x: x**2.2, lambda x: x ** (1 / 2.2)),
    "gamma 1/1.8": (lambda x: x ** (1 / 1.8), lambda x: x**1.8),
    "gamma 1.8": (lambda x: x**1.8, lambda x: x ** (1 / 1.8)),
}


def tone_curve(codes: Float32, covered: Mask, packed: Signature | None) -> tuple[str, Curve] | None:
    """The tone curve that was applied to the colours, and its inverse; None if there was none.

    A curve changes the length of the vectors, and undoing it restores unit length. If no known curve fits and the
    layer's signature is available, a curve is fitted to the change of its quantiles.

    Parameters
    ----------
    codes : (h, w, 3) float32
        Stored shares.
    covered : (h, w) bool
    packed : Signature or None
    """
    inside = codes[covered]
    sample = inside[:: max(1, len(inside) // _SAMPLE)].astype(np.float64)
    if not len(sample):
        return None
    before = float(np.abs(lengths(sample) - 1).mean())
    if before < _LENGTH_NOISE:
        return None
    name, undo = min(_known(), key=lambda one: _off_length(one[1], sample))
    if _off_length(undo, sample) < 0.2 * before:
        return name, undo
    if packed is None:
        return None
    found = _fitted(packed.quantiles.astype(np.float64), sample)
    if found is not None and _off_length(found, sample) < 0.3 * before:
        return "an unknown curve", found
    return None


def _known() -> list[tuple[str, Curve]]:
    return [(name, undo) for name, (_, undo) in _KNOWN.items()]


def _off_length(undo: Curve, sample: NDArray[np.float64]) -> float:
    return float(np.abs(lengths(undo(sample).clip(0, 1)) - 1).mean())


def _fitted(before: NDArray[np.float64], sample: NDArray[np.float64]) -> Curve | None:
    """The rising curve that maps the present quantiles to those when packed; None if the channels disagree."""
    now = np.quantile(sample, np.linspace(0, 1, len(before)), axis=0)
    if np.abs(now - before).mean() < _SHIFT:
        return None
    order = np.argsort(now, axis=None)
    x, y = now.ravel()[order], before.ravel()[order]
    smooth = np.maximum.accumulate(np.convolve(np.pad(y, 3, mode="edge"), np.ones(7) / 7, "valid"))
    if np.abs(smooth - y).mean() > 0.25 * np.abs(now - before).mean():
        return None
    knots, first = np.unique(x, return_index=True)
    return lambda values: np.interp(values, knots, smooth[first])
