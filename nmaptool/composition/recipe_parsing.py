"""Parse and check the keys and values of a recipe."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from pathlib import PurePath
from typing import Any

from nmaptool.composition.plate_parsing import plate_of
from nmaptool.composition.recipe_places import LineOf, Place
from nmaptool.composition.recipe_values import cut, known_keys, options_of, shown, table_of, typed
from nmaptool.core.errors import InputError, LimitError
from nmaptool.core.mentions import written_name
from nmaptool.options import (
    CanvasOptions,
    GroupOptions,
    LayerOptions,
    ReadOptions,
    ReliefFiles,
    ReliefOptions,
    SolidOptions,
)
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
from nmaptool.types.recipe_plate import PLATE_TABLES

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
    known = known_keys(values, ("canvas", "layer", "relief", *PLATE_TABLES), top)
    canvas = CanvasOptions()
    if "canvas" in known:
        place = top.to("canvas", title="canvas")
        table = known_keys(table_of(known["canvas"], place, "[canvas]"), _CANVAS_KEYS, place)
        canvas = options_of(CanvasOptions, typed(CanvasOptions, table, place), place)
    layers = _entries(known["layer"], top, "", 1) if "layer" in known else ()
    relief = relief_of(known["relief"], top.to("relief", title="relief")) if "relief" in known else None
    return Recipe(layers, canvas, name, folder, relief=relief, plate=plate_of(known, top))


def relief_of(found: Any, place: Place) -> RecipeRelief:
    """Return the relief of a table ``[relief]``."""
    known = known_keys(table_of(found, place, "[relief]"), (*_FILE_KEYS, *RELIEF_KEYS, *_SOLID_KEYS), place)
    parts: list[dict[str, Any]] = []
    for kind, keys in ((ReliefFiles, _FILE_KEYS), (ReliefOptions, RELIEF_KEYS), (SolidOptions, _SOLID_KEYS)):
        given = typed(kind, {key: value for key, value in known.items() if key in keys}, place)
        made = options_of(kind, given, place)
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
        raise InputError(f"{place.named()}: layer: found {shown(found)}, expected tables [[{brackets}]]")
    return tuple(
        _entry(each, place.to(i, title=f"layer {number}{i + 1}"), f"{number}{i + 1}", depth)
        for i, each in enumerate(found)
    )


def _entry(found: Any, place: Place, number: str, depth: int) -> Entry:
    """Return a layer, a group or a link, depending on which keys the table has."""
    table = table_of(found, place, "[[layer]]")
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
    values = typed(class_of_options, {k: v for k, v in known.items() if k not in ("read", "layer")}, place)
    for key, expected in _NAMES.items():
        if values.get(key) == "":
            raise InputError(f"{place.named(key)}: {written_name(key)}: found nothing, expected the name of {expected}")
    common = {"mask": values.pop("mask", None), "hidden": values.pop("hidden", False), "origin": place.named()}
    if kind == "file":
        file = values.pop("file")
        read = _read(known.get("read", {}), place.to("read", title=f"{place.title}: read"))
        return RecipeLayer(file, options_of(LayerOptions, values, place), read=read, **common)
    if kind == "recipe":
        recipe = values.pop("recipe")
        return RecipeLink(recipe, options_of(GroupOptions, {"name": recipe, **values}, place), **common)
    options = options_of(GroupOptions, values, place)
    return RecipeGroup(_entries(known["layer"], place, f"{number}.", depth + 1), options, **common)


def _read(found: Any, place: Place) -> dict[str, Any]:
    given = typed(ReadOptions, known_keys(table_of(found, place, "[layer.read]"), READ_KEYS, place), place)
    options_of(ReadOptions, given, place)
    return given


def _called(table: Mapping[str, Any]) -> str:
    """Return `` (bunny)``: the name of the layer, or of its file, for messages."""
    name = table.get("name") or table.get("file") or table.get("recipe")
    if not isinstance(name, str) or not name:
        return ""
    name = name if table.get("name") else PurePath(name).name
    printable = "".join(c if c.isprintable() else " " for c in name)
    return f" ({cut(' '.join(printable.split()))})"
