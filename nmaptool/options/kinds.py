"""Kinds of options: the values each accepts, how text is parsed, and the one-line error for any other value.

The frozen options dataclasses name a kind for each field. The command line, recipes and the documentation use the
same kinds, so nothing about an option is written twice.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from nmaptool.core.errors import UsageError

LARGEST_WEIGHT = 1e6
_MANY = re.compile(r"\s*(\d{1,12}(?:\.\d{1,6})?)\s*([km]?)\s*", re.IGNORECASE)
_SIZE = re.compile(r"\s*(\d{1,7})\s*[x,×]\s*(\d{1,7})\s*", re.IGNORECASE)

# names, with descriptions if the help lists them; a callable if names may be added later
Choices = Mapping[str, str] | tuple[str, ...] | Callable[[], Mapping[str, str] | tuple[str, ...]]


@dataclass(frozen=True)
class Kind:
    """The values that an option accepts.

    Attributes
    ----------
    such_as : str
        An example, for messages.
    signed : bool
        Whether its text may begin with a minus sign.
    toml : type
        Its type in a recipe: float (any number), bool or str.
    """

    such_as: str = ""
    signed: ClassVar[bool] = False
    toml: ClassVar[type] = str

    def read(self, name: str, value: Any) -> Any:
        """Check the value of the field ``name``; text is parsed.

        Raises
        ------
        UsageError
            If the value is not accepted.
        """
        return value

    def meanings(self) -> str:
        """Descriptions of the accepted values, appended to the help text; empty if there is no table."""
        return ""


@dataclass(frozen=True)
class Text(Kind):
    """Any text; the options class parses it further if it has a syntax."""


@dataclass(frozen=True)
class SignedText(Text):
    """Text that may begin with a minus sign, such as numbers separated by commas."""

    signed: ClassVar[bool] = True


@dataclass(frozen=True)
class NumbersOr(SignedText):
    """One of a few names, or finite numbers separated by commas, such as 0,-9999; a plain number becomes text."""

    names: tuple[str, ...] = ()

    def read(self, name: str, value: Any) -> Any:
        """As `Kind.read`."""
        text = str(value)
        if text not in self.names and not all(map(_is_number, text.split(","))):
            accepted = f"{', '.join(self.names)} or numbers separated by commas, such as {self.such_as}"
            raise UsageError(f"`{name}={value!r}`: use {accepted}")
        return value if text == value else text


@dataclass(frozen=True)
class Switch(Kind):
    """On or off."""

    toml: ClassVar[type] = bool


@dataclass(frozen=True)
class Choice(Kind):
    """One of several names."""

    choices: Choices = ()

    @property
    def names(self) -> tuple[str, ...]:
        """The accepted names, including those added at run time."""
        return tuple(self._now())

    @property
    def descriptions(self) -> dict[str, str]:
        """The meaning of each name; empty if the table has no descriptions."""
        now = self._now()
        return dict(now) if isinstance(now, Mapping) else {}

    def meanings(self) -> str:
        """As `Kind.meanings`."""
        described = "; ".join(f'"{name}" {meaning}' for name, meaning in self.descriptions.items())
        return f"{described}." if described else ""

    def _now(self) -> Mapping[str, str] | tuple[str, ...]:
        return self.choices() if callable(self.choices) else self.choices

    def read(self, name: str, value: Any) -> Any:
        """As `Kind.read`."""
        if str(value) not in self.names:
            raise UsageError(f"`{name}={value!r}`: use one of {', '.join(self.names)}")
        return value


@dataclass(frozen=True)
class NameOrFile(Text):
    """One of several names with their meanings, or the name of a file with a given ending."""

    names: Mapping[str, str] = field(default_factory=dict)
    ending: str = ".svg"
    file: str = "an SVG file"

    def meanings(self) -> str:
        """As `Kind.meanings`."""
        described = "; ".join(f'"{name}" {meaning}' for name, meaning in self.names.items())
        return f"{described}."

    def is_file(self, value: str) -> bool:
        """Whether the value names a file."""
        return value.lower().endswith(self.ending)

    def read(self, name: str, value: Any) -> Any:
        """As `Kind.read`."""
        if value not in self.names and not self.is_file(value):
            raise UsageError(f"`{name}={value!r}`: use {', '.join(self.names)} or {self.file}, such as {self.such_as}")
        return value


@dataclass(frozen=True)
class Numeric(Kind):
    """A number of any kind."""

    signed: ClassVar[bool] = True
    toml: ClassVar[type] = float


@dataclass(frozen=True)
class Number(Numeric):
    """A finite number between two bounds, both included."""

    low: float = -math.inf
    high: float = math.inf

    def read(self, name: str, value: Any) -> Any:
        """As `Kind.read`."""
        require_number(name, value, self.low, self.high, self.such_as)
        return value


@dataclass(frozen=True)
class Weight(Numeric):
    """Zero or more, at most a million."""

    def read(self, name: str, value: Any) -> Any:
        """As `Kind.read`."""
        if not 0 <= value <= LARGEST_WEIGHT:
            raise UsageError(f"`{name}={value:g}`: must be zero or more, at most {LARGEST_WEIGHT:g}")
        return value


@dataclass(frozen=True)
class Positive(Numeric):
    """A finite number greater than zero, with an optional upper limit."""

    high: float = math.inf

    def read(self, name: str, value: Any) -> Any:
        """As `Kind.read`."""
        if not (0 < value <= self.high and math.isfinite(value)):
            example = f", such as {self.such_as}" if self.such_as else ""
            finite = "finite and " if value == math.inf == self.high else ""
            limit = f" and at most {self.high:g}" if self.high < math.inf else ""
            raise UsageError(f"`{name}={value:g}`: must be {finite}greater than zero{limit}{example}")
        return value


@dataclass(frozen=True)
class Count(Numeric):
    """A whole number between two bounds, both included."""

    low: int = 1
    high: int | None = None

    def read(self, name: str, value: Any) -> Any:
        """As `Kind.read`."""
        if self.high is None and value < self.low:
            raise UsageError(f"`{name}={value}`: must be at least {self.low}")
        if self.high is not None and not self.low <= value <= self.high:
            example = f", such as {self.such_as}" if self.such_as else ""
            raise UsageError(f"`{name}={value}`: must lie between {self.low} and {self.high}{example}")
        return value


@dataclass(frozen=True)
class ManyText(Text):
    """A large whole number as text, such as 200k or 1.5M; a plain number is converted to text."""

    low: int = 1

    def read(self, name: str, value: Any) -> Any:
        """As `Kind.read`."""
        text = str(value)
        if parse_many(name, text) < self.low:
            raise UsageError(f"`{name}={text!r}`: must be at least {self.low}, such as {self.such_as}")
        return text


@dataclass(frozen=True)
class CountsText(Text):
    """Numbers across and down, such as 3x4."""

    def read(self, name: str, value: Any) -> Any:
        """As `Kind.read`."""
        parse_counts(name, str(value))
        return str(value)


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def require_number(name: str, value: float, low: float, high: float, such_as: str) -> None:
    """Refuse anything but a finite number between two bounds, both included.

    Raises
    ------
    UsageError
    """
    if not (math.isfinite(value) and low <= value <= high):
        raise UsageError(f"`{name}={value:g}`: must lie between {low:g} and {high:g}, such as {such_as}")


def parse_many(name: str, text: str) -> int:
    """A whole number such as ``200000``, ``200k`` or ``1.5M``.

    >>> parse_many("triangles", "1.5M")
    1500000

    Raises
    ------
    UsageError
        If the text is not a whole number.
    """
    match = _MANY.fullmatch(text)
    count = float(match[1]) * {"": 1, "k": 1e3, "m": 1e6}[match[2].lower()] if match else 0.5
    if count != round(count):
        raise UsageError(f"`{name}={text!r}`: expected a whole number, such as 200k or 1500000")
    return round(count)


def parse_size(name: str, text: str) -> tuple[int, int]:
    """Columns and rows of a size such as ``1000x900``.

    Raises
    ------
    UsageError
        If the text is not a size.
    """
    match = _SIZE.fullmatch(text)
    cols, rows = (int(match.group(1)), int(match.group(2))) if match else (0, 0)
    if min(cols, rows) < 1:
        raise UsageError(f"`{name}={text!r}`: expected columns x rows in px, such as 1000x900")
    return cols, rows


def parse_counts(name: str, text: str) -> tuple[int, int]:
    """Numbers across and down, such as ``3x4``.

    Raises
    ------
    UsageError
        If the text is not two numbers of at least 1.
    """
    match = _SIZE.fullmatch(text)
    across, down = (int(match.group(1)), int(match.group(2))) if match else (0, 0)
    if min(across, down) < 1:
        raise UsageError(f"`{name}={text!r}`: expected numbers across x down, such as 3x4")
    return across, down
