"""Binary glTF, band by band."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from nmaptool.core.errors import LimitError
from nmaptool.types.solid import NumberedBody, Solid

_LARGEST = 2**32 - 1
_FLOAT, _UINT = 5126, 5125
_VERTICES, _INDICES = 34962, 34963


def write_glb(solid: Solid, path: Path) -> None:
    """Write every body as a mesh of a GLB file, in metres as its specification says.

    Raises
    ------
    LimitError
        If it would be larger than the 4 GiB that GLB can hold.
    """
    bodies = [NumberedBody.of(body, is_measured=True) for body in solid.bodies]
    scene, size = _scene(solid, bodies)
    text = json.dumps(scene, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + 8 + size
    if total > _LARGEST:
        raise LimitError(
            f"{path}: would be {total / 1e9:.1f} GB, more than the 4.3 GB that GLB can hold; "
            "use .ply or .stl, or `max_error`"
        )
    with path.open("wb") as file:
        file.write(b"glTF" + np.array([2, total, len(text)], "<u4").tobytes() + b"JSON" + text)
        file.write(np.array([size], "<u4").tobytes() + b"BIN\0")
        for body in bodies:
            for vertices in body.vertices():
                file.write((vertices / 1000).astype("<f4").tobytes())
            for faces in body.faces():
                file.write(faces.astype("<u4").tobytes())


def _scene(solid: Solid, bodies: list[NumberedBody]) -> tuple[dict[str, Any], int]:
    """The description of the file, and the size of its data in bytes."""
    meshes, views, accessors, offset = [], [], [], 0
    for body in bodies:
        low, high = _bounds_m(body)
        for count, kind, stride, target, more in (
            (body.vertex_count, _FLOAT, 12, _VERTICES, {"type": "VEC3", "min": low, "max": high}),
            (3 * body.body.face_count, _UINT, 4, _INDICES, {"type": "SCALAR"}),
        ):
            views.append({"buffer": 0, "byteOffset": offset, "byteLength": count * stride, "target": target})
            accessors.append({"bufferView": len(views) - 1, "componentType": kind, "count": count, **more})
            offset += count * stride
        last = len(accessors) - 1
        meshes.append({"name": body.body.name, "primitives": [{"attributes": {"POSITION": last - 1}, "indices": last}]})
    nodes = [{"name": body.body.name, "mesh": number} for number, body in enumerate(bodies)]
    return {
        "asset": {"version": "2.0", "generator": "nmaptool"},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "nodes": nodes,
        "meshes": meshes,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": offset}],
    }, offset


def _bounds_m(body: NumberedBody) -> tuple[list[float], list[float]]:
    """Least and greatest coordinates, rounded as they are written."""
    low, high = (body.bounds_mm / 1000).astype(np.float32).astype(float).tolist()
    return low, high
