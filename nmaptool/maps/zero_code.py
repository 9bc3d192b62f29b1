"""The code that means zero: its choices, and how to detect it from a file's flat pixels."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Mask

ZERO_CODES = ("127", "127.5", "128")
# A flat code counts as the file's own zero only if it stands out as a spike: surfaces that merely pass through flat
# hold its three neighbours about as often.
_SPIKE = 4
_SPIKE_PIXELS = 64
_ROWS_AT_ONCE = 16


def zero_and_scale(zero_code: str, max_code: int) -> tuple[float, float]:
    """The code that means 0, and the codes per unit: n = (v - zero) / scale.

    Parameters
    ----------
    zero_code : str
        "127.5" (the middle), "128" (upper neighbour) or "127" (lower neighbour: a truncating writer), in 8-bit terms.
    max_code : int
        255 or 65535.

    Examples
    --------
    >>> zero_and_scale("128", 65535)
    (32768.0, 32767.0)
    """
    middle = max_code / 2
    if zero_code == "128":
        return middle + 0.5, middle - 0.5
    if zero_code == "127":
        return middle - 0.5, middle
    return middle, middle


def flat_codes(max_code: int) -> dict[str, tuple[int, int, int]]:
    """Codes that programs write for the flat normal, by the zero code that they imply."""
    middle = (max_code + 1) // 2
    return {"128": (middle, middle, max_code), "127": (middle - 1, middle - 1, max_code)}


def detect_zero_code(rgb: NDArray[Any]) -> str | None:
    """Detect the zero code from the exact flat code; None if no flat code stands out.

    Parameters
    ----------
    rgb : (H, W, 3) uint8 or uint16

    Returns
    -------
    "128", "127" or None
    """
    max_code = int(np.iinfo(rgb.dtype).max)
    middle = (max_code + 1) // 2
    counts = np.zeros(4, np.int64)
    for row in range(0, len(rgb), _ROWS_AT_ONCE):
        x, y, z = np.moveaxis(rgb[row : row + _ROWS_AT_ONCE], -1, 0)
        facing = z >= max_code - 1  # a program that truncates writes 254 or 255 for nz = 1
        upper_y, lower_y = facing & (y == middle), facing & (y == middle - 1)
        upper_x, lower_x = x == middle, x == middle - 1
        counts += [np.count_nonzero(one & other) for one in (lower_x, upper_x) for other in (lower_y, upper_y)]
    order = np.sort(counts)
    if order[-1] < _SPIKE_PIXELS or order[-1] < _SPIKE * order[-2]:
        return None
    winner = int(np.argmax(counts))
    return {3: "128", 0: "127"}.get(winner)


def has_color(pixels: NDArray[Any], color: tuple[int, int, int]) -> Mask:
    """(...) bool: where (..., 3 or more) integer codes are exactly ``color``."""
    x, y, z = (pixels[..., channel] == code for channel, code in enumerate(color))
    return np.asarray(x & y & z)
