"""Triangles back from a file that was just written, by readers of exactly what the writers of this package write."""

from __future__ import annotations

import json
import re
import struct
from collections.abc import Iterator
from io import BufferedReader
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.io.solids.bands import Triangles, UnreadableError
from nmaptool.io.solids.ply import FACE, header_of
from nmaptool.io.solids.stl import CORNERS_AT, HEADER_BYTES, RECORD_BYTES
from nmaptool.io.solids.text_objects import objects_of_3mf, objects_of_obj

_BAND = 1 << 16
_PLY_COUNTS = re.compile(rb"element vertex (\d+)\n(?:.*\n)*?element face (\d+)\n")
_NO_POINTS: NDArray[np.float32] = np.empty((0, 3), np.float32)


def triangles_of(path: Path) -> Iterator[Triangles]:
    """The triangles of a file, in bands.

    Raises
    ------
    UnreadableError
        If the file has another form than the writers give it.
    """
    readers = {".stl": _of_stl, ".ply": _of_ply, ".glb": _of_glb, ".obj": objects_of_obj, ".3mf": objects_of_3mf}
    try:
        yield from readers[path.suffix.lower()](path)
    except (struct.error, ValueError, LookupError, TypeError):
        raise UnreadableError("its header has another form") from None


def _bands(file: BufferedReader, count: int, stride: int) -> Iterator[NDArray[np.uint8]]:
    """Up to ``count`` records from the place where a file is, in a buffer that is used again."""
    buffer = np.empty((min(count, _BAND), stride), np.uint8)
    while count > 0:
        band = buffer[: min(count, _BAND)]
        got = file.readinto(band.data) // stride
        if not got:
            return
        yield band[:got]
        count -= got


def _of_stl(path: Path) -> Iterator[Triangles]:
    with path.open("rb") as file:
        (stated,) = struct.unpack("<I", file.read(HEADER_BYTES)[-4:])
        held = (path.stat().st_size - HEADER_BYTES) // RECORD_BYTES
        for records in _bands(file, held, RECORD_BYTES):
            yield Triangles(_NO_POINTS, records, CORNERS_AT)
    if held != stated:
        raise UnreadableError(f"it holds {held} triangles instead of {stated}")
    _check_size(path, HEADER_BYTES + held * RECORD_BYTES)


def _of_ply(path: Path) -> Iterator[Triangles]:
    with path.open("rb") as file:
        head = file.read(1 << 10)
        counts = _PLY_COUNTS.search(head)
        vertex_count, face_count = (int(counts[1]), int(counts[2])) if counts else (0, 0)
        header = header_of(vertex_count, face_count)
        if not head.startswith(header):
            raise UnreadableError("its header has another form")
        _check_size(path, len(header) + 12 * vertex_count + FACE.itemsize * face_count)
        file.seek(len(header))
        points = np.fromfile(file, "<f4", 3 * vertex_count).reshape(-1, 3)
        for records in _bands(file, face_count, FACE.itemsize):
            if not (records[:, 0] == 3).all():
                raise UnreadableError("it has faces that are not triangles")
            yield Triangles(points, records, 1)


def _check_size(path: Path, wanted: int) -> None:
    found = path.stat().st_size
    if found != wanted:
        raise UnreadableError(f"it has {found} bytes instead of {wanted}")


def _of_glb(path: Path) -> Iterator[Triangles]:
    with path.open("rb") as file:
        magic, version, total, text_size, kind = struct.unpack("<4sIII4s", file.read(20))
        if (magic, version, kind) != (b"glTF", 2, b"JSON"):
            raise UnreadableError("its header has another form")
        _check_size(path, total)
        scene = json.loads(file.read(text_size))
        data_size, kind = struct.unpack("<I4s", file.read(8))
        start = file.tell()
        if kind != b"BIN\0" or start + data_size != total or scene["buffers"] != [{"byteLength": data_size}]:
            raise UnreadableError("its header has another form")
        for node in scene["nodes"]:
            (primitive,) = scene["meshes"][node["mesh"]]["primitives"]
            place, points = _accessor(scene, primitive["attributes"]["POSITION"], "VEC3", 12)
            file.seek(start + place)
            vertices = np.fromfile(file, "<f4", 3 * points["count"]).reshape(-1, 3)
            _check_bounds(vertices, points)
            place, indices = _accessor(scene, primitive["indices"], "SCALAR", 4)
            file.seek(start + place)
            for records in _bands(file, indices["count"] // 3, 12):
                yield Triangles(vertices, records, 0, 1000.0)


def _accessor(scene: dict[str, Any], number: int, kind: str, stride: int) -> tuple[int, dict[str, Any]]:
    """Where an array begins in the data, and its description."""
    accessor = scene["accessors"][number]
    view = scene["bufferViews"][accessor["bufferView"]]
    wanted_type = 5126 if kind == "VEC3" else 5125
    if (accessor["type"], accessor["componentType"], accessor["count"] * stride) != (
        kind,
        wanted_type,
        view["byteLength"],
    ):
        raise UnreadableError("its arrays have another form")
    return int(view["byteOffset"]), accessor


def _check_bounds(vertices: NDArray[np.float32], accessor: dict[str, Any]) -> None:
    """Viewers place their camera by the stated bounds."""
    columns = [vertices[:, axis] for axis in range(3)]  # NumPy is slow on rows of three
    found = {"min": [float(each.min()) for each in columns], "max": [float(each.max()) for each in columns]}
    if any(accessor[name] != values for name, values in found.items()):
        raise UnreadableError("its bounds are not those of its vertices")
