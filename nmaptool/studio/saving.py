"""Requests that save the document."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nmaptool.core.errors import InputError, UsageError
from nmaptool.io.recipes.writer import write_recipe
from nmaptool.studio.room import Message, Room
from nmaptool.studio.store import plain_name


def save(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Save the recipe: under ``name`` in the folder of the document, or where it was saved before."""
    name = message.get("name")
    path = room.path
    if isinstance(name, str) and name:
        path = room.now.folder / plain_name(name)
        if path.suffix != ".toml":
            path = path.with_name(f"{path.name}.toml")
    if path is None:
        raise UsageError("give the recipe a name to save it under, such as medal.toml")
    replaces = path == room.path or message.get("overwrite") is True
    if path.exists() and not replaces:
        raise InputError(f"{path.name}: exists already; choose another name, or replace it")
    write_recipe(room.now.recipe, path, overwrite=replaces)
    room.saved(room.now, path)
    return {"kind": "saved", "path": str(path)}
