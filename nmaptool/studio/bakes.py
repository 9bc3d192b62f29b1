"""Requests of the camera panel: open a mesh, bake it in the background, and bake it again."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from nmaptool.baking.bake import bake as baked
from nmaptool.core.errors import UsageError
from nmaptool.core.progress import Progress, part
from nmaptool.io.pictures.layer_pictures import NORMAL_LAYERS, layer_picture
from nmaptool.io.pictures.writer import write_pictures
from nmaptool.options import LayerOptions
from nmaptool.studio import details, layers, meshes
from nmaptool.studio.adding import dropped, with_layer
from nmaptool.studio.document import relative
from nmaptool.studio.given import in_words
from nmaptool.studio.meshes import BakeOrder, OpenMesh
from nmaptool.studio.room import Message, Room
from nmaptool.studio.store import Store
from nmaptool.types.layer_set import LayerSet
from nmaptool.types.recipe import Entry, RecipeGroup, RecipeLayer


@dataclass(frozen=True)
class Origin:
    """What the map of a layer was baked from: a mesh, by its id, and the options of the page."""

    mesh: str
    values: Mapping[str, Any]


@dataclass(frozen=True)
class Target:
    """The layer whose map is replaced: where it was, and the file that it had."""

    place: layers.Place
    file: str


def open_mesh(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Open the mesh ``file``, which was dropped; the page that asked then shows the camera panel."""
    path = dropped(room, message.get("file"))
    return {"kind": "mesh", "id": meshes.opened(room, path), "name": path.name, "file": path.name}


def close_mesh(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Forget the mesh ``id``; the layers that were baked from it stay."""
    room.meshes.close(message.get("id"))
    return None


def bake(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Bake the mesh ``id`` with ``values``; ``place`` names a layer that gets the map, otherwise it becomes a layer."""
    one = room.meshes.ready(message.get("id"))
    values = message.get("values")
    order = BakeOrder.of(values)
    target = None if message.get("place") is None else _target(room, message, order)

    def work(progress: Progress) -> tuple[LayerSet, dict[str, Path]]:
        assert one.mesh is not None
        source = meshes.with_unit(one.mesh, order.reading.unit)
        made = baked(source, order.camera, order.filter, progress=part(progress, 0.0, 0.95))
        progress("writing", 0.95)
        return made, written(made, one.path.stem, room.store)

    def then(result: tuple[LayerSet, dict[str, Path]]) -> str:
        made, files = result
        room.origins[str(files["original"])] = Origin(one.id, dict(values or {}))
        room.details[str(files["original"])] = files["detail"]
        return _taken(room, one, made, files["original"], target)

    what = f"bake {one.name}"
    room.background.start("bake", what, work, then)
    return None


def cancel_bake(room: Room, _: Mapping[str, Any]) -> Message | None:
    """Cancel what runs in the background."""
    room.background.cancel()
    return None


def written(made: LayerSet, stem: str, store: Store) -> dict[str, Path]:
    """Write original, base and detail beside each other, as `nmap bake` writes them; return their paths."""
    files = {}
    for name in NORMAL_LAYERS:
        files[name] = store.place(f"{stem}-{name}.exr")
        write_pictures([layer_picture(made, name, floating=True)], files[name])
    return files


def _target(room: Room, message: Mapping[str, Any], order: BakeOrder) -> Target:
    place = layers.place_of(message["place"])
    entry = layers.entry_at(room.now.layers, place)
    file = str(room.now.folder / entry.file) if isinstance(entry, RecipeLayer) else ""
    origin = room.origins.get(file)
    if origin is None:
        raise UsageError("this layer was not baked since the studio was started; drop its mesh, and bake a new layer")
    before = BakeOrder.of(origin.values).camera
    if entry.mask is not None and (before.cols, before.rows) != (order.camera.cols, order.camera.rows):
        raise UsageError(
            f"`size={order.camera.size!r}`: the layer has a mask of {before.cols} x {before.rows} px; keep this size, "
            "or remove the mask"
        )
    return Target(place, file)


def _taken(room: Room, one: OpenMesh, made: LayerSet, original: Path, target: Target | None) -> str:
    """Put the map into the document, as one step; return a line about it."""
    document = room.now
    name = relative(original, document.folder)
    place = None if target is None else _found(document.layers, document.folder, target)
    if place is None:
        changed = with_layer(document, original, one.path.stem)
    else:
        changed = layers.edited(document, place, {"file": name})
    follows = details.can_follow(room, document)
    room.do(details.followed(room, changed) if follows else changed)
    report = made.report
    said = [f"{one.name}: {report.detail_share:.0%} of the surface is detail, rendered by {report.renderer}"]
    if target is not None and place is None:
        said.append("the layer is gone, so the map is a new one")
    if not follows:
        said.append("its detail is not used: the document has a detail map of its own")
    said += [in_words(warning) for warning in report.warnings]
    return "; ".join(said)


def _found(entries: Sequence[Entry], folder: Path, target: Target) -> layers.Place | None:
    """Return the place of a layer that may have been moved meanwhile; None if it is gone."""
    places = [place for place, entry in _maps(entries) if str(folder / entry.file) == target.file]
    return target.place if target.place in places else next(iter(places), None)


def _maps(entries: Sequence[Entry], above: layers.Place = ()) -> Iterator[tuple[layers.Place, RecipeLayer]]:
    """Yield all layers with a map, hidden ones, too."""
    for number, entry in enumerate(entries):
        if isinstance(entry, RecipeLayer):
            yield (*above, number), entry
        elif isinstance(entry, RecipeGroup):
            yield from _maps(entry.layers, (*above, number))


def state(room: Room) -> Message:
    """Return the open meshes, the layers that were baked from them, and what runs, for the page."""
    now = room.now
    made = []
    for place, entry in _maps(now.layers):
        origin = room.origins.get(str(now.folder / entry.file))
        if origin is not None:
            made.append({"place": place, "mesh": origin.mesh, "values": origin.values, "label": _label(entry)})
    return {"kind": "meshes", "meshes": room.meshes.shown, "layers": made, "running": room.background.message}


def _label(entry: RecipeLayer) -> str:
    default = LayerOptions().name
    return entry.options.name if entry.options.name != default else Path(entry.file).name
