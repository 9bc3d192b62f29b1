"""Lengths with a unit (mm, cm, m, in, px, or % of the longer side), distances along one side, amounts of memory."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from nmaptool.core.errors import UsageError

_MM_PER_UNIT = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}
_BYTES_PER_UNIT = {
    "b": 1,
    **{f"{letter}b": 1000**power for power, letter in enumerate("kmgt", 1)},
    **{f"{letter}ib": 1024**power for power, letter in enumerate("kmgt", 1)},
}
_SMALLEST, _LARGEST = 1e-6, 1e6
# other ways to write units
_SAME_UNIT = {"inch": "in", '"': "in", "\u2033": "in"}
_UNITS = "|".join(("mm", "cm", "m", *_SAME_UNIT, "in", "px", "%"))
_PATTERN = re.compile(rf"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)\s*({_UNITS})\s*", re.IGNORECASE)
_MEMORY = re.compile(r"\s*(\d+\.?\d*|\.\d+)\s*([kmgt]?i?b)\s*", re.IGNORECASE)


@dataclass(frozen=True)
class _Measure:
    """A number with a unit, both checked."""

    value: float
    unit: str

    def __post_init__(self) -> None:
        if self.unit not in (*_MM_PER_UNIT, "px", "%"):
            raise UsageError(f"unknown unit {self.unit!r}: use mm, cm, m, in, px or %")
        self._check_value()

    def _check_value(self) -> None:
        """Refuse a value out of range."""

    def __str__(self) -> str:
        return f"{self.value:.12g}{self.unit}"

    @property
    def is_absolute(self) -> bool:
        """Whether the unit is mm, cm, m or in: needs no picture to convert to mm, but the pitch to convert to px."""
        return self.unit in _MM_PER_UNIT


@dataclass(frozen=True)
class Length(_Measure):
    """A length in millimetres, pixels or per cent of the longer side, between 1e-6 and 1e6.

    Parameters
    ----------
    value : float
        Between 1e-6 and 1e6.
    unit : str
        One of ``mm``, ``cm``, ``m``, ``in``, ``px``, ``%``.

    Raises
    ------
    UsageError
        If the value is out of range or the unit is unknown.
    """

    def _check_value(self) -> None:
        if not (math.isfinite(self.value) and self.value > 0):
            raise UsageError(f"length {self}: must be greater than zero, such as 3mm")
        if not _SMALLEST <= self.value <= _LARGEST:
            raise UsageError(f"length {self}: must lie between {_SMALLEST:g} and {_LARGEST:g}, such as 3mm")

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


def _unit(written: str) -> str:
    unit = written.lower()
    return _SAME_UNIT.get(unit, unit)


def length(text: str) -> Length:
    """Read a length such as ``12mm``, ``4px``, ``3%``, ``1.5cm`` or ``2in``.

    Parameters
    ----------
    text : str
        A positive number and one of mm, cm, m, in (or inch, or a double prime), px, % (of the longer side).

    Returns
    -------
    Length

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
        raise UsageError(f"length {text!r}: expected a number with a unit (mm, cm, m, in, px, %), such as 12mm or 3%")
    try:
        return Length(float(match.group(1)), _unit(match.group(2)))
    except UsageError as error:
        raise UsageError(f"length {text!r}: {str(error).partition(': ')[2]}") from None


@dataclass(frozen=True)
class Offset(_Measure):
    """A distance along one side of a picture, of either sign or zero, such as the position of a layer.

    Parameters
    ----------
    value : float
        Between -1e6 and 1e6.
    unit : str
        One of ``mm``, ``cm``, ``m``, ``in``, ``px``, ``%`` (of that side).

    Raises
    ------
    UsageError
        If the value is out of range or the unit is unknown.
    """

    def _check_value(self) -> None:
        if not abs(self.value) <= _LARGEST:
            raise UsageError(f"distance {self}: must be a number of at most {_LARGEST:g}, such as 12mm")

    def to_px(self, pitch_mm: float | None, side_px: int) -> float:
        """Distance in px along a side of ``side_px`` px.

        Raises
        ------
        UsageError
            If it is in mm, cm, m or in and the pitch is not known.

        Examples
        --------
        >>> Offset(-25, "%").to_px(None, 800)
        -200.0
        """
        if self.unit == "px":
            return self.value
        if self.unit == "%":
            return self.value / 100 * side_px
        if pitch_mm is None:
            raise UsageError(f"{self}: the size of a pixel is not known; give `width='100mm'`, or use px or %")
        return self.value * _MM_PER_UNIT[self.unit] / pitch_mm


def offset(text: str) -> Offset:
    """Read a distance such as ``12mm``, ``-4px``, ``50%`` or ``0``.

    Raises
    ------
    UsageError
        If the text is not a number with one of those units; 0 needs none.
    """
    match = _PATTERN.fullmatch(text)
    if match is None and text.strip() in ("0", "0.0"):
        return Offset(0.0, "px")
    if match is None:
        raise UsageError(
            f"distance {text!r}: expected a number with a unit (mm, cm, m, in, px, %), such as 12mm or -4px"
        )
    return Offset(float(match.group(1)), _unit(match.group(2)))


def offsets(text: str, counts: tuple[int, ...], such_as: str) -> tuple[Offset, ...]:
    """Read distances separated by commas, such as ``30%,12mm``.

    Raises
    ------
    UsageError
        If their number is not in ``counts``, or one is not a distance.
    """
    parts = text.split(",")
    if len(parts) not in counts:
        raise UsageError(
            f"{text!r}: expected {' or '.join(map(str, counts))} distances separated by commas, such as {such_as}"
        )
    return tuple(offset(part) for part in parts)


def memory(text: str) -> int:
    """Read an amount of memory, in bytes, such as ``8GB``, ``500MB`` or ``12GiB``.

    Raises
    ------
    UsageError
        If the text is not a number greater than zero with one of B, kB, MB, GB, TB, KiB, MiB, GiB, TiB.

    Examples
    --------
    >>> memory("1.5 GB"), memory("2GiB")
    (1500000000, 2147483648)
    """
    match = _MEMORY.fullmatch(text)
    unit = None if match is None else _BYTES_PER_UNIT.get(match.group(2).lower())
    if match is None or unit is None:
        raise UsageError(f"memory {text!r}: expected a number with a unit (MB, GB, MiB, GiB), such as 8GB")
    amount = float(match.group(1)) * unit
    if not 1 <= amount < 2**63:
        raise UsageError(f"memory {text!r}: must be at least one byte and less than 8 EiB, such as 8GB")
    return int(amount)


def memory_text(amount: int) -> str:
    """An amount of memory as text.

    >>> memory_text(15_260_000_000), memory_text(420_000_000)
    ('15.3GB', '420MB')
    """
    return f"{amount / 1e9:.1f}GB" if amount >= 1e9 else f"{amount / 1e6:.0f}MB"
