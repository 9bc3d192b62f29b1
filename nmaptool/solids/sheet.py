"""A height field over a mask of pixels, as bands of triangles: two for each pixel."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from nmaptool import kernels
from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.grid import found_in, places, touching_vertices
from nmaptool.kernels.face_twins import two_each
from nmaptool.solids.outline import CORNERS, corner_nodes
from nmaptool.solids.rim import rim_heights
from nmaptool.solids.shape import Shape
from nmaptool.types.solid import Faces, Nodes, Part

_BAND_PIXELS = 1 << 17
_RANGE_ROWS = 256
# share of pixels in a band up to which they are made one by one
_SPARSE = 0.05


@dataclass(frozen=True)
class Placing:
    """How pixels become millimetres.

    Attributes
    ----------
    pitch_mm : float
    left_px, bottom_px : float
        The left edge of the grid, and its lower edge, from the lower left corner of the picture.
    """

    pitch_mm: float
    left_px: float
    bottom_px: float

    def xyz_mm(self, places_px: Float64, z_mm: Float64, rows: int) -> Float64:
        """(n, 3) float64 mm of places (x right, y down from the top of a grid of ``rows`` rows) and heights."""
        out = np.empty((len(places_px), 3))
        out[:, 0] = (places_px[:, 0] + self.left_px) * self.pitch_mm
        out[:, 1] = (rows + self.bottom_px - places_px[:, 1]) * self.pitch_mm
        out[:, 2] = z_mm
        return out


@dataclass(frozen=True, eq=False)
class Sheet:
    """A height field over a shape.

    Attributes
    ----------
    z_mm : (H+1, W+1) float64
    shape : Shape
    placing : Placing
    facing : int
        1 for a front, seen from +z; -1 for a back.
    first_node : int
        What is added to the nodes of the shape.
    moved_z_mm : (n,) float64, optional
        Heights of the moved nodes. Default: continued from the surface inside.
    diagonals_of : Sheet, optional
        The sheet whose pixels are split the same way, so that a back that is lower at every vertex is lower everywhere.
        Default: each pixel is split where this surface bends less.
    """

    z_mm: Float64
    shape: Shape
    placing: Placing
    facing: int = 1
    first_node: int = 0
    moved_z_mm: Float64 | None = None
    diagonals_of: Sheet | None = None

    @property
    def face_count(self) -> int:
        """Two for each pixel."""
        return 2 * int(np.count_nonzero(self.shape.mask))

    def z_of(self, nodes: Nodes) -> Float64:
        """Heights of nodes of the shape."""
        row, col = np.divmod(self.shape.vertex_of(nodes), self.z_mm.shape[1])
        z: Float64 = self.z_mm[row, col]
        at = found_in(self.shape.moved, nodes)
        z[at >= 0] = self.z_of_moved[at[at >= 0]]
        return z

    @cached_property
    def z_of_moved(self) -> Float64:
        """Heights of the moved nodes."""
        return rim_heights(self.z_mm, self.shape) if self.moved_z_mm is None else self.moved_z_mm

    def z_range(self) -> tuple[float, float]:
        """Lowest and highest node."""
        inside = touching_vertices(self.shape.mask)
        inside.ravel()[self.shape.vertex_of(self.shape.moved)] = False
        moved = self.z_of(self.shape.moved)
        low, high = float(moved.min(initial=np.inf)), float(moved.max(initial=-np.inf))
        for top in range(0, len(inside), _RANGE_ROWS):  # the heights are not copied as a whole
            rows, used = self.z_mm[top : top + _RANGE_ROWS], inside[top : top + _RANGE_ROWS]
            low = min(low, float(rows.min(initial=np.inf, where=used)))
            high = max(high, float(rows.max(initial=-np.inf, where=used)))
        return low, high

    @property
    def node_count(self) -> int:
        """One more than the highest node number."""
        return self.first_node + self.shape.node_count

    def xyz_of(self, nodes: Nodes) -> Float64:
        """(n, 3) float64 mm of nodes of the shape."""
        return self.placing.xyz_mm(self.shape.places_px(nodes), self.z_of(nodes), self.shape.mask.shape[0])

    def parts(self) -> Iterator[Part]:
        """The triangles, in bands of rows from the top."""
        rows, cols = self.shape.mask.shape
        step = max(1, _BAND_PIXELS // cols)
        for top in range(0, rows, step):
            band = self.shape.mask[top : top + step]
            count = np.count_nonzero(band)
            if count > _SPARSE * band.size:
                yield self._band(top, min(top + step, rows))
            elif count:
                row, col = places(band)
                yield self.pixel_part(row + top, col)

    def pixel_part(self, row: Nodes, col: Nodes) -> Part:
        """The triangles of some pixels."""
        shape = self.shape
        corners = np.stack([corner_nodes(row, col, shape.mask.shape[1], shape.splits, name) for name in CORNERS])
        nodes, local = np.unique(corners, return_inverse=True)
        numbers = dict(zip(CORNERS, local.reshape(corners.shape).astype(np.int32), strict=True))
        faces = two_each([numbers[name] for name in ("nw", "ne", "sw", "se")], self.falls_at(row, col))
        return Part(self.xyz_of(nodes), faces if self.facing > 0 else faces[:, ::-1], nodes + self.first_node)

    def _band(self, top: int, end: int) -> Part:
        """The triangles of rows ``top`` to ``end``."""
        shape, width = self.shape, self.shape.mask.shape[1] + 1
        first, count = top * width, (end + 1 - top) * width
        nodes = np.arange(first, first + count, dtype=np.int64)
        seconds = self._seconds(top, end)
        if len(seconds):
            faces = self._split_faces(top, end, seconds)
            nodes = np.concatenate([nodes, shape.splits.first + seconds])
        else:
            inside = np.ascontiguousarray(shape.mask[top:end])
            faces = np.empty((2 * int(np.count_nonzero(inside)), 3), np.int32)
            falls = np.ascontiguousarray(self.falls(top, end))
            kernels.pixel_faces(inside, falls, width, self.facing < 0, faces)
        return Part(self._xyz(top, end, nodes[count:]), faces, nodes + self.first_node)

    def _split_faces(self, top: int, end: int, seconds: Nodes) -> Faces:
        """The triangles of rows with vertices that are split."""
        splits, width = self.shape.splits, self.shape.mask.shape[1] + 1
        grid = np.arange((end + 1 - top) * width, dtype=np.int32).reshape(-1, width)
        corners = {"nw": grid[:-1, :-1], "ne": grid[:-1, 1:], "sw": grid[1:, :-1], "se": grid[1:, 1:]}
        corners = {name: each.copy() for name, each in corners.items()}
        row, col = np.divmod(splits.vertices[seconds] - top * width, width)
        extra = (grid.size + np.arange(len(seconds))).astype(np.int32)
        right = splits.lower_is_right[seconds]
        corners["nw"][row[right], col[right]] = extra[right]
        corners["ne"][row[~right], col[~right] - 1] = extra[~right]
        inside = self.shape.mask[top:end]
        faces = two_each([corners[name][inside] for name in ("nw", "ne", "sw", "se")], self.falls(top, end)[inside])
        return faces if self.facing > 0 else faces[:, ::-1]

    def _xyz(self, top: int, end: int, seconds: Nodes) -> Float64:
        """The vertices of rows ``top`` to ``end`` of the grid, and the second nodes there."""
        rows, cols = self.shape.mask.shape
        width, place = cols + 1, self.placing
        out = np.empty(((end + 1 - top) * width + len(seconds), 3))
        grid = out[: (end + 1 - top) * width].reshape(-1, width, 3)
        grid[..., 0] = (np.arange(width) + place.left_px) * place.pitch_mm
        grid[..., 1] = ((rows + place.bottom_px - np.arange(top, end + 1)) * place.pitch_mm)[:, None]
        grid[..., 2] = self.z_mm[top : end + 1]
        low, high = np.searchsorted(self.shape.moved, [top * width, (end + 1) * width])
        moved = self.shape.moved[low:high]
        out[moved - top * width] = self.xyz_of(moved)
        out[len(out) - len(seconds) :] = self.xyz_of(seconds)
        return out

    def _seconds(self, top: int, end: int) -> Nodes:
        """The splits whose lower pixel lies in these rows."""
        width = self.shape.mask.shape[1] + 1
        low, high = np.searchsorted(self.shape.splits.vertices, [top * width, end * width])
        return np.arange(low, high)

    def falls(self, top: int, end: int) -> Mask:
        """(end - top, W) bool: whether each pixel is split along its falling diagonal."""
        if self.diagonals_of is not None:
            return self.diagonals_of.falls(top, end)
        falls = falling_diagonals(self.z_mm, top, end)
        cols = self.shape.mask.shape[1]
        low, high = np.searchsorted(self.shape.forced, [top * cols, end * cols])
        falls.ravel()[self.shape.forced[low:high] - top * cols] = self.shape.forced_falls[low:high]
        return falls

    def falls_at(self, rows: Nodes, cols: Nodes) -> Mask:
        """(n,) bool: the same for some pixels."""
        if self.diagonals_of is not None:
            return self.diagonals_of.falls_at(rows, cols)
        height, width = self.z_mm.shape
        r = np.clip(rows[:, None] + np.arange(-1, 3), 0, height - 1).T
        c = np.clip(cols[:, None] + np.arange(-1, 3), 0, width - 1).T
        z = self.z_mm
        bend_falling = np.abs(z[r[0], c[0]] - z[r[1], c[1]] - z[r[2], c[2]] + z[r[3], c[3]])
        bend_rising = np.abs(z[r[3], c[0]] - z[r[2], c[1]] - z[r[1], c[2]] + z[r[0], c[3]])
        falls: Mask = bend_falling <= bend_rising
        at = found_in(self.shape.forced, rows * (width - 1) + cols)
        falls[at >= 0] = self.shape.forced_falls[at[at >= 0]]
        return falls


def falling_diagonals(z_mm: Float64, top: int, end: int) -> Mask:
    """Whether the surface bends less along the falling diagonal of each pixel of some rows.

    Splitting there preserves diagonal ridges and valleys.
    """
    low, high = max(top - 1, 0), min(end + 2, len(z_mm))
    rows, falls = np.ascontiguousarray(z_mm[low:high]), np.empty((end - top, z_mm.shape[1] - 1), bool)
    kernels.falling_diagonals(rows, z_mm.shape[1], top - low, falls)
    return falls
