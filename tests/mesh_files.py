"""A small solid in every readable format, written by hand so that a test's own fault is the only one in the file."""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Sequence
from typing import Any

import numpy as np

# a tetrahedron of volume 1, counter-clockwise seen from outside
VERTICES = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]], np.float32)
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], np.int32)
ENDINGS = ("obj", "ply", "stl", "off", "glb", "gltf")


def volume(mesh: Any) -> float:
    """Signed volume: negative for a mesh that is inside out."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def obj(vertices: Any = VERTICES, polygons: Any = FACES) -> bytes:
    """OBJ with positions and polygons only."""
    lines = [f"v {x:g} {y:g} {z:g}" for x, y, z in vertices]
    lines += ["f " + " ".join(str(i + 1) for i in polygon) for polygon in polygons]
    return ("\n".join(lines) + "\n").encode()


def off(vertices: Any = VERTICES, polygons: Any = FACES, counts: Any = None) -> bytes:
    """OFF; ``counts`` replace the true numbers in the header."""
    n, m = counts or (len(vertices), len(polygons))
    lines = ["OFF", f"{n} {m} 0"]
    lines += [f"{x:g} {y:g} {z:g}" for x, y, z in vertices]
    lines += [f"{len(p)} " + " ".join(map(str, p)) for p in polygons]
    return ("\n".join(lines) + "\n").encode()


def stl(vertices: Any = VERTICES, faces: Any = FACES, header: bytes = b"", count: int | None = None) -> bytes:
    """Binary STL."""
    body = b"".join(struct.pack("<12fH", 0, 0, 1, *np.ravel(vertices[face]), 0) for face in faces)
    return header.ljust(80, b"\0") + struct.pack("<I", len(faces) if count is None else count) + body


def ascii_stl(vertices: Any = VERTICES, faces: Any = FACES, name: str = "thing") -> bytes:
    """ASCII STL as most programs write it."""
    text = f"solid {name}\n"
    for face in faces:
        corners = "".join(f"      vertex {x:g} {y:g} {z:g}\n" for x, y, z in vertices[face])
        text += f"  facet normal 0 0 1\n    outer loop\n{corners}    endloop\n  endfacet\n"
    return (text + f"endsolid {name}\n").encode()


def ply_header(kind: str, *elements: tuple[str, int, Sequence[str]]) -> bytes:
    """Header of named elements, each with its number of rows and its properties."""
    lines = ["ply", f"format {kind} 1.0", "comment made by hand"]
    for name, rows, properties in elements:
        lines += [f"element {name} {rows}", *(f"property {p}" for p in properties)]
    return ("\n".join([*lines, "end_header"]) + "\n").encode()


XYZ = ("float x", "float y", "float z")
LIST = ("list uchar int vertex_indices",)


def ply(
    vertices: Any = VERTICES, polygons: Any = FACES, kind: str = "binary_little_endian", counts: Any = None
) -> bytes:
    """PLY as text or binary, with polygons of any size; ``counts`` replace the true numbers in the header."""
    n, m = counts or (len(vertices), len(polygons))
    head = ply_header(kind, ("vertex", n, XYZ), ("face", m, LIST))
    if kind == "ascii":
        lines = [f"{x:g} {y:g} {z:g}" for x, y, z in vertices]
        lines += [f"{len(p)} " + " ".join(map(str, p)) for p in polygons]
        return head + ("\n".join(lines) + "\n").encode()
    order = "<" if "little" in kind else ">"
    body = b"".join(struct.pack(f"{order}3f", *v) for v in vertices)
    return head + body + b"".join(struct.pack(f"{order}B{len(p)}i", len(p), *p) for p in polygons)


def tree(vertices: Any = VERTICES, faces: Any = FACES, **changes: Any) -> tuple[dict[str, Any], bytes]:
    """The JSON of a glTF with one mesh on one node, and its binary data; ``changes`` replace parts of the JSON."""
    positions = np.asarray(vertices, "<f4").tobytes()
    indices = np.asarray(faces, "<u2").tobytes()
    made = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": len(positions) + len(indices)}],
        "bufferViews": [
            {"buffer": 0, "byteLength": len(positions)},
            {"buffer": 0, "byteOffset": len(positions), "byteLength": len(indices)},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(vertices), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": np.size(faces), "type": "SCALAR"},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
    }
    return {**made, **changes}, positions + indices


def glb(content: tuple[dict[str, Any], bytes] | None = None) -> bytes:
    """GLB: one binary file."""
    json_tree, data = content or tree()
    text = json.dumps(json_tree).encode()
    text += b" " * (-len(text) % 4)
    data += bytes(-len(data) % 4)
    head = struct.pack("<4sIIII", b"glTF", 2, 28 + len(text) + len(data), len(text), 0x4E4F534A)
    return head + text + struct.pack("<II", len(data), 0x004E4942) + data


def gltf(content: tuple[dict[str, Any], bytes] | None = None) -> bytes:
    """glTF as one text file with embedded data."""
    json_tree, data = content or tree()
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    buffers = [{"uri": uri, **json_tree["buffers"][0]}, *json_tree["buffers"][1:]]
    return json.dumps({**json_tree, "buffers": buffers}).encode()


def good() -> dict[str, bytes]:
    """The tetrahedron in each format."""
    return {"obj": obj(), "ply": ply(), "stl": stl(), "off": off(), "glb": glb(), "gltf": gltf()}
