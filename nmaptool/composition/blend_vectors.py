"""Blend the normals of a detail map with those of a base map, in one of the modes of `nmaptool.options.BLEND_MODES`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.composition.blend_kernels import Component, Pair, Triple
from nmaptool.core.arrays import Float32
from nmaptool.core.parallel import for_each_band
from nmaptool.options import BLEND_MODES, BlendMode

# normals that are steeper or face away are limited to this slope before slopes are added or faded
_STEEPEST = 50.0
_SHORTEST = 1e-12
# chunks that fit in the cache
_VECTORS_AT_ONCE = 1 << 16
_CHUNKS_OF_A_BAND = 8


def blend_normals(base: Float32, detail: Float32, mode: str = "rnm", strength: float | NDArray[Any] = 1.0) -> Float32:
    """Blend detail normals with base normals.

    Parameters
    ----------
    base, detail : (..., 3) float32
        Unit normals.
    mode : str
        A key of `nmaptool.options.BLEND_MODES`: ``rnm`` rotates the detail with the base (the inverse of ``rotation``
        in `nmaptool.maps.detail`), ``pd`` adds slopes (the inverse of ``slope``; the sum of two surfaces is a surface),
        ``whiteout`` and ``udn`` are cheaper approximations of it, ``linear`` is the direction of the sum, ``overlay``
        the overlay of image editors, applied to the codes.
    strength : float or (...) float
        0 leaves the base bit-for-bit unchanged. In the first four modes, it multiplies the slopes of the detail; in
        ``linear`` it weights the detail, in ``overlay`` it mixes the result with the base.

    Returns
    -------
    (..., 3) float32
        Unit normals. In the first four modes, a flat detail leaves the base bit-for-bit unchanged; in rnm, pd and
        whiteout, a flat base leaves the detail bit-for-bit unchanged.

    Raises
    ------
    ValueError
        If the mode is unknown, the shapes do not match, or a strength is negative or not finite.
    """
    if mode not in BLEND_MODES:
        raise ValueError(f"unknown mode {mode!r}: use one of {', '.join(BLEND_MODES)}")
    if base.shape != detail.shape or base.shape[-1] != 3:
        raise ValueError(f"base {base.shape} and detail {detail.shape} must have the same shape (..., 3)")
    kind, weight = BLEND_MODES[mode], np.asarray(strength, np.float32)
    if weight.size and not (weight.min() >= 0 and weight.max() < np.inf):  # also for NaN
        raise ValueError("strength must be finite and zero or more")
    out = np.empty(base.shape, np.float32)
    a, b, o = (np.ascontiguousarray(v, np.float32).reshape(-1, 3) for v in (base, detail, out))
    each = None if weight.ndim == 0 else np.broadcast_to(weight, base.shape[:-1]).reshape(-1)

    def part(band: slice) -> None:
        work = np.empty((11, min(_VECTORS_AT_ONCE, band.stop - band.start)), np.float32)
        for first in range(band.start, band.stop, _VECTORS_AT_ONCE):
            chunk = slice(first, min(first + _VECTORS_AT_ONCE, band.stop))
            rows = work[:, : chunk.stop - chunk.start]
            _blend_chunk(a[chunk], b[chunk], kind, weight if each is None else each[chunk], o[chunk], rows)

    for_each_band(len(a), _VECTORS_AT_ONCE * _CHUNKS_OF_A_BAND, part)
    return out


def _blend_chunk(
    base: Float32, detail: Float32, mode: BlendMode, strength: NDArray[Any], out: Float32, work: NDArray[np.float32]
) -> None:
    """Blend (N, 3) vectors into ``out``; ``work`` (11, N) is reused, since allocation costs more than arithmetic."""
    a, b, o = ((work[i], work[i + 1], work[i + 2]) for i in (0, 3, 6))
    t = work[9], work[10]
    for axis in range(3):
        a[axis][...] = base[:, axis]
        b[axis][...] = detail[:, axis]
    whole = strength.ndim == 0 and float(strength) == 1
    flat_base = _flat(a) if mode.flat_base else None
    flat_detail = _flat(b) if mode.keeps_flat else None
    if mode.adds_slopes:
        _make_upright(a, t)
        _make_upright(b, t)
    if mode.fades == "detail" and not whole:
        _fade(b, strength, t, upright=not mode.adds_slopes)
    elif mode.fades == "sum" and not whole:
        for component in b:
            np.multiply(component, strength, out=component)
    mode.function(a, b, o, t)
    size = _length(o, t)
    if mode.fades == "result" and not whole:
        full = strength == 1  # there, nothing changes, so a pixel does not depend on the strength of others
        for under, component in zip(a, o, strict=True):
            before = component.copy() if np.any(full) else component
            np.divide(component, size, out=component)
            np.subtract(component, under, out=component)
            np.multiply(component, strength, out=component)
            np.add(component, under, out=component)
            np.copyto(component, before, where=full)
        size = _length(o, t)
    for axis, component in enumerate(o):
        np.divide(component, size, out=out[:, axis])
    if flat_base is not None:  # these must be bit-for-bit unchanged
        _copy_where(flat_base & (strength == 1), detail, out)
    _copy_where(strength == 0, base, out)
    if flat_detail is not None:
        _copy_where(flat_detail, base, out)
    if size.min() <= _SHORTEST:  # opposite normals have no direction
        _copy_where(size <= _SHORTEST, base, out)


def _copy_where(chosen: Any, vectors: Float32, out: Float32) -> None:
    if not np.any(chosen):
        return
    if np.all(chosen):
        out[...] = vectors
    else:
        out[chosen] = vectors[chosen]


def _flat(v: Triple) -> NDArray[np.bool_]:
    flat: NDArray[np.bool_] = v[0] == 0
    if flat.any():
        flat &= v[1] == 0
        flat &= v[2] > 0
    return flat


def _length(v: Triple, t: Pair) -> Component:
    """Return the lengths, in the first array of ``t``, limited below by the shortest."""
    size, square = t
    np.multiply(v[0], v[0], out=size)
    size += np.multiply(v[1], v[1], out=square)
    size += np.multiply(v[2], v[2], out=square)
    np.sqrt(size, out=size)
    if not size.min() > _SHORTEST:
        np.maximum(size, np.float32(_SHORTEST), out=size)
    return size


def _make_upright(v: Triple, t: Pair) -> None:
    """Limit slopes to the steepest one, in place; directions in the picture stay, but steeper vectors change length."""
    x, y, z = v
    least, limit = t
    np.multiply(x, x, out=least)
    least += np.multiply(y, y, out=limit)
    np.abs(z, out=limit)
    limit *= z
    limit *= np.float32(_STEEPEST**2 * 0.999)  # slightly less: the exact test follows
    if (limit > least).all():
        return
    np.sqrt(least, out=least)
    least /= np.float32(_STEEPEST)
    np.maximum(least, z, out=z)
    z[z == 0] = 1


def _fade(v: Triple, strength: NDArray[Any], t: Pair, *, upright: bool) -> None:
    """Multiply slopes by the strength and normalise, in place; where the strength is 1, nothing changes."""
    kept = strength == 1
    whole = [component.copy() for component in v] if kept.any() else []
    if upright:
        _make_upright(v, t)
    for component in v[:2]:
        np.multiply(component, strength, out=component)
    size = _length(v, t)
    for component in v:
        np.divide(component, size, out=component)
    for component, before in zip(v, whole, strict=False):
        np.copyto(component, before, where=kept)
