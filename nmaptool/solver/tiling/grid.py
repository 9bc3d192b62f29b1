"""The tiles of a picture: what each owns, the window it works on, and its part of the coarse grid."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from nmaptool.core.errors import UsageError

Box = tuple[slice, slice]


@dataclass(frozen=True)
class Tile:
    """One tile, by its place among the tiles."""

    row: int
    col: int


@dataclass(frozen=True)
class TileGrid:
    """A picture of H x W faces cut into square tiles.

    A tile owns its faces, and of the vertices those at the upper left corners of its faces; the last tiles of a row or
    column own the last vertices, too.

    Parameters
    ----------
    rows, cols : int
        H and W, in faces.
    tile : int
        Faces on the side of a tile; a multiple of ``factor``.
    overlap : int
        Faces by which the window of a tile reaches into its neighbours.
    factor : int
        Faces on the side of a face of the coarse grid.
    """

    rows: int
    cols: int
    tile: int
    overlap: int
    factor: int

    def __post_init__(self) -> None:
        if self.tile < 4 or self.tile % self.factor:
            raise UsageError(f"`tile={self.tile}`: must be a multiple of {self.factor}, at least 4")

    @property
    def down(self) -> int:
        """Number of tiles in a column."""
        return -(-self.rows // self.tile)

    @property
    def across(self) -> int:
        """Number of tiles in a row."""
        return -(-self.cols // self.tile)

    def __len__(self) -> int:
        return self.down * self.across

    def __iter__(self) -> Iterator[Tile]:
        return (Tile(row, col) for row in range(self.down) for col in range(self.across))

    @property
    def coarse_shape(self) -> tuple[int, int]:
        """Rows and columns of faces of the coarse grid."""
        return -(-self.rows // self.factor), -(-self.cols // self.factor)

    def faces(self, tile: Tile) -> Box:
        """The faces that a tile owns."""
        return _part(tile.row, self.tile, self.rows), _part(tile.col, self.tile, self.cols)

    def vertices(self, tile: Tile) -> Box:
        """The vertices that a tile owns."""
        rows, cols = self.faces(tile)
        return _owned(rows, self.rows), _owned(cols, self.cols)

    def window(self, tile: Tile, margin: int | None = None) -> Box:
        """The faces that a tile works on: its own and ``margin`` (default: the overlap) around them."""
        margin = self.overlap if margin is None else margin
        rows, cols = self.faces(tile)
        return _widened(rows, margin, self.rows), _widened(cols, margin, self.cols)


def of_vertices(box: Box) -> Box:
    """The vertices at the corners of a box of faces."""
    rows, cols = box
    return slice(rows.start, rows.stop + 1), slice(cols.start, cols.stop + 1)


def inside(box: Box, window: Box) -> Box:
    """A box in the coordinates of a window."""
    return tuple(slice(a.start - b.start, a.stop - b.start) for a, b in zip(box, window, strict=True))  # type: ignore[return-value]


def _part(number: int, size: int, count: int) -> slice:
    return slice(number * size, min((number + 1) * size, count))


def _owned(faces: slice, count: int) -> slice:
    return slice(faces.start, faces.stop + (faces.stop == count))


def _widened(part: slice, by: int, count: int) -> slice:
    return slice(max(part.start - by, 0), min(part.stop + by, count))
