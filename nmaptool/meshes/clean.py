"""Clean a mesh for filtering and rendering, and count what was changed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Mask
from nmaptool.core.errors import InputError
from nmaptool.meshes.winding import duplicate_faces, faces_to_flip, is_consistently_wound
from nmaptool.types.mesh import Faces, Mesh, cross, face_geometry
from nmaptool.types.mesh_findings import MeshFindings
from nmaptool.types.shown import counted

# a face is degenerate if its height over its longest edge is below this share of that edge: its normal is noise
_THINNEST = 1e-10
# limits of the extent: squares of areas must not overflow or underflow
_SMALLEST, _LARGEST = 1e-30, 1e30
_FACES_AT_ONCE = 100_000


def clean_mesh(mesh: Mesh) -> tuple[Mesh, NDArray[np.int64], MeshFindings]:
    """Drop unusable faces and vertices, weld vertices at the same position, and wind neighbouring faces alike.

    Parameters
    ----------
    mesh : Mesh
        Not changed.

    Returns
    -------
    mesh : Mesh
        Every vertex is finite and used, no two share a position; every face has an area and occurs once; neighbouring
        faces are wound the same way.
    source_faces : (M,) int64
        Index of each face in the given mesh.
    findings : MeshFindings
        Counts of what was dropped, welded and flipped.

    Raises
    ------
    InputError
        If nothing is left, or the mesh has no extent.

    Examples
    --------
    Vertices 1 and 3 are at the same position, so the second face has no area:

    >>> vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0]]
    >>> mesh, source_faces, findings = nm.clean_mesh(nm.Mesh.from_arrays(vertices, [[0, 1, 2], [0, 3, 1]]))
    >>> mesh.faces.tolist(), source_faces.tolist(), findings.welded_vertices, findings.degenerate_faces
    ([[0, 1, 2]], [0], 1, 1)
    """
    if not len(mesh.faces):
        raise InputError(f"{mesh.name}: holds {counted(len(mesh.vertices), 'point')} and no faces; a surface is needed")
    finite: Mask = _all_three(np.isfinite(mesh.vertices))
    sound: Mask = _all_three(finite.take(mesh.faces))
    if not sound.any():
        raise InputError(f"{mesh.name}: every face has a vertex that is NaN or infinite; export it again")
    used = np.zeros(len(mesh.vertices), bool)
    used[mesh.faces[sound]] = True
    chosen = np.flatnonzero(used)
    positions = mesh.vertices.take(chosen, axis=0) + 0.0  # turns -0 into 0, the same position
    with np.errstate(over="ignore"):
        extent = float(np.ptp(positions, axis=0).max())
    if not extent > 0:
        raise InputError(f"{mesh.name}: all vertices are at one point; a surface is needed")
    if not _SMALLEST <= extent <= _LARGEST:
        raise InputError(f"{mesh.name}: is {extent:.3g} units large; scale it to a realistic size")
    first, place = _weld(positions)
    index = np.zeros(len(mesh.vertices), np.int32)
    index[chosen] = place
    faces: Faces = index.take(mesh.faces)
    vertices = positions.take(first, axis=0)
    solid = sound & _has_area(vertices, faces, sound)
    if not solid.any():
        raise InputError(f"{mesh.name}: no face has an area (faces: {len(mesh.faces)}); export it again")
    source = np.flatnonzero(solid)
    alike, once, turned = _consistently_wound(vertices, faces.take(source, axis=0))
    welded = replace(mesh, vertices=vertices, faces=alike)
    findings = MeshFindings(
        vertices=len(mesh.vertices),
        faces=len(mesh.faces),
        welded_vertices=len(chosen) - len(first),
        unreferenced_vertices=int((finite & ~_named(mesh)).sum()),
        nonfinite_vertices=int((~finite).sum()),
        nonfinite_faces=int((~sound).sum()),
        degenerate_faces=int((sound & ~solid).sum()),
        repeated_faces=len(source) - len(alike),
        turned_faces=turned,
    )
    return _without_unused(welded), source[once], findings


def _consistently_wound(vertices: NDArray[np.float64], faces: Faces) -> tuple[Faces, Mask, int]:
    """Drop repeated faces and wind all alike; return the faces, a mask of those kept, and the number flipped."""
    once = np.ones(len(faces), bool)
    if is_consistently_wound(faces):
        return faces, once, 0
    once = ~duplicate_faces(faces)
    alike = faces[once]
    turn = faces_to_flip(alike, face_geometry(Mesh(vertices, alike)).areas)
    alike[turn] = alike[turn][:, ::-1]
    return alike, once, int(turn.sum())


def _all_three(flags: Mask) -> Mask:
    return np.asarray(flags[:, 0] & flags[:, 1] & flags[:, 2])


def _named(mesh: Mesh) -> Mask:
    named = np.zeros(len(mesh.vertices), bool)
    named[mesh.faces] = True
    return named


def _weld(positions: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """The first vertex at each position, and the index among these of every vertex; the order of the file is kept."""
    order, starts = _grouped(positions)
    if starts.all():
        return np.arange(len(positions)), np.arange(len(positions), dtype=np.int32)
    group = np.cumsum(starts) - 1
    first = np.minimum.reduceat(order, np.flatnonzero(starts))
    rank = np.empty(len(first), np.int32)
    rank[np.argsort(first)] = np.arange(len(first), dtype=np.int32)
    place = np.empty(len(positions), np.int32)
    place[order] = rank[group]
    return np.sort(first), place


def _grouped(positions: NDArray[np.float64]) -> tuple[NDArray[np.int64], Mask]:
    """An order in which equal positions are neighbours, and where each group begins in it."""
    key = _hashes(positions)
    order = np.argsort(key)
    key = key[order]
    starts = np.r_[True, key[1:] != key[:-1]]
    again = np.flatnonzero(~starts)
    if np.array_equal(positions.take(order[again], axis=0), positions.take(order[again - 1], axis=0)):
        return order, starts
    order = np.lexsort(positions.T)  # different positions share a hash
    ordered = positions.take(order, axis=0)
    return order, np.r_[True, (ordered[1:] != ordered[:-1]).any(axis=1)]


def _hashes(positions: NDArray[np.float64]) -> NDArray[np.uint64]:
    """(N,) uint64 hashes of positions, which sort several times faster than three coordinates."""
    out = np.zeros(len(positions), np.uint64)
    for column in np.ascontiguousarray(positions.T).view(np.uint64):
        out += column
        # spread the bits both ways: coordinates on a grid differ only in a few high bits
        out ^= out >> np.uint64(32)
        out *= np.uint64(0xD6E8FEB86659FD93)
        out ^= out >> np.uint64(29)
        out *= np.uint64(0x9E3779B97F4A7C15)
    return out


def _has_area(vertices: NDArray[np.float64], faces: Faces, sound: Mask) -> Mask:
    good = np.zeros(len(faces), bool)
    kept = np.flatnonzero(sound)
    for part in np.array_split(kept, 1 + len(kept) // _FACES_AT_ONCE):
        a, b, c = (vertices.take(corner, axis=0) for corner in faces.take(part, axis=0).T)
        ab, ac = b - a, c - a
        scale = np.maximum.reduce([np.abs(v[:, k]) for v in (ab, ac) for k in range(3)])
        safe = np.where(scale > 0, scale, 1)[:, None]
        ab /= safe
        ac /= safe
        longest2 = np.maximum.reduce([_squares(v) for v in (ab, ac, ac - ab)])
        good[part] = (scale > 0) & (np.sqrt(_squares(cross(ab, ac))) > _THINNEST * longest2)
    return good


def _squares(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    x, y, z = vectors.T
    return np.asarray(x * x + y * y + z * z)


def _without_unused(mesh: Mesh) -> Mesh:
    """Drop vertices that only degenerate faces used."""
    used = np.zeros(len(mesh.vertices), bool)
    used[mesh.faces] = True
    if used.all():
        return mesh
    index = np.cumsum(used, dtype=np.int32) - np.int32(1)
    return replace(mesh, vertices=mesh.vertices[used], faces=index.take(mesh.faces))
