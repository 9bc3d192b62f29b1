"""Parse and check the keys and values of a recipe."""

from __future__ import annotations

import difflib
import json
from collections.abc import Iterable, Mapping
from dataclasses import fields
from pathlib import PurePath
from typing import Any

from nmaptool.composition.recipe_places import LineOf, Place
from nmaptool.core.errors import InputError, LimitError, UsageError
from nmaptool.core.mentions import rendered, written_name
from nmaptool.options import (
    CanvasOptions,
    GroupOptions,
    LayerOptions,
    ReadOptions,
    ReliefFiles,
    ReliefOptions,
    SolidOptions,
)
from nmaptool.options.fields import Options, kind_of
from nmaptool.options.kinds import Count, Kind, Switch, Text
from nmaptool.options.length_kinds import ScaleText
from nmaptool.types.recipe import (
    DEEPEST,
    READ_KEYS,
    RELIEF_KEYS,
    Entry,
    Recipe,
    RecipeGroup,
    RecipeLayer,
    RecipeLink,
    RecipeRelief,
)

# kinds of the keys that are not options
_FILE_KINDS: dict[str, Kind] = {
    "file": Text("bunny.exr"),
    "recipe": Text("ornaments.toml"),
    "mask": Text("mask.png"),
    "hidden": Switch(),
}
# what the names in these keys refer to; none may be empty
_NAMES = {"file": "a normal map", "recipe": "a recipe", "mask": "a grey picture"}
_PLACE_KEYS = tuple(f.name for f in fields(LayerOptions))
_GROUP_OPTIONS = tuple(f.name for f in fields(GroupOptions))
_CANVAS_KEYS = tuple(f.name for f in fields(CanvasOptions))
_FILE_KEYS = tuple(f.name for f in fields(ReliefFiles))
_SOLID_KEYS = tuple(f.name for f in fields(SolidOptions))
_CONTENTS = ("file", "recipe", "layer")
LAYER_KEYS = ("file", *_PLACE_KEYS, "mask", "hidden", "read")
GROUP_KEYS = ("layer", "recipe", *_GROUP_OPTIONS, "mask", "hidden")
_ALL_KEYS = tuple(dict.fromkeys((*LAYER_KEYS, *GROUP_KEYS)))
_KEYS = frozenset((*_ALL_KEYS, *READ_KEYS, *_CANVAS_KEYS, *_FILE_KEYS, *RELIEF_KEYS, *_SOLID_KEYS))
_LONGEST_SHOWN = 60


def parse_recipe(
    values: Mapping[str, Any], *, name: str = "recipe", folder: str = "", line_of: LineOf | None = None
) -> Recipe:
    """Make a recipe from a mapping, such as ``tomllib`` returns.

    Parameters
    ----------
    values : mapping
        ``canvas`` and ``relief`` (tables, optional) and ``layer`` (list of tables); keys are the fields of the options,
        with _ or -.
    name : str
        Name of the recipe for messages.
    folder : str
        Folder that its file names are relative to.
    line_of : callable, optional
        Returns the line of a value in the text of the recipe, for messages: ``line_of(("layer", 0, "mode"))`` is the
        line of ``values["layer"][0]["mode"]``, or of the table around it. Default: messages name no lines.

    Returns
    -------
    Recipe

    Raises
    ------
    InputError
        If a key or value is not accepted; the message names the place, the key, what was found and what is accepted.
    LimitError
        If groups are nested too deeply.

    Examples
    --------
    >>> nm.parse_recipe({"layer": [{"file": "plate.png"}, {"file": "leaf.png", "mode": "rnm"}]})
    <Recipe recipe: 2 layers, 2 files, canvas of the lowest layer's size>
    """
    top = Place(name, line_of)
    known = known_keys(values, ("canvas", "layer", "relief"), top)
    canvas = CanvasOptions()
    if "canvas" in known:
        place = top.to("canvas", title="canvas")
        table = known_keys(_table(known["canvas"], place, "[canvas]"), _CANVAS_KEYS, place)
        canvas = _options(CanvasOptions, _typed(CanvasOptions, table, place), place)
    layers = _entries(known["layer"], top, "", 1) if "layer" in known else ()
    relief = relief_of(known["relief"], top.to("relief", title="relief")) if "relief" in known else None
    return Recipe(layers, canvas, name, folder, relief=relief)


