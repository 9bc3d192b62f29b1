"""Requests about dropped files: they become layers, depth layers, roles of the relief, or the document."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from nmaptool.core.errors import InputError, UsageError
from nmaptool.options import DepthOptions, LayerOptions, ReliefFiles
from nmaptool.studio import layers
from nmaptool.studio.document import Document, relative
from nmaptool.studio.files import drops
from nmaptool.studio.forms.given import options_from
from nmaptool.studio.room import Room
from nmaptool.studio.windows import Message
from nmaptool.types.recipe import RecipeLayer, RecipeRelief

_ROLES = tuple(f.name for f in dataclasses.fields(ReliefFiles))


def add_layer(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Put the map ``file``, which was dropped, on top of the layers; with its detail map, if the file has one."""
    path = dropped(room, message.get("file"))

    def then(has_detail: bool) -> None:
        changed = with_layer(room.now, path, path.stem)
        if not has_detail:
            room.do(changed)
            return
        file = f"{changed.layers[-1].file}:original" if isinstance(changed.layers[-1], RecipeLayer) else ""
        changed = layers.edited(changed, (len(changed.layers) - 1,), {"file": file})
        details = room.sources.details
        details.add(room.now.folder / file, path.with_name(f"{path.name}:detail"))
        room.do(details.followed(changed) if details.can_follow(room.now) else changed)

    # in the background for every file, so that several become layers in their order
    room.background.start(lambda _: drops.has_detail(path), then)
    return None


def with_layer(document: Document, path: Path, name: str) -> Document:
    """Return the document with a map on top of its layers."""
    if not document.layers:
        document = dataclasses.replace(document, name=name)
    return layers.added(document, RecipeLayer(relative(path, document.folder), LayerOptions(name=name)))


def add_depth(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Turn the depth picture ``file`` into normals, with ``values`` of the depth options, and put them on top."""
    source = dropped(room, message.get("file"))
    options = options_from(DepthOptions, message.get("values") or {})
    target = room.store.place(f"{source.stem}-normals.exr")

    def then(_: object) -> None:
        room.depths[str(target)] = source, options
        room.do(with_layer(room.now, target, source.stem))

    room.background.start(lambda progress: drops.converted(source, options, target, progress), then)
    return None


def set_depth(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Convert the depth picture of the layer at ``place`` again, with other ``values``."""
    place = layers.place_of(message.get("place"))
    entry = layers.entry_at(room.now.layers, place)
    file = str(room.now.folder / entry.file) if isinstance(entry, RecipeLayer) else ""
    if file not in room.depths:
        raise UsageError("this layer was not made from a depth picture since the studio was started; drop it again")
    source, _ = room.depths[file]
    options = options_from(DepthOptions, message.get("values") or {})
    target = room.store.place(f"{source.stem}-normals.exr")

    def then(_: object) -> None:
        room.depths[str(target)] = source, options
        now = layers.entry_at(room.now.layers, place)
        if not isinstance(now, RecipeLayer) or str(room.now.folder / now.file) != file:
            raise InputError(f"{source.name}: its layer has moved or is gone; set its depth options again")
        room.do(layers.edited(room.now, place, {"file": relative(target, room.now.folder)}))

    room.background.start(lambda progress: drops.converted(source, options, target, progress), then)
    return None


def set_file(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Use the dropped ``file`` as the ``role`` of the relief, such as its mask; None removes what it has."""
    role = message.get("role")
    if role not in _ROLES:
        raise UsageError(f"the page named the role {role!r}, which a relief does not have; reload it")
    named = message.get("file")
    path = None if named is None else relative(dropped(room, named), room.now.folder)
    room.do(with_file(room.now, role, path))
    return None


def set_layer_mask(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Use the dropped ``file`` as the mask of the layer at ``place``."""
    path = relative(dropped(room, message.get("file")), room.now.folder)
    room.do(layers.edited(room.now, layers.place_of(message.get("place")), {"mask": path}))
    return None


def with_file(document: Document, role: str, name: str | None) -> Document:
    """Return the document with another file for a role of the relief."""
    files = dataclasses.replace(document.relief.files, **{role: name})
    relief = RecipeRelief(files, document.relief.options, document.relief.solid)
    return dataclasses.replace(document, relief=relief)


def use_as_detail(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Take the map of the layer at ``place`` away from the layers and use it as the detail map."""
    place = layers.place_of(message.get("place"))
    entry = layers.entry_at(room.now.layers, place)
    if not isinstance(entry, RecipeLayer) or len(room.now.layers) == 1:
        raise UsageError("a detail map needs another layer beside it, whose detail it is")
    room.do(with_file(layers.removed(room.now, place), "detail", entry.file))
    return None


def open_recipe(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Replace the document by the dropped recipe ``file``."""
    room.do(drops.opened_recipe(dropped(room, message.get("file")), room.now, room.store))
    return None


def dropped(room: Room, name: Any) -> Path:
    """Return the path of a file that was dropped.

    Raises
    ------
    UsageError
        If there is none of this name.
    """
    path = room.store.folder / name if isinstance(name, str) and name else room.store.folder
    if path.parent != room.store.folder or not path.is_file():
        raise UsageError(f"the page named the file {name!r}, which was not dropped; drop it again")
    return path
