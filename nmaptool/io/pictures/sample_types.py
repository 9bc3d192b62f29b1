"""The numbers that files store, as the pixels of a picture: 8- and 16-bit codes, and float32 for everything else."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.errors import InputError

_ROWS_AT_ONCE = 256


class Pixels(NamedTuple):
    """Pixels of a type that `nmaptool.RasterImage` holds.

    Attributes
    ----------
    values : (H, W, C) uint8, uint16 or float32
    bits : int
        8, 16 or 32; 16 with float32 for half floats, 32 for integers that became floats.
    notes : tuple of str
        What a user should know about the numbers.
    """

    values: NDArray[Any]
    bits: int
    notes: tuple[str, ...] = ()


def as_pixels(name: str, values: NDArray[Any]) -> Pixels:
    """Convert stored numbers to pixels without changing a value, or say which cannot be exact.

    Booleans become the codes 0 and 255. Signed, 32- and 64-bit integers become float32 with the same values.

    Raises
    ------
    InputError
        If they are complex, text or other things.
    """
    kind, size = values.dtype.kind, values.dtype.itemsize
    if kind == "b":
        return Pixels(values.astype(np.uint8) * np.uint8(255), 8)
    if kind == "u" and size <= 2:
        return Pixels(_native(values), 8 * size)
    refuse_kind(name, values.dtype)
    with np.errstate(over="ignore", invalid="ignore"):  # beyond the range is infinity: "nothing" in depth pictures
        floats = _native(values.astype(np.float32, copy=False))
    if kind == "f":
        return Pixels(floats, 16 if size == 2 else 32)
    stated = f"stores {8 * size}-bit {'signed' if kind == 'i' else 'unsigned'} integers"
    exact = all(
        _is_exact(floats[row : row + _ROWS_AT_ONCE], values[row : row + _ROWS_AT_ONCE])
        for row in range(0, len(values), _ROWS_AT_ONCE)
    )
    rounding = "" if exact else "; those beyond 16777216 are rounded to floats"
    return Pixels(floats, 32, (f"{stated}, read as numbers{rounding}",))


def _native(values: NDArray[Any]) -> NDArray[Any]:
    """The same numbers in the byte order of this machine, without a mark of it that other libraries do not expect."""
    native = values.dtype.newbyteorder("=")
    return values.astype(native, copy=False).view(native)


def refuse_kind(name: str, kind: np.dtype[Any]) -> None:
    """Refuse what is not a number.

    Raises
    ------
    InputError
    """
    if kind.kind == "c":
        raise InputError(f"{name}: stores complex numbers; save their real part or their magnitude")
    if kind.kind not in "biuf":
        raise InputError(f"{name}: stores {kind} values; save plain integers or floats")


def _is_exact(floats: NDArray[np.float32], values: NDArray[Any]) -> bool:
    """Whether floats are the same numbers as integers."""
    span = np.iinfo(values.dtype)
    wide = floats.astype(np.float64)
    # the largest integer of 32 or 64 bits, as a float, is one more
    return bool((wide < float(span.max) + (span.bits < 54)).all()) and np.array_equal(wide.astype(values.dtype), values)
