"""Places in a recipe, as messages name them: ``scene.toml, line 14: layer 2 (bunny)``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

# what leads to a value: ("layer", 1, "mode") is values["layer"][1]["mode"]
Keys: TypeAlias = tuple[str | int, ...]
# the line of what the keys lead to, or of the table around it
LineOf: TypeAlias = Callable[[Keys], int]


@dataclass(frozen=True)
class Place:
    """A table of a recipe.

    Parameters
    ----------
    recipe : str
        The recipe's name.
    line_of : callable, optional
        Gives the lines of keys.
    keys : tuple
        Those that lead here.
    title : str
        What to call it in messages, such as "layer 2 (bunny)"; "" is the whole recipe.
    """

    recipe: str
    line_of: LineOf | None = None
    keys: Keys = ()
    title: str = ""

    def to(self, *keys: str | int, title: str) -> Place:
        """A place in this table."""
        return replace(self, keys=(*self.keys, *keys), title=title)

    def named(self, *keys: str | int) -> str:
        """What to call this table in a message about it, or about the value of a key in it."""
        line = "" if self.line_of is None else f", line {self.line_of((*self.keys, *keys))}"
        return f"{self.recipe}{line}: {self.title}" if self.title else f"{self.recipe}{line}"
