"""Kinds of options for lengths, distances and scales, which parse text with a unit."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, TypeVar

from nmaptool.core.errors import UsageError
from nmaptool.core.units import Length, Offset, length, offset, offsets
from nmaptool.options.kinds import SignedText, require_number

_T = TypeVar("_T")
# width, its unit if it is not that of the height, and height; not the x of px
_SIDES = re.compile(r"\s*(\d[\d.]*)\s*([a-z]*)\s*[x×]\s*(\d.*)", re.IGNORECASE)
_UNIT_AT_END = re.compile(r"[\d.\s]+")
_SMALLEST_SCALE, _LARGEST_SCALE = 1e-3, 1e3


def _named(name: str, text: str, read: Callable[[str], _T]) -> _T:
    """Read the text of the option ``name``; errors name the option."""
    try:
        return read(text)
    except UsageError as error:
        raise UsageError(f"`{name}={text!r}`: {str(error).partition(': ')[2]}") from None


@dataclass(frozen=True)
class LengthText(SignedText):
    """A length such as 3mm, 4px or 2%; with ``absolute``, only mm, cm, m or in, because it sets a size."""

    such_as: str = "100mm"
    absolute: bool = False
    sets: str = "the size of a pixel"

    def read(self, name: str, value: Any) -> Any:
        """As `Kind.read`."""
        value = _named(name, value, length) if isinstance(value, str) else value
        if self.absolute and not value.is_absolute:
            raise UsageError(f"`{name}='{value}'`: sets {self.sets}; give it in mm, cm, m or in")
        return value


@dataclass(frozen=True)
class SidesText(SignedText):
    """A length for both sides, such as 400mm, or width and height, such as 600x400mm; a `Length` becomes text."""

    def read(self, name: str, value: Any) -> Any:
        """As `Kind.read`."""
        parse_sides(name, str(value))
        return str(value)


@dataclass(frozen=True)
class LengthOr(SignedText):
    """A height such as 2px, or one of a few names."""

    names: tuple[str, ...] = ()

    def read(self, name: str, value: Any) -> Any:
        """As `Kind.read`."""
        if not isinstance(value, str) or value in self.names:
            return value
        try:
            return length(value)
        except UsageError:
            accepted = f"{', '.join(self.names)} or a height, such as {self.such_as}"
            raise UsageError(f"`{name}={value!r}`: use {accepted}") from None


@dataclass(frozen=True)
class DegreesOrFocal(SignedText):
    """Degrees as a plain number, or a focal length in px, such as 525px."""

    def read(self, name: str, value: Any) -> Any:
        """As `Kind.read`."""
        if isinstance(value, str):
            try:
                value = float(value)
            except ValueError:
                accepted = "degrees, such as 35, or a focal length in px, such as 525px"
                try:
                    value = length(value)
                except UsageError:
                    raise UsageError(f"`{name}={value!r}`: use {accepted}") from None
        if isinstance(value, Length) and value.unit != "px":
            raise UsageError(
                f"`{name}='{value}'`: is not in px; give degrees, or the focal length in px, such as 525px"
            )
        return value


@dataclass(frozen=True)
class EdgesOrLength(SignedText):
    """A plain number, in mean edge lengths of the mesh, or a length such as 2% or 1.5mm."""

    low: float = 0.1
    high: float = 1000.0

    def read(self, name: str, value: Any) -> Any:
        """As `Kind.read`."""
        if isinstance(value, str):
            try:
                value = float(value)
            except ValueError:
                value = _named(name, value, length)
        if not isinstance(value, Length):
            require_number(name, value, self.low, self.high, self.such_as)
        elif value.unit == "px":
            example = "give edge lengths, mm or %, such as 3 or 2%"
            raise UsageError(f"`{name}='{value}'`: a mesh has no pixels; {example}")
        return value


@dataclass(frozen=True)
class OffsetText(SignedText):
    """A distance of zero or more, such as 6px."""

    such_as: str = "6px"

    def read(self, name: str, value: Any) -> Any:
        """As `Kind.read`."""
        if isinstance(value, str):
            value = _named(name, value, offset)
        if not isinstance(value, Offset):
            raise UsageError(f"`{name}={value!r}`: expected a distance, such as {self.such_as}")
        if value.value < 0:
            raise UsageError(f"`{name}='{value}'`: must be zero or more, such as {self.such_as}")
        return value


@dataclass(frozen=True)
class ScaleText(SignedText):
    """A factor, two factors (across, down), or a width such as 30mm; a plain number is converted to text."""

    such_as: str = "0.5"
    toml: ClassVar[type] = float

    def read(self, name: str, value: Any) -> Any:
        """As `Kind.read`."""
        text = value if isinstance(value, str) else f"{value:.12g}"
        parse_scale(text, name)
        return text


def parse_scale(text: str, name: str = "scale") -> tuple[float, float] | Length:
    """Read ``0.5``, ``0.5,0.7`` (across, down) or a width such as ``30mm``.

    Raises
    ------
    UsageError
        If the text is none of these, or a factor is out of range.
    """
    parts = text.split(",")
    try:
        factors = [float(part) for part in parts]
    except ValueError:
        if len(parts) == 1:
            try:
                return length(text)
            except UsageError:
                pass
        expected = "one factor, two separated by a comma, or a width such as 30mm"
        raise UsageError(f"`{name}={text!r}`: expected {expected}") from None
    if len(factors) > 2 or not all(_SMALLEST_SCALE <= f <= _LARGEST_SCALE for f in factors):
        expected = f"one or two factors between {_SMALLEST_SCALE:g} and {_LARGEST_SCALE:g}, such as 0.5"
        raise UsageError(f"`{name}={text!r}`: expected {expected}")
    return factors[0], factors[-1]


def parse_sides(name: str, text: str) -> tuple[float, float]:
    """Width and height in mm, from one length for both, such as ``400mm``, or two, such as ``600x400mm``.

    Raises
    ------
    UsageError
        If it is neither, or the unit is not mm, cm, m or in.
    """
    both = _SIDES.fullmatch(text)
    texts = (text,) if both is None else (both[1] + (both[2] or _UNIT_AT_END.split(both[3], maxsplit=1)[-1]), both[3])
    try:
        sides = [length(side) for side in texts]
    except UsageError:
        accepted = "a length, such as 400mm, or width and height, such as 600x400mm"
        raise UsageError(f"`{name}={text!r}`: expected {accepted}") from None
    for side in sides:
        if not side.is_absolute:
            raise UsageError(f"`{name}={text!r}`: sets the size of a part; give it in mm, cm, m or in, such as 400mm")
    return sides[0].to_mm(1.0, 1), sides[-1].to_mm(1.0, 1)


def parse_distances(name: str, text: str, counts: tuple[int, ...], such_as: str) -> tuple[Offset, ...]:
    """Read distances separated by commas; their number must be in ``counts``.

    Raises
    ------
    UsageError
        If their number is wrong, or one is not a distance.
    """
    try:
        return offsets(text, counts, such_as)
    except UsageError as error:
        raise UsageError(f"`{name}={text!r}`: {str(error).removeprefix(f'{text!r}: ')}") from None
