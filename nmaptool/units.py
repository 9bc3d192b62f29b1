"""Lengths with their unit: ``12mm``, ``4px``, ``3%`` (of the longer side), also ``cm`` and ``in``."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from nmaptool.errors import UsageError

_MM_PER_UNIT = {"mm": 1.0, "cm": 10.0, "in": 25.4}
_SMALLEST, _LARGEST = 1e-6, 1e6
_PATTERN = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)\s*(mm|cm|in|px|%)\s*", re.IGNORECASE)


@dataclass(frozen=True)
class Length:
    """A length in millimetres, pixels or per cent of the longer side, between 1e-6 and 1e6.

    Parameters
    ----------
    value : float
        Between 1e-6 and 1e6.
    unit : str
        One of ``mm``, ``cm``, ``in``, ``px``, ``%``.

    Raises
    ------
    UsageError
        If the value is out of range or the unit is unknown.
    """

    value: float
    unit: str

    def __post_init__(self) -> None:
        if self.unit not in (*_MM_PER_UNIT, "px", "%"):
            raise UsageError(f"unknown unit {self.unit!r}: use mm, cm, in, px or %")
        if not (math.isfinite(self.value) and self.value > 0):
            raise UsageError(f"length {self}: must be greater than zero, such as 3mm")
        if not _SMALLEST <= self.value <= _LARGEST:
            raise UsageError(f"length {self}: must lie between {_SMALLEST:g} and {_LARGEST:g}, such as 3mm")

    def __str__(self) -> str:
        return f"{self.value:g}{self.unit}"

    def to_mm(self, pitch_mm: float, longer_side_px: int) -> float:
        """Length in mm on a grid of ``pitch_mm`` mm per px whose longer side has ``longer_side_px`` px.

        >>> Length(3.0, "%").to_mm(pitch_mm=0.1, longer_side_px=1000)
        3.0
        """
        if self.unit == "px":
            return self.value * pitch_mm
        if self.unit == "%":
            return self.value / 100 * longer_side_px * pitch_mm
        return self.value * _MM_PER_UNIT[self.unit]

    @property
    def is_absolute(self) -> bool:
        """Whether the length needs no picture to be known in mm."""
        return self.unit in _MM_PER_UNIT


def length(text: str) -> Length:
    """Read a length such as ``12mm``, ``4px``, ``3%``, ``1.5cm`` or ``2in``.

    Raises
    ------
    UsageError
        If the text is not a positive number with one of those units.

    Examples
    --------
    >>> length("12 mm")
    Length(value=12.0, unit='mm')
    """
    match = _PATTERN.fullmatch(text)
    if match is None:
        raise UsageError(f"length {text!r}: expected a number with a unit (mm, cm, in, px, %), such as 12mm or 3%")
    try:
        return Length(float(match.group(1)), match.group(2).lower())
    except UsageError as error:
        raise UsageError(f"length {text!r}: {str(error).partition(': ')[2]}") from None
