"""Places in a recipe, as in messages: ``scene.toml, line 14: layer 2 (bunny)``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

# the path to a value: ("layer", 1, "mode") is values["layer"][1]["mode"]
Keys: TypeAlias = tuple[str | int, ...]
# returns the line of the value at the keys, or of the table around it
LineOf: TypeAlias = Callable[[Keys], int]


@dataclass(frozen=True)
class Place:
    """A table of a recipe.

    Parameters
    ----------
    recipe : str
        Name of the recipe.
    line_of : callable, optional
        Returns the line of a key.
    keys : tuple
        Path to the table.
    title : str
        Its name for messages, such as "layer 2 (bunny)"; empty for the whole recipe.
    """

    recipe: str
    line_of: LineOf | None = None
    keys: Keys = ()
    title: str = ""

    def to(self, *keys: str | int, title: str) -> Place:
        """Return a place in this table."""
        return replace(self, keys=(*self.keys, *keys), title=title)

    def named(self, *keys: str | int) -> str:
        """Return the start of a message about this table, or about the value of a key in it."""
        line = "" if self.line_of is None else f", line {self.line_of((*self.keys, *keys))}"
        return f"{self.recipe}{line}: {self.title}" if self.title else f"{self.recipe}{line}"
