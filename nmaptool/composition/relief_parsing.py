"""Parse the table ``[relief]`` of a recipe alone, such as a preset."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nmaptool.composition.recipe_parsing import relief_of
from nmaptool.composition.recipe_places import LineOf, Place
from nmaptool.composition.recipe_values import known_keys
from nmaptool.types.recipe import RecipeRelief


def parse_relief(values: Mapping[str, Any], *, name: str = "preset", line_of: LineOf | None = None) -> RecipeRelief:
    """Make the relief of a recipe that has a table ``[relief]`` and nothing else.

    Parameters and errors are those of `parse_recipe`.
    """
    top = Place(name, line_of)
    known = known_keys(values, ("relief",), top)
    return relief_of(known.get("relief", {}), top.to("relief", title="relief"))
