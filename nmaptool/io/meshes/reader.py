"""Meshes from files: positions and triangles, checked; everything else in a file is left alone."""

from __future__ import annotations

import contextlib
import io
import logging
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError, LimitError, UsageError, reason_of
from nmaptool.io.meshes import gltf, ply
from nmaptool.io.meshes import text as mesh_text
from nmaptool.io.meshes.headers import STL_FACE, STL_HEADER, MeshFile, identify_mesh_file
from nmaptool.io.meshes.polygons import recut
from nmaptool.types.mesh import Mesh

MAX_FACES = 20_000_000
_MM = {"mm": 1.0, "cm": 10.0, "in": 25.4, "m": 1000.0}
_LARGEST_INDEX = 2**31 - 1
Integers = NDArray[np.int64]
Surface = tuple[Float64, Integers]


# of files that hold triangles only
_NO_POLYGONS: Integers = np.zeros(0, np.int64)


def read_mesh(path: str | Path, *, unit: str | None = None, max_faces: int = MAX_FACES) -> Mesh:
    """Read the triangles of a mesh file.

    Polygons are cut into triangles, the parts of a scene put in their places. Colours, normals, texture coordinates,
    textures and materials are ignored, and no other file is ever opened. Vertices may be NaN; see
    `nmaptool.meshes.clean.clean_mesh`.

    Parameters
    ----------
    path : str or Path
        OBJ, PLY, STL, OFF, GLB or glTF with its data inside.
    unit : str, optional
        What one unit of the file is: ``mm``, ``cm``, ``in`` or ``m``. Default: metres for GLB and glTF, as their
        specification says, and millimetres for the others, which do not say.
    max_faces : int
        Refuse more before they are loaded.

    Returns
    -------
    Mesh
        With the vertices as the file has them, and ``mm_per_unit`` beside.

    Raises
    ------
    InputError
        If the file cannot be read, is damaged, or holds no faces.
    LimitError
        If it holds more than ``max_faces``, or does not fit in memory.
    UsageError
        If ``unit`` or ``max_faces`` cannot be meant.

    Examples
    --------
    >>> nm.read_mesh("samples/rings.ply", unit="mm")
    <Mesh samples/rings.ply: 12096 vertices, 24192 faces, 1 mm to a unit (given)>
    """
    if unit is not None and unit not in _MM:
        raise UsageError(f"--unit {unit!r}: use one of {', '.join(_MM)}")
    if max_faces < 1:
        raise UsageError(f"--max-faces {max_faces}: must be at least 1")
    file = identify_mesh_file(Path(path))
    try:
        vertices, faces, made = _surface(file, max_faces)
        _check(file, vertices, faces, max_faces)
        faces = recut(vertices, faces, made)
        vertices = np.ascontiguousarray(vertices, np.float64)
        small_faces = np.ascontiguousarray(faces, np.int32)
    except MemoryError:
        raise LimitError(f"{file.path}: does not fit in memory; decimate it") from None
    except OSError as error:
        raise InputError(f"{file.path}: cannot be read ({reason_of(error)})") from None
    in_metres = file.kind in ("glb", "gltf")
    mm_per_unit = _MM[unit or ("m" if in_metres else "mm")]
    unit_from = "given" if unit else "file" if in_metres else "assumed"
    return Mesh(vertices, small_faces, mm_per_unit, unit_from, str(path))


