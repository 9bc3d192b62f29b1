"""Lists in sentences."""

from __future__ import annotations

from collections.abc import Iterable


def listed(names: Iterable[str], word: str = "or") -> str:
    """Join names with commas, and with ``word`` before the last.

    >>> listed(["PNG", "EXR", "TIFF"])
    'PNG, EXR or TIFF'
    """
    *first, last = names
    return f"{', '.join(first)} {word} {last}" if first else last
