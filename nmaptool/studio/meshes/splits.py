"""Requests about the detail map of a document: split it off the composed layers, or take those of the bakes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from nmaptool.composition.compose import compose
from nmaptool.core.progress import Progress, part
from nmaptool.filters.split import split
from nmaptool.io.pictures.layer_pictures import layer_picture
from nmaptool.io.pictures.writer import write_pictures
from nmaptool.io.recipes.stacks import read_stack
from nmaptool.options import SplitOptions
from nmaptool.studio.document import relative
from nmaptool.studio.files.adding import with_file
from nmaptool.studio.forms.given import options_from
from nmaptool.studio.meshes.details import Split, content_of
from nmaptool.studio.room import Room
from nmaptool.studio.windows import Message


def split_detail(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Split the composed map with ``values`` as `nmap compose split` does, and use its detail as the detail map."""
    values = dict(message.get("values") or {})
    options = options_from(SplitOptions, values)
    document = room.now
    recipe = document.recipe

    def work(progress: Progress) -> tuple[Path, float]:
        stack = read_stack(recipe, folder=document.folder)
        composed = compose(stack.layers, stack.canvas, progress=part(progress, 0.0, 0.2))
        made = split(composed.normal_map, options, progress=part(progress, 0.2, 0.95))
        path = room.store.place(f"{Path(document.name).stem}-detail.exr")
        write_pictures([layer_picture(made, "detail", floating=True)], path)
        return path, made.report.detail_share

    def then(result: tuple[Path, float]) -> str:
        path, share = result
        room.sources.splits[str(path)] = Split(content_of(document), values)
        room.do(with_file(room.now, "detail", relative(path, room.now.folder)))
        return f"{path.name}: {share:.0%} of the picture is detail; mu sets how much of it is kept"

    room.sources.background.start("detail", "split off the detail", work, then)
    return None


def follow_details(room: Room, _: Mapping[str, Any]) -> Message | None:
    """Use the detail maps of the layers that were baked, placed like the layers."""
    room.do(room.sources.details.followed(room.now))
    return None