def _surface(file: MeshFile, max_faces: int) -> tuple[Float64, Integers, Integers]:
    """Vertices (N, 3), triangles (M, 3) and how many each polygon became, of any file, after its own checks."""
    if file.kind == "ply":
        header = ply.read_header(file)
        ply.check_claim(file, header, max_faces)
        return ply.read_ply(file, header, file.path.read_bytes())
    if file.kind in ("glb", "gltf"):
        return *_scene(file, gltf.plain_glb(file, file.path.read_bytes(), max_faces)), _NO_POLYGONS
    if file.kind == "stl" and not (file.is_text and file.head.lstrip()[:5].lower() == b"solid"):
        claimed = file.check_stl_claim(max_faces)
        data = file.path.read_bytes()[: STL_HEADER + STL_FACE * claimed]
        return *(_scene(file, data) if claimed else _nothing()), _NO_POLYGONS
    if file.kind == "obj":
        file.check_obj_count(max_faces)
    elif file.kind == "off" and b"\n" in file.head:
        claim = mesh_text.without_comments(file.head[: file.head.rfind(b"\n") + 1])
        file.check_limit(mesh_text.off_counts(file, claim)[1], max_faces)
    return _text(file, file.path.read_bytes(), max_faces)


def _nothing() -> Surface:
    return np.zeros((0, 3)), np.zeros((0, 3), np.int64)


def _text(file: MeshFile, data: bytes, max_faces: int) -> tuple[Float64, Integers, Integers]:
    plain = {"obj": mesh_text.plain_obj, "off": mesh_text.plain_off, "stl": mesh_text.plain_stl}[file.kind](file, data)
    file.check_limit(len(plain.triangles), max_faces)
    if not plain.triangles:
        return np.zeros((len(plain.vertices), 3)), np.zeros((0, 3), np.int64), _NO_POLYGONS
    try:
        vertices, faces = _scene(file, plain.encoded(file.kind))
    except InputError:
        missing = plain.missing_vertex()
        if missing is None:
            raise
        raise file.names_missing_vertex(missing, len(plain.vertices)) from None
    if len(vertices) != len(plain.vertices) or len(faces) != len(plain.triangles):
        raise file.damaged
    return vertices, faces, np.array(plain.made, np.int64)


@contextlib.contextmanager
def _silenced() -> Iterator[None]:
    """No warning, no log: what a library has to say of a file is said here, in one line."""
    log = logging.getLogger("trimesh")
    level = log.level
    log.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            # NumPy 1's way of saying that it stopped at a word among numbers
            warnings.filterwarnings("error", "string or file could not be read", DeprecationWarning)
            yield
    finally:
        log.setLevel(level)


def _scene(file: MeshFile, data: bytes) -> Surface:
    """What trimesh makes of the bytes of a checked file, with every part in its place."""
    kind = "glb" if file.kind == "gltf" else file.kind
    more = {"skip_materials": True, "maintain_order": True} if kind == "obj" else {}
    with _silenced():
        import trimesh

        try:
            loaded = trimesh.load(io.BytesIO(data), file_type=kind, process=False, **more)
            parts = _parts(trimesh, loaded)
        except MemoryError:
            raise
        except Exception:  # noqa: BLE001 - whatever a parser stumbles over, the file is to blame
            raise file.damaged from None
    if not parts:
        return _nothing()
    offsets = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    for vertices, faces in parts:
        _check_indices(file, vertices, faces)
    moved = [faces + offset for (_, faces), offset in zip(parts, offsets, strict=False)]
    return np.concatenate([vertices for vertices, _ in parts]), np.concatenate(moved)


def _parts(trimesh: Any, loaded: Any) -> list[Surface]:
    if not isinstance(loaded, trimesh.Scene):
        return [_arrays(loaded)] if isinstance(loaded, trimesh.Trimesh) else []
    parts = []
    for node in loaded.graph.nodes_geometry:
        matrix, name = loaded.graph[node]
        geometry = loaded.geometry[name]
        if isinstance(geometry, trimesh.Trimesh):
            vertices, faces = _arrays(geometry)
            # a mirrored part would be inside out
            faces = faces[:, ::-1] if np.linalg.det(matrix[:3, :3]) < 0 else faces
            parts.append((vertices @ matrix[:3, :3].T + matrix[:3, 3], faces))
    return parts


def _arrays(geometry: Any) -> Surface:
    return np.array(geometry.vertices, np.float64).reshape(-1, 3), np.array(geometry.faces, np.int64).reshape(-1, 3)


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
