"""The layers of the document: how the page names, shows and changes them."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, TypeAlias

from nmaptool.core.errors import UsageError
from nmaptool.studio.document import Document
from nmaptool.studio.forms.descriptions import plain
from nmaptool.types.recipe import READ_KEYS, Entry, RecipeGroup, RecipeLayer

# numbers from the outermost list of layers to a layer inside groups; 0 is the lowest
Place: TypeAlias = tuple[int, ...]
_STRANGE = "the page named a layer that is not there; reload it"


def described(layers: Sequence[Entry], above: Place = ()) -> list[dict[str, Any]]:
    """Return the layers for the page, from the lowest to the topmost, those of groups inside them."""
    return [_described(layer, (*above, number)) for number, layer in enumerate(layers)]


def _described(layer: Entry, place: Place) -> dict[str, Any]:
    shown = {
        "place": place,
        "kind": "group",
        "label": layer.options.name or layer.label,
        "hidden": layer.hidden,
        "mask": layer.mask,
        "file": None,
        "options": {name: plain(value) for name, value in vars(layer.options).items()},
        "read": {},
        "layers": described(layer.layers, place) if isinstance(layer, RecipeGroup) else [],
    }
    if isinstance(layer, RecipeLayer):
        shown |= {"kind": "map", "label": layer.options.name or _short(layer.file), "file": layer.file}
        shown["read"] = {name: plain(value) for name, value in layer.read.items()}
    return shown


def _short(file: str) -> str:
    return file.replace("\\", "/").rpartition("/")[2]


def place_of(value: Any) -> Place:
    """Return the place that a page named.

    Raises
    ------
    UsageError
        If it is not a list of numbers.
    """
    if not isinstance(value, list) or not value or not all(type(number) is int and number >= 0 for number in value):
        raise UsageError(_STRANGE)
    return tuple(value)


def entry_at(layers: Sequence[Entry], place: Place) -> Entry:
    """Return the layer at a place.

    Raises
    ------
    UsageError
        If there is none.
    """
    entry: Entry | None = None
    for number in place:
        if number >= len(layers):
            raise UsageError(_STRANGE)
        entry = layers[number]
        layers = entry.layers if isinstance(entry, RecipeGroup) else ()
    if entry is None:
        raise UsageError(_STRANGE)
    return entry


def with_layers(layers: tuple[Entry, ...], place: Place, inside: Sequence[Entry], cut: int = 1) -> tuple[Entry, ...]:
    """Return the layers with ``cut`` of them, from a place on, replaced by others."""
    number, *below = place
    if below:
        group = entry_at(layers, (number,))
        if not isinstance(group, RecipeGroup):
            raise UsageError(_STRANGE)
        inner = with_layers(group.layers, tuple(below), inside, cut)
        inside, cut = [dataclasses.replace(group, layers=inner)] if inner else [], 1
    if number > len(layers):
        raise UsageError(_STRANGE)
    return (*layers[:number], *inside, *layers[number + cut :])


def edited(document: Document, place: Place, values: Mapping[str, Any]) -> Document:
    """Return the document with other values for a layer: its options, ``hidden``, ``mask``, ``file`` or ``read``.

    None sets an option to its default.

    Raises
    ------
    UsageError
        If a key is not known or its value is not accepted.
    """
    entry = entry_at(document.layers, place)
    options = {f.name: f.default for f in dataclasses.fields(entry.options)}
    given: dict[str, Any] = dict(vars(entry.options))
    own: dict[str, Any] = {}
    for key, value in values.items():
        if key in options:
            given[key] = options[key] if value is None else value
        elif key == "read" and isinstance(entry, RecipeLayer) and isinstance(value, Mapping):
            own["read"] = _reading(entry, value)
        elif key in ("mask", "hidden", "file") and key in {f.name for f in dataclasses.fields(entry)}:
            own[key] = value
        else:
            raise UsageError(f"`{key}`: is not an option of a layer")
    own["options"] = type(entry.options)(**given)
    changed: Entry = dataclasses.replace(entry, **own)
    return dataclasses.replace(document, layers=with_layers(document.layers, place, [changed]))


def _reading(entry: RecipeLayer, values: Mapping[str, Any]) -> dict[str, Any]:
    for key in values:
        if key not in READ_KEYS:
            raise UsageError(f"`{key}`: is not an option of reading a map")
    return {key: value for key, value in {**entry.read, **values}.items() if value is not None}


def moved(document: Document, place: Place, to: Place) -> Document:
    """Return the document with a layer below the one that is at ``to`` now, or at the end of that list.

    Raises
    ------
    UsageError
        If a group is to go into itself.
    """
    entry = entry_at(document.layers, place)
    if len(to) > len(place) and to[: len(place)] == place:
        raise UsageError("a group cannot be moved into itself")
    layers = with_layers(document.layers, to, [entry], 0)
    level, old = len(to) - 1, list(place)
    if len(place) > level and place[:level] == to[:level] and place[level] >= to[level]:
        old[level] += 1  # the copy came below it
    return dataclasses.replace(document, layers=with_layers(layers, tuple(old), []))


def added(document: Document, entry: Entry) -> Document:
    """Return the document with one more layer on top."""
    return dataclasses.replace(document, layers=(*document.layers, entry))


def removed(document: Document, place: Place) -> Document:
    """Return the document without a layer."""
    entry_at(document.layers, place)
    return dataclasses.replace(document, layers=with_layers(document.layers, place, []))


def doubled(document: Document, place: Place) -> Document:
    """Return the document with a second copy of a layer above it."""
    entry = entry_at(document.layers, place)
    return dataclasses.replace(document, layers=with_layers(document.layers, place, [entry, entry]))


def maps_of(
    layers: Sequence[Entry], above: Place = (), *, with_hidden: bool = False
) -> Iterator[tuple[Place, RecipeLayer]]:
    """Yield the layers with a map, those in groups, too, with their places; hidden ones only ``with_hidden``."""
    for number, entry in enumerate(layers):
        if entry.hidden and not with_hidden:
            continue
        if isinstance(entry, RecipeLayer):
            yield (*above, number), entry
        elif isinstance(entry, RecipeGroup):
            yield from maps_of(entry.layers, (*above, number), with_hidden=with_hidden)
