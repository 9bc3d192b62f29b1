"""Read meshes from files: positions and triangles, checked; everything else in a file is ignored."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError, LimitError, NmaptoolError, UsageError, reason_of
from nmaptool.io.meshes.dae import read_dae
from nmaptool.io.meshes.faults import fault_in
from nmaptool.io.meshes.gltf import read_gltf
from nmaptool.io.meshes.headers import MeshFile, identify_mesh_file
from nmaptool.io.meshes.obj import read_obj
from nmaptool.io.meshes.off import read_off
from nmaptool.io.meshes.ply import read_ply
from nmaptool.io.meshes.polygons import Integers, recut
from nmaptool.io.meshes.stl import read_stl
from nmaptool.io.meshes.surface import Surface
from nmaptool.io.meshes.threemf import read_3mf
from nmaptool.io.meshes.usd import read_usd
from nmaptool.types.mesh import Mesh

MAX_FACES = 20_000_000
_MM = {"mm": 1.0, "cm": 10.0, "in": 25.4, "m": 1000.0}
_LARGEST_INDEX = 2**31 - 1
_READERS: dict[str, Callable[[MeshFile, int], Surface]] = {
    "obj": read_obj,
    "ply": read_ply,
    "stl": read_stl,
    "off": read_off,
    "glb": read_gltf,
    "gltf": read_gltf,
    "3mf": read_3mf,
    "dae": read_dae,
    "usd": read_usd,
}


def read_mesh(path: str | Path, *, unit: str | None = None, max_faces: int = MAX_FACES) -> Mesh:
    """Read the triangles of a mesh file.

    Polygons are cut into triangles, and the transforms of a scene are applied, with morph targets and skins at rest.
    Colours, normals, texture coordinates, textures and materials are ignored. The only other files that are opened are
    the buffers of a glTF and the layers of a USD in the same folder. Vertices may be NaN; see
    `nmaptool.meshes.clean.clean_mesh`.

    Parameters
    ----------
    path : str or Path
        OBJ, PLY, STL, OFF, GLB, glTF, 3MF, DAE or USD. Some need an extra package, which the message names.
    unit : str, optional
        Unit of the coordinates in the file: ``mm``, ``cm``, ``in`` or ``m``. Default: metres for GLB and glTF, as their
        specification requires, the unit in 3MF, DAE and USD files, and millimetres for the other formats, which do not
        state a unit.
    max_faces : int
        Refuse files with more faces, before loading them.

    Returns
    -------
    Mesh
        With the vertices in the unit of the file, which ``mm_per_unit`` converts; its ``notes`` say what was ignored.

    Raises
    ------
    InputError
        If the file cannot be read, is damaged, or holds no faces.
    LimitError
        If it holds more than ``max_faces``, or does not fit in memory.
    UsageError
        If ``unit`` or ``max_faces`` is not valid.

    Examples
    --------
    >>> nm.read_mesh("samples/rings.ply", unit="mm")
    <Mesh samples/rings.ply: 12096 vertices, 24192 faces, 1 mm per unit (given)>
    """
    if unit is not None and unit not in _MM:
        raise UsageError(f"`unit={unit!r}`: use one of {', '.join(_MM)}")
    if max_faces < 1:
        raise UsageError(f"`max_faces={max_faces!r}`: must be at least 1")
    file = identify_mesh_file(Path(path))
    try:
        surface = _surface(file, max_faces)
        vertices, faces = surface.vertices, surface.triangles
        _check(file, vertices, faces, max_faces)
        faces = recut(vertices, faces, surface.made)
        vertices = np.ascontiguousarray(vertices, np.float64)
        small_faces = np.ascontiguousarray(faces, np.int32)
    except MemoryError:
        raise LimitError(f"{file.path}: does not fit in memory; decimate it") from None
    except OSError as error:
        raise InputError(f"{file.path}: cannot be read ({reason_of(error)})") from None
    in_file = surface.mm_per_unit
    mm_per_unit = _MM[unit] if unit else in_file or 1.0
    unit_from = "given" if unit else "file" if in_file else "assumed"
    up_from = "file" if surface.is_y_up else "assumed"
    return Mesh(vertices, small_faces, mm_per_unit, unit_from, str(path), surface.notes, up_from)


def _surface(file: MeshFile, max_faces: int) -> Surface:
    """Read the surface of a file of any format; its reader makes its own checks."""
    try:
        with np.errstate(all="ignore"):  # numbers are not checked yet
            return _READERS[file.kind](file, max_faces)
    except (MemoryError, OSError):
        raise
    except Exception as error:  # a damaged file may raise anything
        if isinstance(error, NmaptoolError) and str(error) != str(file.damaged):
            raise
        raise fault_in(file) from None


def _check_indices(file: MeshFile, vertices: Float64, faces: Integers) -> None:
    if len(faces):
        low, high = int(faces.min()), int(faces.max())
        if low < 0 or high >= len(vertices):
            raise file.names_missing_vertex(low if low < 0 else high, len(vertices))


def _check(file: MeshFile, vertices: Float64, faces: Integers, max_faces: int) -> None:
    file.check_limit(len(faces), max_faces)
    if not len(faces):
        raise file.holds_no_faces(len(vertices))
    if len(vertices) > _LARGEST_INDEX:
        raise LimitError(f"{file.path}: {len(vertices)} vertices, more than the limit of {_LARGEST_INDEX}; decimate it")
    _check_indices(file, vertices, faces)
