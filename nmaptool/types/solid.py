"""Triangles made in parts: a surface or a closed solid that is never held in memory as a whole."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64, read_only
from nmaptool.types.mesh import Mesh
from nmaptool.types.shown import OneLine, counted

Faces = NDArray[np.int32]
Nodes = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Part:
    """Some triangles of a body.

    Attributes
    ----------
    xyz_mm : (n, 3) float64
        Vertices in mm: +x right, +y up, +z to the viewer.
    faces : (m, 3) int32
        Rows of ``xyz_mm``, counter-clockwise seen from outside.
    nodes : (n,) int64
        Number of each vertex in the body: two parts share a vertex where they have the same number.
    """

    xyz_mm: Float64
    faces: Faces
    nodes: Nodes


@dataclass(frozen=True, eq=False, repr=False)
class Body(OneLine):
    """One piece of a solid or surface.

    Attributes
    ----------
    name : str
    parts : callable
        ``parts()`` makes the parts again at each call.
    face_count : int
        Triangles of all parts together.
    node_count : int
        One more than the highest node number that can occur.
    """

    name: str
    parts: Callable[[], Iterator[Part]]
    face_count: int
    node_count: int

    def _line(self) -> str:
        return f"{self.name}: {counted(self.face_count, 'face')}"


@dataclass(frozen=True, eq=False, repr=False)
class Solid(OneLine):
    """A relief as triangles: an open surface, or closed bodies with walls and a back.

    Attributes
    ----------
    bodies : tuple of Body
        One for each piece; an open surface is one body.
    is_closed : bool
        Whether every body is closed.
    bounds_mm : (2, 3) float64
        Least and greatest x, y and z.
    volume_mm3 : float
        Of the closed bodies, from the heights: the sum over the pixels of mean thickness times area; NaN for an open
        surface.
    facts : mapping of str to float
        What was measured on the way, such as "max_error_mm".
    """

    bodies: tuple[Body, ...]
    is_closed: bool
    bounds_mm: Float64
    volume_mm3: float = float("nan")
    facts: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "bounds_mm", read_only(np.array(self.bounds_mm, np.float64)))

    @property
    def face_count(self) -> int:
        """Triangles of all bodies."""
        return sum(body.face_count for body in self.bodies)

    @property
    def size_mm(self) -> tuple[float, float, float]:
        """Extent along x, y and z."""
        x, y, z = (self.bounds_mm[1] - self.bounds_mm[0]).tolist()
        return x, y, z

    def to_mesh(self) -> Mesh:
        """All triangles as one mesh, in memory.

        Vertices are numbered in the order in which faces first name them.
        """
        vertices, faces, first = [], [], 0
        for body in self.bodies:
            for xyz_mm, triangles in numbered(body):
                vertices.append(xyz_mm)
                faces.append(triangles + first)
            first = sum(len(each) for each in vertices)
        return Mesh(np.concatenate(vertices), np.concatenate(faces).astype(np.int32))

    def _line(self) -> str:
        x, y, z = self.size_mm
        kind = counted(len(self.bodies), "closed body" if len(self.bodies) == 1 else "closed bodie")
        return f"{x:.4g} x {y:.4g} x {z:.4g} mm, {kind if self.is_closed else 'open surface'}, " + counted(
            self.face_count, "face"
        )


def numbered(body: Body) -> Iterator[tuple[Float64, Nodes]]:
    """The parts of a body with vertices numbered from 0 in order of appearance.

    Yields
    ------
    xyz_mm : (k, 3) float64
        Vertices that no earlier part had.
    faces : (m, 3) int64
        Numbers of vertices of this and earlier parts.
    """
    numbers = np.full(body.node_count, -1, np.int32)
    count = 0
    for part in body.parts():
        used = np.zeros(len(part.nodes), bool)
        used[part.faces] = True
        new = used & (numbers[part.nodes] < 0)
        fresh = part.nodes[new]
        numbers[fresh] = np.arange(count, count + len(fresh), dtype=np.int32)
        count += len(fresh)
        yield part.xyz_mm[new], numbers[part.nodes][part.faces].astype(np.int64)
