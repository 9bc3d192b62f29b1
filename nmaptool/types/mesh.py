"""Triangle meshes, as read from files, made from reliefs, rendered and written."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64, read_only
from nmaptool.core.errors import InputError
from nmaptool.types.mesh_arrays import MM_PER_UNIT, as_faces, as_vertices, require_trimesh, trimesh_unit
from nmaptool.types.shown import OneLine, counted

Faces = NDArray[np.int32]


@dataclass(frozen=True, eq=False, repr=False)
class Mesh(OneLine):
    """A triangle mesh.

    Parameters
    ----------
    vertices : (N, 3) float64
        Positions in the mesh's own units; they may be NaN until `nmaptool.meshes.clean.clean_mesh` drops such vertices.
    faces : (M, 3) int32
        Vertices of each triangle, counter-clockwise seen from outside.
    mm_per_unit : float
        Millimetres per unit of the vertices.
    unit_from : str
        Source of ``mm_per_unit``: ``given``, ``file`` (fixed by its format) or ``assumed``.
    name : str
        Name of the mesh for messages: a file name.
    notes : tuple of str
        What was ignored or assumed when the mesh was read, one sentence each.
    up_from : str
        Source of the fact that y points up: ``file``, or ``assumed``.

    Raises
    ------
    InputError
        If a shape or type is wrong, or a face refers to a missing vertex.
    """

    vertices: Float64
    faces: Faces
    mm_per_unit: float = 1.0
    unit_from: str = "assumed"
    name: str = "mesh"
    notes: tuple[str, ...] = ()
    up_from: str = "assumed"

    def __post_init__(self) -> None:
        for what, array, dtype in (("vertices", self.vertices, np.float64), ("faces", self.faces, np.int32)):
            if array.ndim != 2 or array.shape[1] != 3 or array.dtype != dtype:
                raise InputError(
                    f"{self.name}: {what} are {array.dtype} {array.shape}, expected {np.dtype(dtype).name} (count, 3)"
                )
        if len(self.faces):
            lowest, highest = int(self.faces.min()), int(self.faces.max())
            if lowest < 0 or highest >= len(self.vertices):
                raise InputError(
                    f"{self.name}: a face refers to vertex {lowest if lowest < 0 else highest}, which is missing "
                    f"(vertices: {len(self.vertices)}); the file is damaged: export it again"
                )
        if not (math.isfinite(self.mm_per_unit) and self.mm_per_unit > 0):
            raise InputError(f"{self.name}: {self.mm_per_unit} mm per unit: must be greater than zero")
        object.__setattr__(self, "vertices", read_only(self.vertices))
        object.__setattr__(self, "faces", read_only(self.faces))

    @property
    def vertices_mm(self) -> Float64:
        """(N, 3) float64 positions in millimetres."""
        return self.vertices if self.mm_per_unit == 1 else self.vertices * self.mm_per_unit

    @property
    def corners(self) -> Float64:
        """(M, 3, 3) float64: x, y, z of the three corners of each face."""
        return np.asarray(self.vertices.take(self.faces, axis=0))

    @cached_property
    def geometry(self) -> FaceGeometry:
        """`face_geometry`, computed once."""
        return face_geometry(self)

    @cached_property
    def mean_edge(self) -> float:
        """`mean_edge_length`, computed once."""
        return mean_edge_length(self)

    @classmethod
    def from_arrays(
        cls, vertices: Any, faces: Any, mm_per_unit: float = 1.0, *, unit_from: str = "given", name: str = "mesh"
    ) -> Mesh:
        """Make a mesh from plain arrays or nested lists.

        Parameters
        ----------
        vertices : (N, 3) int or float of any type
            Positions in units of the mesh.
        faces : (M, 3) int or float of any type
            Whole numbers from 0 to N - 1: the vertices of each triangle, counter-clockwise seen from outside.
        mm_per_unit : float
            Millimetres per unit of the vertices.
        unit_from : str
            ``given``, or ``assumed`` if the unit is not known; unusual sizes are then reported.
        name : str
            Name of the mesh for messages.

        Returns
        -------
        Mesh

        Raises
        ------
        InputError
            If a shape is wrong, or a face refers to a missing vertex.
        UsageError
            If a value is not an array of numbers.

        Examples
        --------
        >>> nm.Mesh.from_arrays([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], mm_per_unit=10)
        <Mesh mesh: 3 vertices, 1 face, 10 mm per unit (given)>
        """
        positions = as_vertices(vertices, name)
        return cls(positions, as_faces(faces, len(positions), name), float(mm_per_unit), unit_from, name)

    @classmethod
    def from_trimesh(cls, mesh: Any, mm_per_unit: float | None = None) -> Mesh:
        """Make a mesh from a trimesh object.

        Parameters
        ----------
        mesh : trimesh.Trimesh
        mm_per_unit : float, optional
            Millimetres per unit of the vertices. Default: that of ``mesh.units``, otherwise 1, which is reported as
            assumed.

        Returns
        -------
        Mesh
            Named after the file that trimesh read, if any.

        Raises
        ------
        InputError
            If ``mesh.units`` is a unit that trimesh does not know.
        UsageError
            If the value is not a trimesh.Trimesh, such as a scene.

        Examples
        --------
        >>> import trimesh
        >>> nm.Mesh.from_trimesh(trimesh.creation.box())
        <Mesh mesh: 8 vertices, 12 faces, 1 mm per unit (assumed)>
        """
        require_trimesh(mesh)
        found = trimesh_unit(mesh.units) if mm_per_unit is None else float(mm_per_unit)
        unit_from = "assumed" if found is None else "given" if mm_per_unit is not None else "file"
        name = str(mesh.metadata.get("file_name") or "mesh")
        return cls.from_arrays(mesh.vertices, mesh.faces, found or 1.0, unit_from=unit_from, name=name)

    def to_trimesh(self) -> Any:
        """Make a trimesh object with the same vertices in the same order.

        Returns
        -------
        trimesh.Trimesh
            Its ``units`` are set if the unit is known and has a name: mm, cm, m, in.

        Raises
        ------
        ImportError
            If trimesh is not installed.

        Examples
        --------
        >>> mesh = nm.Mesh.from_arrays([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
        >>> mesh.to_trimesh().units
        'mm'
        """
        import trimesh  # takes long to load

        mesh = trimesh.Trimesh(self.vertices.copy(), self.faces.copy(), process=False)
        names = [name for name, mm in MM_PER_UNIT.items() if mm == self.mm_per_unit]
        if names and self.unit_from != "assumed":
            mesh.units = names[0]
        return mesh

    def _line(self) -> str:
        size = f"{counted(len(self.vertices), 'vertex')}, {counted(len(self.faces), 'face')}"
        return f"{self.name}: {size}, {self.mm_per_unit:.6g} mm per unit ({self.unit_from})"


@dataclass(frozen=True, eq=False, repr=False)
class FaceGeometry(OneLine):
    """Normal, area and centroid of each face.

    Attributes
    ----------
    normals : (M, 3) float64
        Unit length, by the right-hand rule over the corners.
    areas : (M,) float64
        In squared units of the mesh.
    centroids : (M, 3) float64
    """

    normals: Float64
    areas: Float64
    centroids: Float64


def cross(u: Float64, v: Float64) -> Float64:
    """Cross products of (N, 3) vectors; several times quicker than `numpy.cross`."""
    out = np.empty_like(u)
    for k in range(3):
        a, b = (k + 1) % 3, (k + 2) % 3
        out[:, k] = u[:, a] * v[:, b] - u[:, b] * v[:, a]
    return out


def face_geometry(mesh: Mesh) -> FaceGeometry:
    """Normals, areas and centroids of the faces of a mesh without degenerate faces."""
    # rows are fetched with take, here and below: several times faster than indexing
    a, b, c = (mesh.vertices.take(mesh.faces[:, k], axis=0) for k in range(3))
    twice = cross(b - a, c - a)
    length = np.sqrt(np.einsum("ij,ij->i", twice, twice))
    normals = twice / np.where(length > 0, length, 1)[:, None]
    return FaceGeometry(normals, length / 2, (a + b + c) / 3)


def directed_edges(faces: Faces) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First and second vertex of each face's edges, (3 M,) each: all first edges, then all second, then all third."""
    first, second = (np.concatenate([faces[:, k] for k in order]).astype(np.int64) for order in ((0, 1, 2), (1, 2, 0)))
    return first, second


def edge_keys(first: NDArray[np.int64], second: NDArray[np.int64]) -> NDArray[np.int64]:
    """One integer for each edge, the same in both directions, with the lower vertex in the high half."""
    return np.minimum(first, second) << 32 | np.maximum(first, second)


def sum_by(group: NDArray[Any], values: Float64, count: int) -> Float64:
    """(count, K) float64: sums of the rows of (N, K) values that have the same group, 0 to count - 1."""
    return np.column_stack([np.bincount(group, column, count) for column in values.T])


def unique_edges(mesh: Mesh) -> NDArray[np.int32]:
    """(E, 2) int32: vertices of each edge, the lower number first."""
    keys = edge_keys(*directed_edges(mesh.faces))
    keys.sort()
    keys = keys[np.concatenate([[True], keys[1:] != keys[:-1]])] if len(keys) else keys
    return np.column_stack([keys >> 32, keys & 0xFFFFFFFF]).astype(np.int32)


def mean_edge_length(mesh: Mesh) -> float:
    """Mean length of the unique edges, in units of the mesh; the unit of sigma_s (paper, Sec. 3)."""
    first, second = unique_edges(mesh).T
    step = mesh.vertices.take(first, axis=0) - mesh.vertices.take(second, axis=0)
    return float(np.sqrt(np.einsum("ij,ij->i", step, step)).mean())
