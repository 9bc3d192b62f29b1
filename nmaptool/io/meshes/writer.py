"""Write meshes through trimesh, in millimetres; GLB in metres."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import OutputError, reason_of
from nmaptool.options.formats import MESH_FORMATS, check_ending
from nmaptool.types.mesh import Mesh


def write_mesh(mesh: Mesh, path: Path) -> None:
    """Write a mesh: binary STL, binary PLY or OBJ in mm, or GLB in metres, as its specification requires.

    Parameters
    ----------
    mesh : Mesh
    path : Path

    Raises
    ------
    UsageError
        If the extension is not supported.
    OutputError
        If it cannot be written.
    """
    check_ending(path, MESH_FORMATS, "meshes")
    (MESH_FORMATS[path.suffix.lower()].write or _write_triangles)(mesh, path)


def _write_triangles(mesh: Mesh, path: Path) -> None:
    import trimesh

    kind = path.suffix.lower()
    in_metres = kind == ".glb"
    vertices = mesh.vertices_mm / 1000 if in_metres else mesh.vertices_mm
    shape = trimesh.Trimesh(vertices, mesh.faces, process=False, metadata={"units": "m" if in_metres else "mm"})
    # OBJ is written with fixed decimals, which must suffice for a mesh of any size
    decimals = {"digits": _decimals(vertices)} if kind == ".obj" else {}
    data = shape.export(file_type=kind[1:], **decimals)
    try:
        path.write_bytes(data.encode() if isinstance(data, str) else data)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({reason_of(error)})") from None


def _decimals(vertices: Float64) -> int:
    """The decimals that resolve 1e-9 of the largest coordinate, at least 8."""
    largest = float(np.abs(vertices).max(initial=0.0))
    return 8 if not largest > 0 else max(8, 9 - math.floor(math.log10(largest)))
