"""Read and write folders of tiles: files called tile_ROW_COLUMN, such as tile_0_3.png, that lie side by side."""

from __future__ import annotations

import hashlib
import re
import threading
from collections import OrderedDict
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from nmaptool.core.errors import InputError, reason_of
from nmaptool.io.pictures.reader import read_image
from nmaptool.io.stores.windows import Piece, bounds, pieces
from nmaptool.types.picture import RasterImage
from nmaptool.types.shown import counted

TILE_ENDINGS = (".png", ".tif", ".exr")
_TILE = re.compile(r"tile_(\d+)_(\d+)(\.png|\.tif|\.tiff|\.exr)", re.IGNORECASE)
# decoded tiles that are kept, because windows overlap
_KEPT_BYTES = 256 << 20
_KEPT_TILES = 12


def is_tile_folder(path: Path) -> bool:
    """Whether a folder holds tiles."""
    return bool(tiles_in(path))


def tiles_in(path: Path) -> list[Path]:
    """The tiles in a folder, unsorted; none if there is no such folder."""
    try:
        return [one for one in path.iterdir() if _TILE.fullmatch(one.name)] if path.is_dir() else []
    except OSError:
        return []


class TileFolder:
    """A picture in a folder of tiles; see `nmaptool.types.windows.PictureStore`.

    All tiles have the size of the first, those of the last row and the last column may be smaller.

    Parameters
    ----------
    name : str
        The folder.

    Raises
    ------
    InputError
        If a tile is missing, is there twice or cannot be read.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self._tiles = _listed(name)
        self._grid = tuple(1 + max(at[axis] for at in self._tiles) for axis in range(2))
        missing = [f"tile_{row}_{col}" for row in range(self._grid[0]) for col in range(self._grid[1])
                   if (row, col) not in self._tiles]  # fmt: skip
        if missing:
            raise InputError(
                f"{name}: holds tiles of {counted(self._grid[0], 'row')} and {counted(self._grid[1], 'column')}, but "
                f"{counted(len(missing), 'tile')} of them {'is' if len(missing) == 1 else 'are'} missing, such as "
                f"{missing[0]}; add them"
            )
        self._kept: OrderedDict[tuple[int, int], RasterImage] = OrderedDict()
        self._lock = threading.Lock()
        first = self._read((0, 0))
        self._first = first
        self.chunk = first.frame.shape
        last = self._read((self._grid[0] - 1, self._grid[1] - 1)).frame.shape
        self.rows, self.cols = (
            side * (count - 1) + end for side, count, end in zip(self.chunk, self._grid, last, strict=True)
        )
        self.channels = first.channels
        self.pitch_mm = first.frame.pitch_mm
        self.attributes: Mapping[str, str] = first.attributes

    def __reduce__(self) -> tuple[Any, ...]:
        return TileFolder, (self.name,)

    def read(self, rows: slice, cols: slice) -> RasterImage:
        """Return one window as it is stored.

        Raises
        ------
        InputError
            If a tile is damaged, or has another size or kind of pixels than the first.
        UsageError
            If the window does not lie in the picture.
        """
        window = bounds(self.name, rows, cols, (self.rows, self.cols))
        shape = (window[0].stop - window[0].start, window[1].stop - window[1].start)
        pixels = np.empty((*shape, len(self.channels)), self._first.pixels.dtype)
        for piece in pieces(window, self.chunk):
            pixels[piece.window] = self._checked(piece).pixels[piece.inside]
        return RasterImage(
            pixels=pixels,
            channels=self.channels,
            name=self.name,
            bits=self._first.bits,
            lossy=self._first.lossy,
            attributes=self.attributes,
            color_chunks=self._first.color_chunks,
            depth_facts=self._first.depth_facts,
            nodata=self._first.nodata,
            notes=self._first.notes,
            coarse=self._first.coarse,
        )

    def stamp(self) -> str:
        """Return a text that changes when the stored pixels change, from sizes and times of files."""
        found = hashlib.sha256()
        for at, path in sorted(self._tiles.items()):
            told = path.stat()
            found.update(repr((at, told.st_size, told.st_mtime_ns)).encode())
        return found.hexdigest()

    def _checked(self, piece: Piece) -> RasterImage:
        """A tile of the size and kind that its place needs."""
        tile, first = self._read(piece.block), self._first
        sides = zip(piece.block, self._grid, self.chunk, (self.rows, self.cols), strict=True)
        rows, cols = (side if at + 1 < count else whole - side * at for at, count, side, whole in sides)
        path = self._tiles[piece.block]
        if tile.frame.shape != (rows, cols):
            raise InputError(
                f"{path}: is {tile.frame} px, but the other tiles make this one {cols} x {rows}; save all tiles of one "
                "size, except those of the last row and the last column"
            )
        if tile.channels != first.channels or tile.pixels.dtype != first.pixels.dtype or tile.bits != first.bits:
            raise InputError(
                f"{path}: has {_kind(tile)}, but tile_0_0 has {_kind(first)}; save all tiles with the same channels"
            )
        return tile

    def _read(self, at: tuple[int, int]) -> RasterImage:
        with self._lock:
            if at in self._kept:
                self._kept.move_to_end(at)
                return self._kept[at]
        tile = read_image(self._tiles[at])
        with self._lock:
            self._kept[at] = tile
            most = max(1, min(_KEPT_TILES, _KEPT_BYTES // max(1, tile.pixels.nbytes)))
            while len(self._kept) > most:
                self._kept.popitem(last=False)
        return tile


def _kind(image: RasterImage) -> str:
    numbers = "floats" if image.is_float else "codes"
    return f"channels {', '.join(image.channels)} in {image.bits}-bit {numbers}"


def _listed(name: str) -> dict[tuple[int, int], Path]:
    """The files of a folder of tiles, by row and column."""
    tiles: dict[tuple[int, int], Path] = {}
    try:
        for path in Path(name).iterdir():
            found = _TILE.fullmatch(path.name)
            if found is None:
                continue
            at = (int(found[1]), int(found[2]))
            if at in tiles:
                raise InputError(f"{name}: holds both {tiles[at].name} and {path.name}; remove one of them")
            tiles[at] = path
    except OSError as error:
        raise InputError(f"{name}: cannot be read ({reason_of(error)})") from None
    if not tiles:
        raise InputError(f"{name}: is a folder without tiles; tiles are called tile_0_0.png, tile_0_1.png and so on")
    return tiles
