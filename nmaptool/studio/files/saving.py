"""Requests that save and open documents."""

from __future__ import annotations

import filecmp
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeGuard

from nmaptool.composition.recipe_toml import to_toml
from nmaptool.core.errors import InputError, UsageError
from nmaptool.io.output.writing import write_together
from nmaptool.io.pictures.normal_maps import split_layer
from nmaptool.io.recipes.reader import read_recipe
from nmaptool.options.formats import RECIPE_ENDING, is_recipe
from nmaptool.studio import layers
from nmaptool.studio.document import Document, relative
from nmaptool.studio.files import recovery
from nmaptool.studio.files.store import plain_name
from nmaptool.studio.meshes import details
from nmaptool.studio.painting.painting import LAYER_MASK, ROLES
from nmaptool.studio.room import Room
from nmaptool.studio.windows import Message


def save(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Save the recipe: under ``name`` in the folder of the document, or where it was saved before."""
    name = message.get("name")
    path = room.now.path
    if isinstance(name, str) and name:
        path = room.now.folder / plain_name(name)
        if not is_recipe(path.name):
            path = path.with_name(f"{path.name}{RECIPE_ENDING}")
    if path is None:
        raise UsageError("give the recipe a name to save it under, such as medal.toml")
    replaces = path == room.now.path or message.get("overwrite") is True
    if path.exists() and not replaces:
        raise InputError(f"{path.name}: exists already; choose another name, or replace it")
    document, copies, texts = _beside(room, path)
    texts[path] = to_toml(document.recipe)
    jobs = [(target, _copy(source)) for source, target in copies.items() if target not in texts]
    write_together([*jobs, *((target, _text(text)) for target, text in texts.items())], True)
    room.saved(document, path, copies)
    return {"kind": "saved", "path": str(path), "files": [target.name for target in copies.values()]}


def _copy(source: Path) -> Callable[[Path], object]:
    return lambda file: shutil.copyfile(source, file)


def _text(text: str) -> Callable[[Path], object]:
    return lambda file: file.write_text(text, encoding="utf-8")


def _beside(room: Room, path: Path) -> tuple[Document, dict[Path, Path], dict[Path, str]]:
    """Return the document with dropped, baked and painted files beside its recipe, and which file goes where.

    The texts are those of the recipes among the files, which name other files then.
    """
    now = room.now
    roles = {name: role for role in ROLES if (name := getattr(now.relief.files, role)) is not None}
    roles |= {entry.mask: LAYER_MASK for _, entry in layers.maps_of(now.layers) if _is_painted(room, entry.mask)}
    own = {now.folder / split_layer(name)[0] for name in room.saved_files} if path == room.now.path else set()
    targets: dict[Path, Path] = {}
    texts: dict[Path, str] = {}

    def new(name: str) -> str:
        file, layer = split_layer(str(now.folder / name))
        if not room.store.holds(file):
            return name
        if file not in targets and is_recipe(file.name):
            text = details.carried(file, new)
            wanted = f"{path.stem}-detail{RECIPE_ENDING}"
            targets[file] = _free(path.with_name(wanted), file, own, set(targets.values()))
            texts[targets[file]] = text
        elif file not in targets:
            wanted = f"{path.stem}-{roles[name].replace('_', '-')}.png" if name in roles else file.name
            targets[file] = _free(path.parent / wanted, file, own if name in roles else set(), set(targets.values()))
        return relative(targets[file], now.folder) + ("" if layer is None else f":{layer}")

    return now.renamed(new), targets, texts


def _is_painted(room: Room, name: str | None) -> TypeGuard[str]:
    return name is not None and str(room.now.folder / name) in room.painted


def _free(wanted: Path, source: Path, replaceable: set[Path], taken: set[Path]) -> Path:
    """Return a path for a copy of a file: no other file of the user is replaced."""
    path, number = wanted, 1
    while path in taken or (path.exists() and path not in replaceable and not filecmp.cmp(path, source, False)):
        number += 1
        path = wanted.with_stem(f"{wanted.stem}-{number}")
    return path


def list_recipes(room: Room, _: Mapping[str, Any]) -> Message | None:
    """Name the recipes in the folder of the document."""
    folder = room.now.folder
    found = sorted(path.name for path in folder.glob(f"*{RECIPE_ENDING}") if path.is_file())
    return {"kind": "recipes", "folder": str(folder), "names": found}


def open_file(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Open the recipe ``name`` in the folder of the document; undo goes back to the document before."""
    name = message.get("name")
    if not isinstance(name, str):
        raise UsageError("name the recipe to open")
    path = room.now.folder / plain_name(name)
    room.opened(Document.of(read_recipe(path, name=path.name), path))
    return None


def recover(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Open the unsaved work ``id`` of a studio that ended; undo goes back to the document before."""
    room.do(recovery.recovered(_unsaved(room, message), room.store))
    room.windows.tell(room.unsaved())
    return None


def discard(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Delete the unsaved work ``id``."""
    shutil.rmtree(_unsaved(room, message).folder, ignore_errors=True)
    room.windows.tell(room.unsaved())
    return None


def _unsaved(room: Room, message: Mapping[str, Any]) -> recovery.Unsaved:
    known = {one.folder.name: one for one in recovery.found(room.store.folder.parent, room.store.folder)}
    one = known.get(str(message.get("id")))
    if one is None:
        raise UsageError("this unsaved work is not there any more")
    return one
