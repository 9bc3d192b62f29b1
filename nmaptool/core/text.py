"""Lists and numbers in sentences."""

from __future__ import annotations

from collections.abc import Iterable


def listed(names: Iterable[str], word: str = "or") -> str:
    """Join names with commas, and with ``word`` before the last.

    >>> listed(["PNG", "EXR", "TIFF"])
    'PNG, EXR or TIFF'
    """
    *first, last = names
    return f"{', '.join(first)} {word} {last}" if first else last


def in_short(value: float) -> str:
    """A number of three digits without an exponent, unless it is very large or small.

    >>> in_short(5999.7), in_short(0.09934), in_short(1.5)
    ('6000', '0.0993', '1.5')
    """
    return f"{float(f'{value:.3g}'):.9g}"
