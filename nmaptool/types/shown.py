"""How values are displayed: one line in print and repr, a small picture in a notebook."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

Painter = Callable[[object], bytes]


class OneLine:
    """A value whose repr is one line, with arrays given by type and shape.

    Dataclasses that inherit from it are declared with ``repr=False``. Classes override ``_line`` for a better summary.
    """

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {' '.join(self._line().split())}>"

    def _line(self) -> str:
        fields = dataclasses.fields(self)  # type: ignore[arg-type]  # mixed into dataclasses only
        return ", ".join(f"{f.name}={_brief(getattr(self, f.name))}" for f in fields)


class Pictured(OneLine):
    """A value that a notebook shows as a picture."""

    def _repr_png_(self) -> bytes:
        """PNG of at most 512 px, which notebooks look for by this name."""
        return _painters[0](self)


_painters: list[Painter] = []


def set_painter(painter: Painter) -> None:
    """Set the function that draws `Pictured` values; the package does this once, on import (decision 0019)."""
    _painters[:] = [painter]


def _brief(value: Any) -> str:
    if getattr(value, "shape", ()):
        return f"{value.dtype} {value.shape}"
    if isinstance(value, str) or value is None:
        return repr(value)
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, tuple | list | Mapping):
        return f"{len(value)} {'entry' if len(value) == 1 else 'entries'}"
    return type(value).__name__ if dataclasses.is_dataclass(value) else str(value)


def counted(number: int, what: str) -> str:
    """A number and a noun, such as "1 layer" or "12 layers".

    >>> counted(1, "face"), counted(1200, "face")
    ('1 face', '1200 faces')
    """
    plural = "vertices" if what == "vertex" else f"{what[:-1]}ies" if what.endswith("body") else f"{what}s"
    plural = f"{what}es" if what.endswith("mesh") else plural
    return f"{number} {what if number == 1 else plural}"
