"""Kernels of `nmaptool.options.BLEND_MODES`, which blend detail normals with base normals, as component arrays.

Formulas: C. Barre-Brisebois and S. Hill, "Blending in Detail" (2012); a is the base, b the detail. Kernels write to
``o`` and do not change a and b; ``t`` is two work arrays.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Component = NDArray[np.float32]
Triple = tuple[Component, Component, Component]
Pair = tuple[Component, Component]


def linear(a: Triple, b: Triple, o: Triple, t: Pair) -> None:
    """Direction of the sum."""
    for axis in range(3):
        np.add(a[axis], b[axis], out=o[axis])


def overlay(a: Triple, b: Triple, o: Triple, t: Pair) -> None:
    """Overlay of the codes (n + 1)/2, as in image editors."""
    for under, over, out in zip(a, b, o, strict=True):
        # on the codes: 2ab below the middle, 1 - 2(1-a)(1-b) above it, mapped back to -1..1
        np.multiply(np.add(1, under, out=out), np.add(1, over, out=t[0]), out=out)
        np.subtract(out, 1, out=out)
        light = np.multiply(np.subtract(1, under, out=t[0]), np.subtract(1, over, out=t[1]), out=t[0])
        np.copyto(out, np.subtract(1, light, out=light), where=under >= 0)


def _sum_of_products(a: Component, b: Component, c: Component, d: Component, o: Component, t: Pair) -> None:
    np.multiply(a, b, out=o)
    o += np.multiply(c, d, out=t[0])


def partial_derivative(a: Triple, b: Triple, o: Triple, t: Pair) -> None:
    """Sum of the slopes."""
    _sum_of_products(a[0], b[2], b[0], a[2], o[0], t)
    _sum_of_products(a[1], b[2], b[1], a[2], o[1], t)
    np.multiply(a[2], b[2], out=o[2])


def whiteout(a: Triple, b: Triple, o: Triple, t: Pair) -> None:
    """Sum of x and y, product of z."""
    np.add(a[0], b[0], out=o[0])
    np.add(a[1], b[1], out=o[1])
    np.multiply(a[2], b[2], out=o[2])


def udn(a: Triple, b: Triple, o: Triple, t: Pair) -> None:
    """Sum of x and y, z of the base."""
    np.add(a[0], b[0], out=o[0])
    np.add(a[1], b[1], out=o[1])
    o[2][...] = a[2]


def reoriented(a: Triple, b: Triple, o: Triple, t: Pair) -> None:
    """The rotation that takes flat to the base, applied to the detail."""
    # computed as two reflections; where the base faces straight away, the rotation is ambiguous: this uses half a turn
    # about x, which `nmaptool.maps.detail` inverts
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
