"""Requests that paint: each stroke writes a new 16-bit picture, so that undo only names the one before."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from nmaptool.core.arrays import Float32
from nmaptool.core.errors import InputError, UsageError
from nmaptool.io.output.map_pictures import mask_picture
from nmaptool.io.pictures.normal_maps import read_grey
from nmaptool.io.pictures.writer import write_pictures
from nmaptool.studio.adding import with_file
from nmaptool.studio.document import relative
from nmaptool.studio.room import Room
from nmaptool.studio.strokes import Brush, stroke
from nmaptool.studio.windows import Message

ROLES = ("mask", "mu_map", "beta_map", "delta_map")
# longer side of the pictures that the page shows over the relief
_SHOWN_PX = 1024
# pictures that are kept in memory, besides the newest
_KEPT = 7


def paint(room: Room, message: Mapping[str, Any]) -> Message | None:
    """Paint a stroke on the picture of a ``role``: ``points`` of across, down and pressure in px of the map."""
    role = _role(message.get("role"))
    given = message.get("brush")
    if not isinstance(given, Mapping) or not {*given} <= {f.name for f in dataclasses.fields(Brush)}:
        raise UsageError("the page sent no brush; reload it")
    try:
        numbers: dict[str, Any] = {key: value if key == "tool" else float(value) for key, value in given.items()}
        points = np.asarray(message.get("points"), float)
    except (TypeError, ValueError):
        raise UsageError("the page sent a stroke that is not one; reload it") from None
    original = plain_picture(room, role)
    grey = painted(room, role)
    changed = stroke(grey, Brush(**numbers), points, original)
    if np.array_equal(changed, grey):
        return None
    path = room.store.place(f"{role.replace('_', '-')}.png")
    write_pictures([mask_picture(changed)], path)
    room.painted = {**dict(list(room.painted.items())[-_KEPT:]), str(path): changed}
    room.do(with_file(room.now, role, relative(path, room.now.folder)))
    return None


def painted(room: Room, role: str) -> Float32:
    """Return the picture of a role as it is: (H, W) float32 in [0, 1].

    Raises
    ------
    InputError
        If its file cannot be read or has another size than the map.
    """
    named = getattr(room.now.relief.files, role)
    if named is None:
        return plain_picture(room, role)
    path = str(room.now.folder / named)
    if path in room.painted:
        return room.painted[path]
    grey = read_grey(path)
    shape = plain_picture(room, role).shape
    if grey.shape != shape:
        found, wanted = (f"{size[1]} x {size[0]} px" for size in (grey.shape, shape))
        raise InputError(f"{Path(named).name}: is {found}, the map {wanted}; remove it to paint a new one")
    return grey


def plain_picture(room: Room, role: str) -> Float32:
    """Return the picture of a role when nothing is painted: for a mask the motif, otherwise white.

    Raises
    ------
    UsageError
        If no map has been read yet.
    """
    motif = room.motif
    if motif is None:
        raise UsageError("there is nothing to paint on yet; wait for the picture")
    return motif.astype(np.float32) if role == "mask" else np.ones(motif.shape, np.float32)


def picture_of(room: Room, role: str) -> bytes:
    """Return the picture of a role as an 8-bit PNG of at most 1024 px, for the page.

    Raises
    ------
    UsageError, InputError
        If there is no such role or no picture.
    """
    grey = painted(room, _role(role))
    share = _SHOWN_PX / max(grey.shape)
    if share < 1:
        size = max(1, round(grey.shape[1] * share)), max(1, round(grey.shape[0] * share))
        grey = np.asarray(cv2.resize(grey, size, interpolation=cv2.INTER_AREA), np.float32)
    done, data = cv2.imencode(".png", np.rint(255 * grey).astype(np.uint8), [cv2.IMWRITE_PNG_COMPRESSION, 1])
    assert done
    return bytes(data)


def _role(role: Any) -> str:
    if role not in ROLES:
        raise UsageError(f"the page named {role!r}, which cannot be painted; reload it")
    return str(role)
