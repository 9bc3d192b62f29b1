"""Requests of the camera panel: open a mesh, bake it in the background, and bake it again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from nmaptool.baking.bake import bake as baked
from nmaptool.core.errors import UsageError
from nmaptool.core.progress import Progress, part
from nmaptool.io.pictures.layer_pictures import NORMAL_LAYERS, layer_picture
from nmaptool.io.pictures.writer import write_pictures
from nmaptool.studio import layers
from nmaptool.studio.document import relative
from nmaptool.studio.files.adding import dropped, with_layer
from nmaptool.studio.files.store import Store
from nmaptool.studio.forms.given import in_words
from nmaptool.studio.meshes import open_meshes as meshes
from nmaptool.studio.meshes.open_meshes import BakeOrder, OpenMesh, Origin
from nmaptool.studio.room import Room
from nmaptool.studio.windows import Message
from nmaptool.types.layer_set import LayerSet
from nmaptool.types.recipe import Entry, RecipeLayer


@dataclass(frozen=True)
class Target:
    """The layer whose map is replaced: where it was, and the file that it had."""

    place: layers.Place
    file: str


def open_mesh(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Open the mesh ``file``, which was dropped; the page that asked then shows the camera panel."""
    return room.sources.open(dropped(room, message.get("file")))


def close_mesh(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Forget the mesh ``id``; the layers that were baked from it stay."""
    room.sources.meshes.close(message.get("id"))
    return None


def bake(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Bake the mesh ``id`` with ``values``; ``place`` names a layer that gets the map, otherwise it becomes a layer."""
    one = room.sources.meshes.ready(message.get("id"))
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
        room.sources.origins[str(files["original"])] = Origin(one.id, dict(values or {}))
        room.sources.details.add(files["original"], files["detail"])
        return _taken(room, one, made, files["original"], target)

    room.sources.background.start("bake", f"bake {one.name}", work, then)
    return None


def cancel_bake(room: Room, _: Mapping[str, Any]) -> Message | None:
    """Cancel what runs in the background."""
    room.sources.background.cancel()
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
    origin = room.sources.origins.get(file)
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
    follows = room.sources.details.can_follow(document)
    room.do(room.sources.details.followed(changed) if follows else changed)
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
    maps = layers.maps_of(entries, with_hidden=True)
    places = [place for place, entry in maps if str(folder / entry.file) == target.file]
    return target.place if target.place in places else next(iter(places), None)
