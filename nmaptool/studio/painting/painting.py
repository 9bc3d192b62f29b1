"""Requests that paint: each stroke writes a new 16-bit picture, so that undo only names the one before."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from nmaptool.core.arrays import Float32
from nmaptool.core.errors import InputError, UsageError
from nmaptool.io.output.map_pictures import mask_picture
from nmaptool.io.pictures.normal_maps import read_grey
from nmaptool.io.pictures.writer import write_pictures
from nmaptool.studio import layers
from nmaptool.studio.document import Document, relative
from nmaptool.studio.files.adding import with_file
from nmaptool.studio.painting.strokes import Brush, stroke
from nmaptool.studio.room import Room
from nmaptool.studio.windows import Message

ROLES = ("mask", "mu_map", "beta_map", "delta_map")
LAYER_MASK = "layer-mask"
# longer side of the pictures that the page shows over the relief
_SHOWN_PX = 1024
# pictures that are kept in memory, besides the newest
_KEPT = 7


@dataclass(frozen=True)
class _Sheet:
    """What is painted on: a role of the relief, or the mask of a layer.

    Attributes
    ----------
    stem : str
        Name of its files, without the ending.
    file : str or None
        Its picture, as the document names it; None: none yet.
    plain : (H, W) float32
        The picture while there is no file: for a mask the motif, otherwise white.
    put : callable
        Returns the document with another file.
    """

    stem: str
    file: str | None
    plain: Float32
    put: Callable[[str], Document]


def _sheet(room: Room, role: Any, place: Any) -> _Sheet:
    """Return the sheet that a page named; a layer's mask has the size of its map.

    Raises
    ------
    UsageError
        If there is no such role, or no map has been read yet.
    """
    now, motif = room.now, room.motif
    if role != LAYER_MASK and role not in ROLES:
        raise UsageError(f"the page named {role!r}, which cannot be painted; reload it")
    if motif is None:
        raise UsageError("there is nothing to paint on yet; wait for the picture")
    if role in ROLES:
        plain = motif.astype(np.float32) if role == "mask" else np.ones(motif.shape, np.float32)
        file = getattr(now.relief.files, role)
        return _Sheet(role.replace("_", "-"), file, plain, lambda name: with_file(now, role, name))
    at = layers.place_of(place)
    entry = layers.entry_at(now.layers, at)
    shape = room.map_shape(at)
    if shape is None:
        raise UsageError("only a layer with a map that is shown has a mask to paint; choose one")
    put = partial(layers.edited, now, at)
    return _Sheet(LAYER_MASK, entry.mask, np.ones(shape, np.float32), lambda name: put({"mask": name}))


def paint(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Paint a stroke on the picture of a ``role``: ``points`` of across, down and pressure in px of that picture."""
    sheet = _sheet(room, message.get("role"), message.get("place"))
    given = message.get("brush")
    if not isinstance(given, Mapping) or not {*given} <= {f.name for f in dataclasses.fields(Brush)}:
        raise UsageError("the page sent no brush; reload it")
    try:
        numbers: dict[str, Any] = {key: value if key == "tool" else float(value) for key, value in given.items()}
        points = np.asarray(message.get("points"), float)
    except (TypeError, ValueError):
        raise UsageError("the page sent a stroke that is not one; reload it") from None
    grey = _grey(room, sheet)
    changed = stroke(grey, Brush(**numbers), points, sheet.plain)
    if np.array_equal(changed, grey):
        return None
    path = room.store.place(f"{sheet.stem}.png")
    write_pictures([mask_picture(changed)], path)
    room.painted = {**dict(list(room.painted.items())[-_KEPT:]), str(path): changed}
    room.do(sheet.put(relative(path, room.now.folder)))
    return None


def _grey(room: Room, sheet: _Sheet) -> Float32:
    """Return the picture of a sheet as it is: (H, W) float32 in [0, 1].

    Raises
    ------
    InputError
        If its file cannot be read or has another size.
    """
    if sheet.file is None:
        return sheet.plain
    path = str(room.now.folder / sheet.file)
    if path in room.painted:
        return room.painted[path]
    grey = read_grey(path)
    if grey.shape != sheet.plain.shape:
        found, wanted = (f"{shape[1]} x {shape[0]} px" for shape in (grey.shape, sheet.plain.shape))
        raise InputError(f"{Path(sheet.file).name}: is {found}, the map {wanted}; remove it to paint a new one")
    return grey


def picture_of(room: Room, role: str, place: str = "") -> bytes:
    """Return the picture of a role as an 8-bit PNG of at most 1024 px, for the page; ``place`` is a layer's, as "1,0".

    Raises
    ------
    UsageError, InputError
        If there is no such role or no picture.
    """
    numbers = [int(number) if number.isdecimal() else -1 for number in place.split(",")]
    grey = _grey(room, _sheet(room, role, numbers))
    share = _SHOWN_PX / max(grey.shape)
    if share < 1:
        size = max(1, round(grey.shape[1] * share)), max(1, round(grey.shape[0] * share))
        grey = np.asarray(cv2.resize(grey, size, interpolation=cv2.INTER_AREA), np.float32)
    done, data = cv2.imencode(".png", np.rint(255 * grey).astype(np.uint8), [cv2.IMWRITE_PNG_COMPRESSION, 1])
    assert done
    return bytes(data)
