"""What options of every kind are checked for.

Nothing heavy is imported here, so that ``nmap --help`` stays quick.
"""

from __future__ import annotations

import math
import re

from nmaptool.core.errors import UsageError
from nmaptool.core.units import Length

LARGEST_WEIGHT = 1e6
_SIZE = re.compile(r"\s*(\d{1,7})\s*[x,×]\s*(\d{1,7})\s*", re.IGNORECASE)


def require_at_least_zero(**values: float) -> None:
    """Weights, by name."""
    for name, value in values.items():
        if not 0 <= value <= LARGEST_WEIGHT:
            raise UsageError(f"--{name} {value:g}: must be zero or more, at most {LARGEST_WEIGHT:g}")


def require_choices(*choices: tuple[str, str, tuple[str, ...]]) -> None:
    """Words, as (name, value, accepted words)."""
    for name, value, accepted in choices:
        if value not in accepted:
            raise UsageError(f"--{name} {value!r}: use one of {', '.join(accepted)}")


def require_number(name: str, value: float, low: float, high: float, such_as: str) -> None:
    """A finite number between two bounds, both included."""
    if not (math.isfinite(value) and low <= value <= high):
        raise UsageError(f"--{name} {value:g}: must lie between {low:g} and {high:g}, such as {such_as}")


def require_absolute(**lengths: Length | None) -> None:
    """Lengths in mm, cm or in, by name; None is none."""
    for name, value in lengths.items():
        if value is not None and not value.is_absolute:
            raise UsageError(f"--{name} {value}: the size of a pixel follows from it, so give it in mm, cm or in")


def parse_size(name: str, text: str) -> tuple[int, int]:
    """Columns and rows of a size such as ``1000x900``."""
    match = _SIZE.fullmatch(text)
    cols, rows = (int(match.group(1)), int(match.group(2))) if match else (0, 0)
    if min(cols, rows) < 1:
        raise UsageError(f"--{name} {text!r}: expected columns x rows in px, such as 1000x900")
    return cols, rows
