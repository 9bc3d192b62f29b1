"""Ways to blend a detail normal with a base normal: one table of pure functions on (..., 3) arrays.

Formulas: C. Barre-Brisebois and S. Hill, "Blending in Detail" (2012); a is the base, b the detail.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32
from nmaptool.core.parallel import for_each_band

# detail that grazes or faces away is brought down to this slope where slopes are added or faded
_STEEPEST = 50.0
_SHORTEST = 1e-12
# chunks that stay in the cache
_VECTORS_AT_ONCE = 1 << 16
_CHUNKS_OF_A_BAND = 8
_Component = NDArray[np.float32]
_Triple = tuple[_Component, _Component, _Component]
_Pair = tuple[_Component, _Component]


@dataclass(frozen=True)
class Mode:
    """One way of blending.

    Attributes
    ----------
    kernel : callable
        (base, detail, result, two arrays to work in) of components; the result is of any length.
    fades : str
        What strength does: ``detail`` scales the detail's slopes; ``sum`` weighs the detail in the sum; ``result``
        mixes the outcome with the base.
    keeps_flat : bool
        A flat detail changes nothing.
    flat_base : bool
        On a flat base the detail comes out as it is.
    adds_slopes : bool
        The formula holds for slopes, so normals that face away must be brought to one first.
    """

    kernel: Callable[[_Triple, _Triple, _Triple, _Pair], None]
    fades: str
    keeps_flat: bool
    flat_base: bool
    adds_slopes: bool = False


# kernels write into ``o`` and leave a and b as they are; ``t`` is two arrays to work in


def _linear(a: _Triple, b: _Triple, o: _Triple, t: _Pair) -> None:
    for axis in range(3):
        np.add(a[axis], b[axis], out=o[axis])


def _overlay(a: _Triple, b: _Triple, o: _Triple, t: _Pair) -> None:
    for under, over, out in zip(a, b, o, strict=True):
        # of codes (n + 1)/2: 2ab below the middle, 1 - 2(1-a)(1-b) above it, brought back to -1..1
        np.multiply(np.add(1, under, out=out), np.add(1, over, out=t[0]), out=out)
        np.subtract(out, 1, out=out)
        light = np.multiply(np.subtract(1, under, out=t[0]), np.subtract(1, over, out=t[1]), out=t[0])
        np.copyto(out, np.subtract(1, light, out=light), where=under >= 0)


def _sum_of_products(a: _Component, b: _Component, c: _Component, d: _Component, o: _Component, t: _Pair) -> None:
    np.multiply(a, b, out=o)
    o += np.multiply(c, d, out=t[0])


def _pd(a: _Triple, b: _Triple, o: _Triple, t: _Pair) -> None:
    _sum_of_products(a[0], b[2], b[0], a[2], o[0], t)
    _sum_of_products(a[1], b[2], b[1], a[2], o[1], t)
    np.multiply(a[2], b[2], out=o[2])


def _whiteout(a: _Triple, b: _Triple, o: _Triple, t: _Pair) -> None:
    np.add(a[0], b[0], out=o[0])
    np.add(a[1], b[1], out=o[1])
    np.multiply(a[2], b[2], out=o[2])


def _udn(a: _Triple, b: _Triple, o: _Triple, t: _Pair) -> None:
    np.add(a[0], b[0], out=o[0])
    np.add(a[1], b[1], out=o[1])
    o[2][...] = a[2]


def _rnm(a: _Triple, b: _Triple, o: _Triple, t: _Pair) -> None:
    # the rotation that takes flat to the base, applied to the detail, as two mirrors; where the base faces straight
    # away there are many: half a turn about x, as `nmaptool.maps.detail` undoes it
    across, (towards, share) = o[2], t
    np.multiply(a[0], b[0], out=across)
    across += np.multiply(a[1], b[1], out=share)
    np.add(1, a[2], out=towards)
    away = towards < 1e-6
    any_away = away.any()
    np.multiply(towards, b[2], out=share)
    share -= across
    if any_away:
        towards[away] = 1
    share /= towards
    for axis in range(2):
        np.multiply(a[axis], share, out=o[axis])
        o[axis][...] += b[axis]
    np.subtract(np.multiply(a[2], b[2], out=share), across, out=across)
    if any_away:
        for out, detail, sign in zip(o, b, (1, -1, -1), strict=True):
            out[away] = sign * detail[away]


MODES = {
    "rnm": Mode(_rnm, "detail", keeps_flat=True, flat_base=True),
    "pd": Mode(_pd, "detail", keeps_flat=True, flat_base=True, adds_slopes=True),
    "whiteout": Mode(_whiteout, "detail", keeps_flat=True, flat_base=True, adds_slopes=True),
    "udn": Mode(_udn, "detail", keeps_flat=True, flat_base=False, adds_slopes=True),
    "linear": Mode(_linear, "sum", keeps_flat=False, flat_base=False),
    "overlay": Mode(_overlay, "result", keeps_flat=False, flat_base=False),
}


def blend(base: Float32, detail: Float32, mode: str = "rnm", strength: float | NDArray[Any] = 1.0) -> Float32:
    """Blend detail normals with base normals.

    Parameters
    ----------
    base, detail : (..., 3) float32
        Unit normals.
    mode : str
        A key of `MODES`: ``rnm`` rotates the detail with the base (undoes `nmaptool.maps.detail` ``rotation``), ``pd``
        adds slopes (undoes ``slope``; the sum of two surfaces is a surface), ``whiteout`` and ``udn`` are its cheaper
        neighbours, ``linear`` is the direction of the sum, ``overlay`` what image editors do to the codes.
    strength : float or (...) float
        0 leaves the base as it is, in every bit. In the first four modes it multiplies the detail's slopes; in
        ``linear`` it weighs the detail, in ``overlay`` it mixes the outcome with the base.

    Returns
    -------
    (..., 3) float32
        Unit normals. A flat detail changes nothing in the first four modes, and what lies on a flat base in rnm, pd
        and whiteout comes out as it went in, both in every bit.

    Raises
    ------
    ValueError
        If the mode is unknown, the shapes do not fit, or a strength is negative or not finite.
    """
    if mode not in MODES:
        raise ValueError(f"unknown mode {mode!r}: use one of {', '.join(MODES)}")
    if base.shape != detail.shape or base.shape[-1] != 3:
        raise ValueError(f"base {base.shape} and detail {detail.shape} must have one shape (..., 3)")
    weight = np.asarray(strength, np.float32)
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
            _blend_chunk(a[chunk], b[chunk], MODES[mode], weight if each is None else each[chunk], o[chunk], rows)

    for_each_band(len(a), _VECTORS_AT_ONCE * _CHUNKS_OF_A_BAND, part)
    return out


def _blend_chunk(
    base: Float32, detail: Float32, mode: Mode, strength: NDArray[Any], out: Float32, work: NDArray[np.float32]
) -> None:
    """Blend (N, 3) vectors into ``out``, with (11, N) to work in: taking memory anew costs more than the sums."""
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
    mode.kernel(a, b, o, t)
    size = _length(o, t)
    if mode.fades == "result" and not whole:
        for under, component in zip(a, o, strict=True):
            np.divide(component, size, out=component)
            np.subtract(component, under, out=component)
            np.multiply(component, strength, out=component)
            np.add(component, under, out=component)
        size = _length(o, t)
    for axis, component in enumerate(o):
        np.divide(component, size, out=out[:, axis])
    if flat_base is not None:  # what must come out as it went in
        _copy_where(flat_base & (strength == 1), detail, out)
    _copy_where(strength == 0, base, out)
    if flat_detail is not None:
        _copy_where(flat_detail, base, out)
    if size.min() <= _SHORTEST:  # opposite normals leave no direction
        _copy_where(size <= _SHORTEST, base, out)


def _copy_where(chosen: Any, vectors: Float32, out: Float32) -> None:
    if not np.any(chosen):
        return
    if np.all(chosen):
        out[...] = vectors
    else:
        out[chosen] = vectors[chosen]


def _flat(v: _Triple) -> NDArray[np.bool_]:
    flat: NDArray[np.bool_] = v[0] == 0
    if flat.any():
        flat &= v[1] == 0
        flat &= v[2] > 0
    return flat


def _length(v: _Triple, t: _Pair) -> _Component:
    """Lengths, in the first of ``t``, none less than the shortest."""
    size, square = t
    np.multiply(v[0], v[0], out=size)
    size += np.multiply(v[1], v[1], out=square)
    size += np.multiply(v[2], v[2], out=square)
    np.sqrt(size, out=size)
    if not size.min() > _SHORTEST:
        np.maximum(size, np.float32(_SHORTEST), out=size)
    return size


def _make_upright(v: _Triple, t: _Pair) -> None:
    """The same directions in the picture, no steeper than the steepest slope; steeper ones change length."""
    x, y, z = v
    least, limit = t
    np.multiply(x, x, out=least)
    least += np.multiply(y, y, out=limit)
    np.abs(z, out=limit)
    limit *= z
    limit *= np.float32(_STEEPEST**2 * 0.999)  # a little less: roots decide
    if (limit > least).all():
        return
    np.sqrt(least, out=least)
    least /= np.float32(_STEEPEST)
    np.maximum(least, z, out=z)
    z[z == 0] = 1


def _fade(v: _Triple, strength: NDArray[Any], t: _Pair, *, upright: bool) -> None:
    """Slopes times strength, unit length; where strength is 1, as they are."""
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
