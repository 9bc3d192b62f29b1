"""Lists as a sentence has them."""

from __future__ import annotations

from collections.abc import Iterable


def listed(names: Iterable[str], word: str = "or") -> str:
    """Names with commas and a word before the last.

    >>> listed(["PNG", "EXR", "TIFF"])
    'PNG, EXR or TIFF'
    """
    *first, last = names
    return f"{', '.join(first)} {word} {last}" if first else last
