"""The strip of triangles between the outline of the inner pixels and the exact outline."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.solids.exact.rings import OutlinePoints
from nmaptool.solids.exact.triangulate import triangulated
from nmaptool.solids.outline import OutlineEdges
from nmaptool.solids.sheet import Sheet
from nmaptool.types.contours import ring_area
from nmaptool.types.solid import Faces, Nodes, Part


@dataclass(frozen=True, eq=False)
class Strip:
    """Triangles between a sheet and the outline, seen from the viewer.

    Attributes
    ----------
    points : OutlinePoints
    nodes : (k,) int64
        Nodes of the outline of the sheet, then those between it and the outline of the plate.
    faces : (m, 3) int64
        Numbers of points, then of nodes.
    least_faces : int
        Triangles without any points and nodes: each point and each node of an outline adds one, other nodes add two.
    """

    points: OutlinePoints
    nodes: Nodes
    faces: Nodes
    least_faces: int

    def part(self, sheet: Sheet, z_mm: Float64, first_node: int) -> Part:
        """The triangles at the heights of a sheet.

        Parameters
        ----------
        sheet : Sheet
            The strip faces where it faces.
        z_mm : (n,) float64
            Heights of the points of the outline.
        first_node : int
            Number of the first of these points in the body.
        """
        faces: Faces = self.faces.astype(np.int32)
        numbers = np.concatenate([first_node + np.arange(len(z_mm)), sheet.first_node + self.nodes])
        return Part(self._xyz_mm(sheet, z_mm), faces if sheet.facing > 0 else faces[:, ::-1], numbers)

    def volume_below(self, sheet: Sheet, z_mm: Float64) -> float:
        """The integral of its heights in mm3; parameters as for `part`."""
        x, y, z = np.moveaxis(self._xyz_mm(sheet, z_mm)[self.faces], 2, 0)
        area = ((x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0])) / 2
        return float((area * z.mean(axis=1)).sum())

    def z_range(self, sheet: Sheet, z_mm: Float64) -> tuple[float, float]:
        """Its lowest and highest corner and those of the sheet; parameters as for `part`."""
        low, high = sheet.z_range()
        z = np.concatenate([z_mm, sheet.z_of(self.nodes)])
        return min(low, float(z.min())), max(high, float(z.max()))

    def _xyz_mm(self, sheet: Sheet, z_mm: Float64) -> Float64:
        return np.concatenate([np.column_stack([self.points.xy_mm, z_mm]), sheet.xyz_of(self.nodes)])


def strip_between(points: OutlinePoints, sheet: Sheet, edges: OutlineEdges, between: Nodes) -> Strip:
    """Triangulate between the outline and a sheet.

    Parameters
    ----------
    points : OutlinePoints
    sheet : Sheet
    edges : OutlineEdges
        The outline of the sheet, which lies inside of the other; its nodes do not move.
    between : (k,) int64
        Other nodes of the grid that become corners of triangles.

    Raises
    ------
    InputError
        If the outline crosses or touches itself.
    """
    loops = loops_of(edges)
    pitch_mm, rows = sheet.placing.pitch_mm, sheet.shape.mask.shape[0]

    def places_px(nodes: Nodes) -> Float64:
        return sheet.shape.places_px(nodes) * (1, -1) + (0, rows)

    rings = [*(ring / pitch_mm for ring in points.rings), *(places_px(loop) for loop in loops)]
    faces = triangulated(rings, places_px(between), unit_mm=pitch_mm)
    nodes = np.concatenate([*loops, between])
    return Strip(points, nodes, faces, len(faces) - len(points.xy_mm) - len(nodes) - len(between))


def loops_of(edges: OutlineEdges) -> list[Nodes]:
    """The closed loops of an outline, each against its direction: the sheet lies to the right."""
    order = np.argsort(edges.start)
    before = dict(zip(edges.end[order].tolist(), edges.start[order].tolist(), strict=True))
    loops = []
    while before:
        first, node = before.popitem()
        loop = [first]
        while node != first:
            loop.append(node)
            node = before.pop(node)
        loops.append(np.array(loop, np.int64))
    return loops


def outline_area(points: OutlinePoints) -> float:
    """The area inside the outline in mm2."""
    return float(sum(ring_area(ring) for ring in points.rings))
