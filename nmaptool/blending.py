"""Ways to blend a detail normal with a base normal: one table of pure functions on (..., 3) arrays.

Formulas: C. Barre-Brisebois and S. Hill, "Blending in Detail" (2012); a is the base, b the detail.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.arrays import Float32
from nmaptool.bands import each_band

# detail that grazes or faces away is brought down to this slope where slopes are added or faded
_STEEPEST = 50.0
_SHORTEST = 1e-12
# chunks that stay in the cache
_VECTORS_AT_ONCE = 1 << 14
_Component = NDArray[np.float32]
_Triple = tuple[_Component, _Component, _Component]


@dataclass(frozen=True)
class Mode:
    """One way of blending.

    Attributes
    ----------
    kernel : callable
        (base, detail) as triples of components to a triple of any length.
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

    kernel: Callable[[_Triple, _Triple], _Triple]
    fades: str
    keeps_flat: bool
    flat_base: bool
    adds_slopes: bool = False


def _linear(a: _Triple, b: _Triple) -> _Triple:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _overlay(a: _Triple, b: _Triple) -> _Triple:
    def channel(under: _Component, over: _Component) -> _Component:
        # of codes (n + 1)/2: 2ab below the middle, 1 - 2(1-a)(1-b) above it, brought back to -1..1
        dark, light = (1 + under) * (1 + over) - 1, 1 - (1 - under) * (1 - over)
        return np.where(under < 0, dark, light)

    return channel(a[0], b[0]), channel(a[1], b[1]), channel(a[2], b[2])


def _pd(a: _Triple, b: _Triple) -> _Triple:
    return a[0] * b[2] + b[0] * a[2], a[1] * b[2] + b[1] * a[2], a[2] * b[2]


def _whiteout(a: _Triple, b: _Triple) -> _Triple:
    return a[0] + b[0], a[1] + b[1], a[2] * b[2]


def _udn(a: _Triple, b: _Triple) -> _Triple:
    return a[0] + b[0], a[1] + b[1], a[2]


def _rnm(a: _Triple, b: _Triple) -> _Triple:
    # the rotation that takes flat to the base, applied to the detail, as two mirrors; where the base faces straight
    # away there are many: half a turn about x, as `nmaptool.detail` undoes it
    towards = 1 + a[2]
    away = towards < 1e-6
    across = a[0] * b[0] + a[1] * b[1]
    any_away = away.any()
    share = (towards * b[2] - across) / (np.where(away, 1, towards) if any_away else towards)
    x, y, z = a[0] * share + b[0], a[1] * share + b[1], a[2] * b[2] - across
    if any_away:
        x, y, z = np.where(away, b[0], x), np.where(away, -b[1], y), np.where(away, -b[2], z)
    return x, y, z


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
        A key of `MODES`: ``rnm`` rotates the detail with the base (undoes `nmaptool.detail` ``rotation``), ``pd`` adds
        slopes (undoes ``slope``; the sum of two surfaces is a surface), ``whiteout`` and ``udn`` are its cheaper
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

    def part(chunk: slice) -> None:
        _blend_chunk(a[chunk], b[chunk], MODES[mode], weight if each is None else each[chunk], o[chunk])

    each_band(len(a), _VECTORS_AT_ONCE, part)
    return out


def _blend_chunk(base: Float32, detail: Float32, mode: Mode, strength: NDArray[Any], out: Float32) -> None:
    """Blend (N, 3) vectors into ``out``."""
    a, b = under, over = _components(base), _components(detail)
    whole = strength.ndim == 0 and float(strength) == 1
    if mode.adds_slopes:
        a, b = _upright(a), _upright(b)
    if mode.fades == "detail" and not whole:
        b = _faded(b, strength, not mode.adds_slopes)
    elif mode.fades == "sum" and not whole:
        b = b[0] * strength, b[1] * strength, b[2] * strength
    x, y, z = mode.kernel(a, b)
    if mode.fades == "result" and not whole:
        size = _length(x, y, z)
        x, y, z = (first + strength * (c / size - first) for first, c in zip(a, (x, y, z), strict=True))
    size = _length(x, y, z)
    for axis, component in enumerate((x, y, z)):
        np.divide(component, size, out=out[:, axis])
    if mode.flat_base:  # what must come out as it went in
        _copy_where(_flat(under) & (strength == 1), detail, out)
    _copy_where(strength == 0, base, out)
    if mode.keeps_flat:
        _copy_where(_flat(over), base, out)
    _copy_where(size <= _SHORTEST, base, out)  # opposite normals leave no direction


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


def _components(vectors: Float32) -> _Triple:
    return vectors[:, 0].copy(), vectors[:, 1].copy(), vectors[:, 2].copy()


def _length(x: _Component, y: _Component, z: _Component) -> _Component:
    size: _Component = x * x
    square = y * y
    size += square
    size += np.multiply(z, z, out=square)
    np.sqrt(size, out=size)
    return np.maximum(size, np.float32(_SHORTEST), out=size)


def _upright(v: _Triple) -> _Triple:
    """The same directions in the picture, no steeper than the steepest slope; steeper ones change length."""
    x, y, z = v
    least = np.sqrt(x * x + y * y)
    least /= np.float32(_STEEPEST)
    np.maximum(least, z, out=least)
    least[least == 0] = 1
    return x, y, least


def _faded(v: _Triple, strength: NDArray[Any], upright: bool) -> _Triple:
    """Slopes times strength, unit length; where strength is 1, as they are."""
    x, y, z = _upright(v) if upright else v
    x, y = x * strength, y * strength
    size = _length(x, y, z)
    x, y, z = x / size, y / size, z / size
    kept = strength == 1
    if kept.any():
        x, y, z = (np.where(kept, whole, part) for whole, part in zip(v, (x, y, z), strict=True))
    return x, y, z
