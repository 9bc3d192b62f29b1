"""Parse and write the tables of a recipe that describe a plate: its shape, frame, texts and machine."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import Any

from nmaptool.composition.recipe_places import Place
from nmaptool.composition.recipe_values import known_keys, number_text, shown, table_of, value_of
from nmaptool.core.errors import InputError, UsageError
from nmaptool.core.mentions import rendered
from nmaptool.options.fields import kind_of
from nmaptool.options.kinds import Text
from nmaptool.types.recipe_plate import PLATE_TABLES, RecipePlate, Table


def plate_of(known: Mapping[str, Any], top: Place) -> RecipePlate | None:
    """Return the plate of a recipe's tables; None if it has none of them.

    Raises
    ------
    InputError
        If a key or value is not accepted.
    """
    if not any(name in known for name in PLATE_TABLES):
        return None
    found = {
        name: _given(known[name], top.to(name, title=name), PLATE_TABLES[name], f"[{name}]") if name in known else {}
        for name in ("plate", "frame", "machine")
    }
    return RecipePlate(found["plate"], found["frame"], _texts(known.get("text", ()), top), found["machine"])


def _texts(found: Any, top: Place) -> tuple[dict[str, Any], ...]:
    if isinstance(found, Mapping):
        raise InputError(f"{top.named('text')}: [text] is one table; write [[text]], with double brackets")
    if not isinstance(found, list | tuple):
        raise InputError(f"{top.named('text')}: text: found {shown(found)}, expected tables [[text]]")
    texts = []
    for number, each in enumerate(found):
        place = top.to("text", number, title=f"text {number + 1}")
        given = _given(each, place, PLATE_TABLES["text"], "[[text]]")
        if given.get("text") is None:
            raise InputError(f'{place.named()}: text: found nothing, expected letters, such as text = "ANNO MMXXVI"')
        texts.append(given)
    return tuple(texts)


def _given(found: Any, place: Place, table: Table, example: str) -> dict[str, Any]:
    """The fields that a table gives, checked."""
    keys = table.keys
    known = known_keys(table_of(found, place, example), keys, place)
    kinds = {f.name: kind_of(f) or Text() for f in fields(table.options)}
    given = {keys[key]: value_of(kinds[keys[key]], value, key, place) for key, value in known.items()}
    try:
        made = table.options(**given)
    except UsageError as error:
        first = [table.key(name) for name in error.options if name in given][:1]
        raise InputError(f"{place.named(*first)}: {rendered(str(error), _mention(table))}") from None
    return {name: getattr(made, name) for name in given}


def _mention(table: Table) -> Any:
    """How messages write an option of a table."""
    names = {f.name for f in fields(table.options)}

    def written(name: str, value: Any) -> str:
        if name not in names:
            return f"`{name}`" if value is None else f"`{name}={value!r}`"
        if value is None:
            return table.key(name)
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        return f"{table.key(name)} = {number_text(value) if is_number else json.dumps(value, ensure_ascii=False)}"

    return written


def tables_of(plate: RecipePlate) -> Iterator[tuple[str, dict[str, Any]]]:
    """Headings and pairs of the tables that write a plate in TOML."""
    for name, given in (("plate", plate.plate), ("frame", plate.frame), ("machine", plate.machine)):
        if given:
            yield f"[{name}]", {PLATE_TABLES[name].key(each): value for each, value in given.items()}
    for text in plate.texts:
        yield "[[text]]", {PLATE_TABLES["text"].key(each): value for each, value in text.items()}
