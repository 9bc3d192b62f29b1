"""Meshes as bytes for the page, thinned if they are too large to be displayed."""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.types.mesh import Faces, Mesh

# triangles that the page draws at most
MOST_TRIANGLES = 500_000
_TRIES = 8


def display_mesh(mesh: Mesh, facts: Mapping[str, Any], corners: Float64, most: int = MOST_TRIANGLES) -> bytes:
    """Return the bytes of a mesh for the page.

    The first four are the length of the header, little-endian; it is padded so that what follows begins at a multiple
    of eight: float64 corners of the mesh's convex hull, float32 positions from ``origin``, uint32 triangles.

    Parameters
    ----------
    mesh : Mesh
        Cleaned.
    facts : mapping
        More entries of the header.
    corners : (N, 3) float64
        Of the convex hull.
    most : int
        Triangles; larger meshes are thinned.
    """
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    origin = (low + high) / 2
    vertices, faces = thinned(mesh.vertices, mesh.faces, most)
    header = {
        "corners": len(corners),
        "vertices": len(vertices),
        "triangles": len(faces),
        "all_triangles": len(mesh.faces),
        "origin": origin.tolist(),
        "low": low.tolist(),
        "high": high.tolist(),
        **facts,
    }
    text = json.dumps(header).encode()
    text += b" " * (-(4 + len(text)) % 8)
    return b"".join(
        [
            struct.pack("<I", len(text)),
            text,
            corners.astype("<f8").tobytes(),
            (vertices - origin).astype("<f4").tobytes(),
            faces.astype("<u4").tobytes(),
        ]
    )


def thinned(vertices: Float64, faces: Faces, most: int) -> tuple[Float64, Faces]:
    """Return at most so many triangles: vertices in the same cell of a grid become their mean.

    Faces between fewer than three cells vanish, and so do repeated ones. The page does not need their winding.
    """
    if len(faces) <= most:
        return vertices, faces
    low = vertices.min(axis=0)
    longest = float(np.ptp(vertices, axis=0).max())
    cells = math.sqrt(most / 2)
    best: tuple[NDArray[np.int64], Faces] | None = None
    for _ in range(_TRIES):
        cell = _cells(vertices - low, longest / cells)
        found = _between(cell, faces)
        if len(found) <= most and (best is None or len(found) > len(best[1])):
            best = cell, found
        if 0.85 * most <= len(found) <= most:
            break
        cells *= math.sqrt(0.93 * most / max(len(found), 1))
    while best is None:
        cells *= 0.7
        cell = _cells(vertices - low, longest / cells)
        found = _between(cell, faces)
        best = (cell, found) if len(found) <= most else None
    cell, found = best
    count = np.bincount(cell)
    means = np.column_stack([np.bincount(cell, column) for column in vertices.T]) / count[:, None]
    return means, found


def _cells(positions: Float64, side: float) -> NDArray[np.int64]:
    """Return the number of each position's cell, from 0; cells without positions have none."""
    at = (positions / side).astype(np.int64)
    x, y, _ = (at.max(axis=0) + 1).tolist()
    return np.asarray(np.unique(at[:, 0] + x * (at[:, 1] + y * at[:, 2]), return_inverse=True)[1]).ravel()


def _between(cell: NDArray[np.int64], faces: Faces) -> Faces:
    """Return the faces between three different cells, each once, in no particular winding."""
    a, b, c = np.sort(cell.take(faces), axis=1).T
    apart = (a != b) & (b != c)
    first, last = a[apart] << 32 | b[apart], c[apart]
    order = np.lexsort((last, first))
    first, last = first[order], last[order]
    once = np.ones(len(order), bool)
    once[1:] = (first[1:] != first[:-1]) | (last[1:] != last[:-1])
    first, last = first[once], last[once]
    return np.column_stack([first >> 32, first & 0xFFFFFFFF, last]).astype(np.int32)
