"""Triangles made in parts: a surface or a closed solid that is never held in memory as a whole."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool import kernels
from nmaptool.core.arrays import Float64, Mask, read_only
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
    keeps_unused : bool
        Whether vertices that no face uses are written, too.
    """

    xyz_mm: Float64
    faces: Faces
    nodes: Nodes
    keeps_unused: bool = False


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


@dataclass(frozen=True, eq=False)
class NumberedBody:
    """A body whose vertices are numbered from 0.

    Attributes
    ----------
    body : Body
    numbers : (node_count,) int32
        Number of each node; -1 for those that no face uses.
    fresh : tuple of int
        How many vertices each part is the first to use.
    bounds_mm : (2, 3) float64
        Least and greatest coordinates of the vertices.
    """

    body: Body
    numbers: NDArray[np.int32]
    fresh: tuple[int, ...]
    bounds_mm: Float64

    @property
    def vertex_count(self) -> int:
        """Vertices of all parts together."""
        return sum(self.fresh)

    @classmethod
    def of(cls, body: Body, *, is_measured: bool = False) -> NumberedBody:
        """Number the vertices; the parts are made once for it. The bounds are infinite unless ``is_measured``."""
        numbers, fresh, count = np.full(body.node_count, -1, np.int32), [], 0
        bounds_mm = np.stack([np.full(3, np.inf), np.full(3, -np.inf)])
        for part in body.parts():
            new = _used(part) & (numbers[part.nodes] < 0)
            rows = _rows(new)
            nodes = part.nodes[rows]
            numbers[nodes] = np.arange(count, count + len(nodes), dtype=np.int32)
            count += len(nodes)
            fresh.append(len(nodes))
            if is_measured and len(nodes):
                _widen(bounds_mm, part.xyz_mm[rows])
        return cls(body, numbers, tuple(fresh), bounds_mm)

    def vertices(self) -> Iterator[Float64]:
        """(k, 3) float64 mm: the vertices in the order of their numbers, in bands."""
        count = 0
        for part, fresh in zip(self.body.parts(), self.fresh, strict=True):
            numbers = self.numbers[part.nodes]
            yield part.xyz_mm[_rows((numbers >= count) & (numbers < count + fresh))]
            count += fresh

    def faces(self) -> Iterator[Faces]:
        """(m, 3) int32 numbers of vertices, in bands."""
        for part in self.body.parts():
            yield self.numbers[part.nodes][part.faces]


def _used(part: Part) -> Mask:
    """(n,) bool: the vertices of a part that are written."""
    used = np.full(len(part.nodes), part.keeps_unused)
    if not part.keeps_unused:
        kernels.mark_corners(np.ascontiguousarray(part.faces, np.int32), used)
    return used


def _rows(chosen: Mask) -> slice | Mask:
    """The chosen rows: a slice if they follow each other, which needs no copy."""
    first, count = int(chosen.argmax()) if len(chosen) else 0, int(np.count_nonzero(chosen))
    return slice(first, first + count) if chosen[first : first + count].all() else chosen


def _widen(bounds_mm: Float64, xyz_mm: Float64) -> None:
    """Extend the bounds to more points, axis by axis, because NumPy is slow on rows of three."""
    for axis in range(3):
        values = xyz_mm[:, axis]
        bounds_mm[0, axis] = np.minimum(bounds_mm[0, axis], values.min())
        bounds_mm[1, axis] = np.maximum(bounds_mm[1, axis], values.max())


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
        Of the closed bodies, from the heights: mean thickness times area, summed over the pixels and over the
        triangles along an exact outline; NaN for an open surface.
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

    def to_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return {
            "closed": self.is_closed,
            "bodies": len(self.bodies),
            "triangles": self.face_count,
            "size_mm": list(self.size_mm),
            "volume_mm3": self.volume_mm3 if self.is_closed else None,
            **self.facts,
        }

    def to_mesh(self) -> Mesh:
        """All triangles as one mesh, in memory; vertices are numbered in the order in which the parts use them."""
        bodies = [NumberedBody.of(body) for body in self.bodies]
        firsts = np.cumsum([0, *(body.vertex_count for body in bodies)])
        vertices = [xyz_mm for body in bodies for xyz_mm in body.vertices()]
        faces = [each + first for body, first in zip(bodies, firsts, strict=False) for each in body.faces()]
        return Mesh(np.concatenate(vertices), np.concatenate(faces).astype(np.int32))

    def _line(self) -> str:
        x, y, z = self.size_mm
        kind = counted(len(self.bodies), "closed body")
        return f"{x:.4g} x {y:.4g} x {z:.4g} mm, {kind if self.is_closed else 'open surface'}, " + counted(
            self.face_count, "face"
        )