def relief_of(found: Any, place: Place) -> RecipeRelief:
    """Return the relief of a table ``[relief]``."""
    known = known_keys(_table(found, place, "[relief]"), (*_FILE_KEYS, *RELIEF_KEYS, *_SOLID_KEYS), place)
    parts: list[dict[str, Any]] = []
    for kind, keys in ((ReliefFiles, _FILE_KEYS), (ReliefOptions, RELIEF_KEYS), (SolidOptions, _SOLID_KEYS)):
        given = _typed(kind, {key: value for key, value in known.items() if key in keys}, place)
        made = _options(kind, given, place)
        parts.append({key: getattr(made, key) for key in given})
    files, options, solid = parts
    for key, value in files.items():
        if value == "":
            raise InputError(f"{place.named(key)}: {written_name(key)}: found nothing, expected the name of a file")
    return RecipeRelief(ReliefFiles(**files), options, solid)


def _entries(found: Any, around: Place, number: str, depth: int) -> tuple[Entry, ...]:
    """Return the layers of a recipe, or of the group with this number."""
    title = f"layer {number.rstrip('.')}" if number else ""
    place = around.to("layer", title=title)
    if depth > DEEPEST:
        raise LimitError(f"{place.named()}: groups are nested more than {DEEPEST} deep; flatten them")
    brackets = "layer." * number.count(".") + "layer"
    if isinstance(found, Mapping):
        raise InputError(f"{place.named()}: [{brackets}] is one table; write [[{brackets}]], with double brackets")
    if not isinstance(found, list | tuple):
        raise InputError(f"{place.named()}: layer: found {_shown(found)}, expected tables [[{brackets}]]")
    return tuple(
        _entry(each, place.to(i, title=f"layer {number}{i + 1}"), f"{number}{i + 1}", depth)
        for i, each in enumerate(found)
    )


def _entry(found: Any, place: Place, number: str, depth: int) -> Entry:
    """Return a layer, a group or a link, depending on which keys the table has."""
    table = _table(found, place, "[[layer]]")
    place = place.to(title=place.title + _called(table))
    known = known_keys(table, _ALL_KEYS, place)
    holds = [key for key in _CONTENTS if key in known]
    if len(holds) != 1 or (holds == ["layer"] and not known["layer"]):
        what = " and ".join(holds) if len(holds) > 1 else "neither file, recipe nor layers"
        remedy = "give one of them: file (a normal map), recipe (another recipe) or [[layer.layer]] (a group)"
        raise InputError(f"{place.named(*holds[:1])}: holds {what}; {remedy}")
    (kind,) = holds
    own = LAYER_KEYS if kind == "file" else GROUP_KEYS
    for key in known:
        if key not in own:
            what = f"is for a layer with a file, not for a {'recipe' if kind == 'recipe' else 'group'}"
            raise InputError(f"{place.named(key)}: {written_name(key)}: {what}; give it to its layers")
    class_of_options = LayerOptions if kind == "file" else GroupOptions
    values = _typed(class_of_options, {k: v for k, v in known.items() if k not in ("read", "layer")}, place)
    for key, expected in _NAMES.items():
        if values.get(key) == "":
            raise InputError(f"{place.named(key)}: {written_name(key)}: found nothing, expected the name of {expected}")
    common = {"mask": values.pop("mask", None), "hidden": values.pop("hidden", False), "origin": place.named()}
    if kind == "file":
        file = values.pop("file")
        read = _read(known.get("read", {}), place.to("read", title=f"{place.title}: read"))
        return RecipeLayer(file, _options(LayerOptions, values, place), read=read, **common)
    if kind == "recipe":
        recipe = values.pop("recipe")
        return RecipeLink(recipe, _options(GroupOptions, {"name": recipe, **values}, place), **common)
    options = _options(GroupOptions, values, place)
    return RecipeGroup(_entries(known["layer"], place, f"{number}.", depth + 1), options, **common)


