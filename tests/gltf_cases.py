"""glTF scenes made by hand, array by array."""

from __future__ import annotations

from typing import Any

import numpy as np

SHAPES = {1: "SCALAR", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
KINDS = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}


class Builder:
    """A glTF whose arrays are added one by one; ``content`` is what `mesh_files.glb` takes."""

    def __init__(self) -> None:
        self.data = b""
        self.tree: dict[str, Any] = {"asset": {"version": "2.0"}, "bufferViews": [], "accessors": []}

    def view(self, array: Any, dtype: str) -> int:
        """Add the bytes of an array as a buffer view."""
        body = np.ascontiguousarray(array, f"<{dtype}").tobytes()
        self.tree["bufferViews"].append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(body)})
        self.data += body + bytes(-len(body) % 4)
        return len(self.tree["bufferViews"]) - 1

    def add(self, array: Any, dtype: str = "f4", **more: Any) -> int:
        """Add an array as an accessor."""
        rows = np.asarray(array)
        width = 1 if rows.ndim == 1 else int(np.prod(rows.shape[1:]))
        made = {
            "bufferView": self.view(rows, dtype),
            "componentType": KINDS[dtype],
            "count": len(rows),
            "type": SHAPES[width],
        }
        self.tree["accessors"].append({**made, **more})
        return len(self.tree["accessors"]) - 1

    def sparse(self, count: int, places: Any, values: Any, base: Any = None, kind: str = "u2") -> int:
        """Add an array of zeros, or of ``base``, that differs at some places."""
        index = self.add(np.zeros((0, 3)) if base is None else base)
        accessor = self.tree["accessors"][index]
        if base is None:
            del accessor["bufferView"]
        accessor |= {
            "count": count,
            "sparse": {
                "count": len(places),
                "indices": {"bufferView": self.view(places, kind), "componentType": KINDS[kind]},
                "values": {"bufferView": self.view(values, "f4")},
            },
        }
        return index

    def content(self, nodes: Any = None, **parts: Any) -> tuple[dict[str, Any], bytes]:
        """The JSON with one node of mesh 0 unless nodes are given, and the binary data."""
        nodes = nodes or [{"mesh": 0}]
        shown = {"nodes": nodes, "scenes": [{"nodes": [0]}], "buffers": [{"byteLength": len(self.data)}]}
        return {**self.tree, **shown, **parts}, self.data
