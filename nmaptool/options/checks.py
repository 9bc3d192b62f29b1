"""What options of every kind are checked for.

Nothing heavy is imported here, so that ``nmap --help`` stays quick.
"""

from __future__ import annotations

import math

from nmaptool.errors import UsageError

LARGEST_WEIGHT = 1e6


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
