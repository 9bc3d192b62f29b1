"""Detail maps: the difference between an original and its base as normals, flat where both are equal.

For each encoding, one blend mode restores the original from base and detail.
"""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float32
from nmaptool.core.vectors import FLAT, slopes, unit

# steeper slopes are reduced to this before they are subtracted
_STEEPEST = 50.0
_VECTORS_AT_ONCE = 1 << 20


def encode_detail(original: Float32, base: Float32, encoding: str = "rotation") -> Float32:
    """Compute detail normals from original and base.

    Parameters
    ----------
    original, base : (..., 3) float32
        Unit normals.
    encoding : str
        ``rotation``: the rotation that takes the base to (0, 0, 1), applied to the original; reoriented blending
        undoes it. ``slope``: the difference of the slopes, each at most 50; partial-derivative blending undoes it
        if neither is steeper. ``difference``: (0, 0, 1) + original - base, normalised.

    Returns
    -------
    (..., 3) float32
        Unit normals; exactly (0, 0, 1) where original and base are equal.
    """
    if encoding not in _ENCODINGS:
        raise ValueError(f"unknown encoding {encoding!r}")
    detail = np.empty(original.shape, np.float32)
    o, b, d = (a.reshape(-1, 3) for a in (original, base, detail))
    for first in range(0, len(o), _VECTORS_AT_ONCE):
        part = slice(first, first + _VECTORS_AT_ONCE)
        d[part] = _ENCODINGS[encoding](o[part], b[part])
        d[part][(o[part] == b[part]).all(axis=-1)] = FLAT
    return detail


def _slope(original: Float32, base: Float32) -> Float32:
    p, q = (o - b for o, b in zip(slopes(original, _STEEPEST), slopes(base, _STEEPEST), strict=True))
    return unit(np.stack([-p, -q, np.ones_like(p)], axis=-1))


def _difference(original: Float32, base: Float32) -> Float32:
    return unit(original - base + np.array(FLAT, np.float32))


def _rotation(original: Float32, base: Float32) -> Float32:
    o, b = original.astype(np.float64), base.astype(np.float64)
    # half-way vector form, two reflections: stable unless the base faces straight away
    towards = 1 + b[..., 2]
    across = b[..., 0] * o[..., 0] + b[..., 1] * o[..., 1]
    away = towards < 1e-9
    share = (across + towards * o[..., 2]) / np.where(away, 1, towards)
    out = np.empty_like(o)
    out[..., 0] = o[..., 0] - b[..., 0] * share
    out[..., 1] = o[..., 1] - b[..., 1] * share
    out[..., 2] = across + b[..., 2] * o[..., 2]
    out[away] = o[away] * (1, -1, -1)
    return unit(out)


_ENCODINGS = {"rotation": _rotation, "slope": _slope, "difference": _difference}
