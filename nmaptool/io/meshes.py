"""Meshes through trimesh, in millimetres."""

from __future__ import annotations

from pathlib import Path

from nmaptool.errors import OutputError, UsageError, reason_of
from nmaptool.mesh import Mesh

ENDINGS = (".stl", ".ply", ".obj", ".glb")


def write_mesh(path: Path, mesh: Mesh) -> None:
    """Write triangles: binary STL and PLY, OBJ, or GLB, all with coordinates in mm.

    Parameters
    ----------
    path : Path
    mesh : Mesh

    Raises
    ------
    UsageError
        If the ending is not offered.
    OutputError
        If it cannot be written.
    """
    kind = path.suffix.lower()
    if kind not in ENDINGS:
        raise UsageError(f"{path}: meshes are written as {', '.join(ENDINGS)}")
    import trimesh

    shape = trimesh.Trimesh(mesh.vertices_mm, mesh.faces, process=False, metadata={"units": "mm"})
    data = shape.export(file_type=kind[1:])
    try:
        path.write_bytes(data.encode() if isinstance(data, str) else data)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({reason_of(error)})") from None