def _read(found: Any, place: Place) -> dict[str, Any]:
    given = _typed(ReadOptions, known_keys(_table(found, place, "[layer.read]"), READ_KEYS, place), place)
    _options(ReadOptions, given, place)
    return given


def _called(table: Mapping[str, Any]) -> str:
    """Return `` (bunny)``: the name of the layer, or of its file, for messages."""
    name = table.get("name") or table.get("file") or table.get("recipe")
    if not isinstance(name, str) or not name:
        return ""
    name = name if table.get("name") else PurePath(name).name
    printable = "".join(c if c.isprintable() else " " for c in name)
    return f" ({_cut(' '.join(printable.split()))})"


def _table(found: Any, place: Place, example: str) -> Mapping[str, Any]:
    if not isinstance(found, Mapping):
        raise InputError(f"{place.named()}: found {_shown(found)}, expected a table {example}")
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
            raise InputError(f"{place.named(written)}: unknown key {_cut(written)!r}; {remedy}")
        if names[key] in known:
            raise InputError(f"{place.named(written)}: {key}: is given twice, with _ and with -; remove one")
        known[names[key]] = value
    return known


def _typed(options: type[Options], table: Mapping[str, Any], place: Place) -> dict[str, Any]:
    """Check each value against the kind of its option and convert it."""
    kinds = {**_FILE_KINDS, **{f.name: kind for f in fields(options) if (kind := kind_of(f)) is not None}}
    return {key: _value(kinds[key], value, key, place) for key, value in table.items()}


def _value(kind: Kind, value: Any, key: str, place: Place) -> Any:
    if isinstance(kind, ScaleText) and isinstance(value, str):
        return value
    if kind.toml is float:
        return _number(kind, value, key, place)
    if isinstance(value, kind.toml):
        return value
    expected = "true or false" if kind.toml is bool else f'text in quotes, such as "{kind.such_as}"'
    raise InputError(f"{place.named(key)}: {written_name(key)}: found {_shown(value)}, expected {expected}")


def _number(kind: Kind, value: Any, key: str, place: Place) -> Any:
    is_scale, is_whole = isinstance(kind, ScaleText), isinstance(kind, Count)
    if not isinstance(value, int if is_whole else int | float) or isinstance(value, bool):
        texts = ', text such as "0.5,0.7" or "30mm"' if is_scale else ""
        expected = f"a {'whole ' if is_whole else ''}number such as {kind.such_as}{texts}"
        raise InputError(f"{place.named(key)}: {written_name(key)}: found {_shown(value)}, expected {expected}")
    try:
        number = float(value)
    except OverflowError:
        raise InputError(
            f"{place.named(key)}: {written_name(key)}: found {_shown(value)}, which is too large"
        ) from None
    return number_text(number) if is_scale else value if is_whole else number


def _options(kind: Any, given: Mapping[str, Any], place: Place) -> Any:
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


def _cut(text: str) -> str:
    return text if len(text) <= _LONGEST_SHOWN else f"{text[: _LONGEST_SHOWN - 3]}..."


def _shown(value: Any) -> str:
    """Describe a value of a recipe with its type, for messages."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return f"the text {_cut(value)!r}"
    if isinstance(value, int):  # Python refuses to print integers of thousands of digits
        return f"the number {value}" if abs(value) < 10**30 else "a number of more than 30 digits"
    if isinstance(value, float):
        return f"the number {value:g}"
    if isinstance(value, list | tuple):
        return "a list"
    return "a table" if isinstance(value, Mapping) else f"the date or time {value}"
