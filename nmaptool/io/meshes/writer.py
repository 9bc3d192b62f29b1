"""Write meshes, in millimetres; GLB in metres."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from nmaptool.io.solids.writer import write_solid
from nmaptool.options.formats import MESH_FORMATS, check_ending
from nmaptool.types.mesh import Mesh
from nmaptool.types.solid import Body, Part, Solid


def write_mesh(mesh: Mesh, path: Path) -> None:
    """Write a mesh: binary STL, binary PLY, OBJ or 3MF in mm, or GLB in metres, as its specification requires.

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
    write = MESH_FORMATS[path.suffix.lower()].write
    if write is not None:
        write(mesh, path)
    else:
        write_solid(_as_solid(mesh), path, title=mesh.name, is_checked=False)


def _as_solid(mesh: Mesh) -> Solid:
    vertices = mesh.vertices_mm
    part = Part(vertices, mesh.faces, np.arange(len(vertices)), keeps_unused=True)
    body = Body("mesh", lambda: iter([part]), len(mesh.faces), len(vertices))
    low, high = np.nan_to_num(vertices).min(axis=0, initial=0.0), np.nan_to_num(vertices).max(axis=0, initial=0.0)
    return Solid((body,), False, np.stack([low, high]))
