"""Write recipes as TOML."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import Any

from nmaptool.composition.plate_parsing import tables_of
from nmaptool.composition.recipe_values import number_text
from nmaptool.core.errors import InputError
from nmaptool.core.units import Length, Offset
from nmaptool.options import CanvasOptions, GroupOptions, LayerOptions, ReliefFiles
from nmaptool.types.recipe import Entry, Recipe, RecipeGroup, RecipeLayer, RecipeLink, RecipeRelief

_SHORT = {"\b": "\\b", "\t": "\\t", "\n": "\\n", "\f": "\\f", "\r": "\\r", '"': '\\"', "\\": "\\\\"}


def to_toml(recipe: Recipe) -> str:
    """Write a recipe as TOML text; default values are omitted.

    Parameters
    ----------
    recipe : Recipe

    Returns
    -------
    str
        TOML text; ``tomllib`` and `nmaptool.parse_recipe` turn it back into an equal recipe.

    Raises
    ------
    InputError
        If a file name is not valid UTF-8, as TOML requires.

    Examples
    --------
    >>> recipe = nm.parse_recipe({"layer": [{"file": "plate.png"}]})
    >>> print(nm.to_toml(recipe))
    [[layer]]
    file = "plate.png"
    <BLANKLINE>
    """
    lines = list(_pairs(_given(recipe.canvas, CanvasOptions())))
    if lines:
        lines = ["[canvas]", *lines, ""]
    if recipe.relief is not None:
        lines += [*_relief(recipe.relief), ""]
    if recipe.plate is not None:
        for heading, values in tables_of(recipe.plate):
            lines += [heading, *_pairs({key: value for key, value in values.items() if value is not None}), ""]
    for layer in recipe.layers:
        lines += _entry(layer, "layer")
    return "\n".join(lines)


def relief_to_toml(relief: RecipeRelief) -> str:
    """Write the table ``[relief]`` of a recipe alone; errors as for `to_toml`."""
    return "\n".join([*_relief(relief), ""])


def _relief(relief: RecipeRelief) -> Iterator[str]:
    yield "[relief]"
    yield from _pairs({**_given(relief.files, ReliefFiles()), **relief.options, **relief.solid})


def _entry(layer: Entry, path: str) -> Iterator[str]:
    yield f"[[{path}]]"
    if isinstance(layer, RecipeLayer):
        values: dict[str, Any] = {"file": layer.file, **_given(layer.options, LayerOptions())}
    elif isinstance(layer, RecipeLink):
        values = {"recipe": layer.recipe, **_given(layer.options, GroupOptions(name=layer.recipe))}
    else:
        values = _given(layer.options, GroupOptions())
    if layer.mask is not None:
        values["mask"] = layer.mask
    if layer.hidden:
        values["hidden"] = True
    yield from _pairs(values)
    if isinstance(layer, RecipeLayer) and layer.read:
        yield f"[{path}.read]"
        yield from _pairs({key: value for key, value in layer.read.items() if value is not None})
    yield ""
    if isinstance(layer, RecipeGroup):
        for inner in layer.layers:
            yield from _entry(inner, f"{path}.layer")


def _given(options: Any, default: Any) -> dict[str, Any]:
    """Return the fields that differ from the default."""
    values = {f.name: getattr(options, f.name) for f in fields(options)}
    return {key: value for key, value in values.items() if value != getattr(default, key)}


def _pairs(values: Mapping[str, Any]) -> Iterator[str]:
    for key, value in values.items():
        yield f"{key} = {_value(key, value)}"


def _value(key: str, value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return number_text(float(value))
    if isinstance(value, Length | Offset):  # their own text is rounded for display
        return _text(f"{number_text(value.value)}{value.unit}")
    if key == "scale" and _is_number(value):
        return str(value)
    return _text(value)


def _is_number(text: str) -> bool:
    """Whether the text is exactly how its number would be written."""
    try:
        return number_text(float(text)) == text
    except ValueError:
        return False


def _text(value: str) -> str:
    """Return a TOML basic string."""
    try:
        value.encode()
    except UnicodeEncodeError:
        shown = value.encode("utf-8", "replace").decode()
        raise InputError(f"{shown}: the file name is not valid UTF-8; rename the file") from None
    return '"' + "".join(_SHORT.get(c) or (c if c.isprintable() else _escaped(c)) for c in value) + '"'


def _escaped(character: str) -> str:
    code = ord(character)
    return f"\\u{code:04X}" if code < 0x10000 else f"\\U{code:08X}"
