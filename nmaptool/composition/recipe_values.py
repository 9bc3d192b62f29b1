"""Check the values of a recipe against the kinds of their options; messages name key, place and what was found."""

from __future__ import annotations

import difflib
import json
from collections.abc import Iterable, Mapping
from dataclasses import fields
from typing import Any

from nmaptool.composition.recipe_places import Place
from nmaptool.core.errors import InputError, UsageError
from nmaptool.core.mentions import rendered, written_name
from nmaptool.options import CanvasOptions, LayerOptions, ReadOptions, ReliefFiles, ReliefOptions, SolidOptions
from nmaptool.options.fields import Options, kind_of
from nmaptool.options.kinds import Count, Kind, Switch, Text
from nmaptool.options.length_kinds import ScaleText

# kinds of the keys that are not options
_FILE_KINDS: dict[str, Kind] = {
    "file": Text("bunny.exr"),
    "recipe": Text("ornaments.toml"),
    "mask": Text("mask.png"),
    "hidden": Switch(),
}
# the options that are keys of a recipe under their own name
_OPTIONS = (LayerOptions, CanvasOptions, ReadOptions, ReliefFiles, ReliefOptions, SolidOptions)
_NOT_KEYS = ("max_megapixels", "memory_limit")
_KEYS = {*_FILE_KINDS, "layer", "read"} | {f.name for each in _OPTIONS for f in fields(each) if f.name not in _NOT_KEYS}
_LONGEST_SHOWN = 60


def table_of(found: Any, place: Place, example: str) -> Mapping[str, Any]:
    """Return a value that must be a table."""
    if not isinstance(found, Mapping):
        raise InputError(f"{place.named()}: found {shown(found)}, expected a table {example}")
    return found


def known_keys(table: Mapping[str, Any], accepted: Iterable[str], place: Place) -> dict[str, Any]:
    """Return the table with _ in its keys; unknown keys are refused."""
    names = {written_name(name): name for name in accepted}
    known: dict[str, Any] = {}
    for written, value in table.items():
        key = written.replace("-", "_")
        if key not in names:
            near = difflib.get_close_matches(key.lower(), names, 1)
            remedy = f"did you mean {near[0]!r}?" if near else f"use one of {', '.join(names)}"
            raise InputError(f"{place.named(written)}: unknown key {cut(written)!r}; {remedy}")
        if names[key] in known:
            raise InputError(f"{place.named(written)}: {key}: is given twice, with _ and with -; remove one")
        known[names[key]] = value
    return known


def typed(options: type[Options], table: Mapping[str, Any], place: Place) -> dict[str, Any]:
    """Check each value against the kind of its option and convert it."""
    kinds = {**_FILE_KINDS, **{f.name: kind for f in fields(options) if (kind := kind_of(f)) is not None}}
    return {key: value_of(kinds[key], value, key, place) for key, value in table.items()}


def value_of(kind: Kind, value: Any, key: str, place: Place) -> Any:
    """Check a value against a kind and convert it."""
    if isinstance(kind, ScaleText) and isinstance(value, str):
        return value
    if kind.toml is float:
        return _number(kind, value, key, place)
    if isinstance(value, kind.toml):
        return value
    expected = "true or false" if kind.toml is bool else f'text in quotes, such as "{kind.such_as}"'
    raise InputError(f"{place.named(key)}: {written_name(key)}: found {shown(value)}, expected {expected}")


def _number(kind: Kind, value: Any, key: str, place: Place) -> Any:
    is_scale, is_whole = isinstance(kind, ScaleText), isinstance(kind, Count)
    if not isinstance(value, int if is_whole else int | float) or isinstance(value, bool):
        texts = ', text such as "0.5,0.7" or "30mm"' if is_scale else ""
        expected = f"a {'whole ' if is_whole else ''}number such as {kind.such_as}{texts}"
        raise InputError(f"{place.named(key)}: {written_name(key)}: found {shown(value)}, expected {expected}")
    try:
        number = float(value)
    except OverflowError:
        raise InputError(f"{place.named(key)}: {written_name(key)}: found {shown(value)}, which is too large") from None
    return number_text(number) if is_scale else value if is_whole else number


def options_of(kind: Any, given: Mapping[str, Any], place: Place) -> Any:
    """Make options; their errors use the keys of the recipe and name the line of the first key mentioned."""
    try:
        return kind(**given)
    except UsageError as error:
        first = [name for name in error.options if name in given][:1]
        raise InputError(f"{place.named(*first)}: {with_recipe_keys(str(error))}") from None


def with_recipe_keys(text: str) -> str:
    """Write the options in a message as keys of a recipe; options that a recipe does not have are kept.

    >>> with_recipe_keys("`height_factor=5000`: must lie between -1000 and 1000")
    'height_factor = 5000: must lie between -1000 and 1000'
    >>> with_recipe_keys("`flip_h=True` is not for `mode='over'`")
    'flip_h = true is not for mode = "over"'
    """
    return rendered(text, _key)


def _key(name: str, value: Any) -> str:
    """Return a key and its value as TOML."""
    if name not in _KEYS:
        return f"`{name}`" if value is None else f"`{name}={value!r}`"
    if value is None:
        return written_name(name)
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return f"{written_name(name)} = {number_text(value) if is_number else json.dumps(value, ensure_ascii=False)}"


def number_text(number: float) -> str:
    """Return the shortest text that reads back as the same number.

    >>> number_text(12.0), number_text(0.1)
    ('12', '0.1')
    """
    text = repr(number)
    return text.removesuffix(".0")


def cut(text: str) -> str:
    """Return text short enough for a message."""
    return text if len(text) <= _LONGEST_SHOWN else f"{text[: _LONGEST_SHOWN - 3]}..."


def shown(value: Any) -> str:
    """Describe a value of a recipe with its type, for messages."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return f"the text {cut(value)!r}"
    if isinstance(value, int):  # Python refuses to print integers of thousands of digits
        return f"the number {value}" if abs(value) < 10**30 else "a number of more than 30 digits"
    if isinstance(value, float):
        return f"the number {value:g}"
    if isinstance(value, list | tuple):
        return "a list"
    return "a table" if isinstance(value, Mapping) else f"the date or time {value}"
