"""Decode parts of TIFF pages: with OpenImageIO, or with tifffile where OpenImageIO does not know the packing."""

from __future__ import annotations

import threading
import weakref
from pathlib import Path
from typing import Any

import numpy as np
import tifffile
from numpy.typing import NDArray

from nmaptool.core.errors import InputError
from nmaptool.io.pictures import exr_layers as layers
from nmaptool.io.pictures.request import Request
from nmaptool.io.pictures.through_oiio import (
    channel_span,
    chosen_channels,
    open_source,
    picture_of,
    refuse_deep,
    refuse_numbers,
    stored_type,
)
from nmaptool.io.pictures.tiff import tiff_facts
from nmaptool.io.pictures.tiff_pages import (
    codecs_named,
    page_number,
    page_of,
    picture_of_page,
    tiff_damage_named,
    usable_page,
)
from nmaptool.io.stores.windows import pieces, within
from nmaptool.types.picture import RasterImage

# rows of a page in strips are decoded over their whole width, about so many bytes at once
_BAND_BYTES = 64 << 20
Window = tuple[slice, slice]


class CommonPage:
    """A page that OpenImageIO decodes.

    Parameters
    ----------
    path : Path
    request : Request

    Attributes
    ----------
    shape : (int, int)
    block : (int, int)
        Rows and columns that are decoded at once.
    tiled : bool
    packed : bool
        Whether it is compressed.
    """

    def __init__(self, path: Path, request: Request) -> None:
        self._source = open_source(path, request)
        parts, facts = self._source.parts(), self._source.facts
        self._layer = layers.choose(path, parts, request, pages=facts.pages, names=facts.names)
        self._spec = spec = parts[self._layer.part]
        refuse_deep(path, spec)
        refuse_numbers(self._source, self._layer)
        data, full = (spec.x, spec.y, spec.width, spec.height), (spec.full_x, spec.full_y)
        if data != (*full, spec.full_width, spec.full_height):
            raise InputError(f"{path}: is a part of a larger page; save it as a page of its own")
        self.shape = (int(spec.height), int(spec.width))
        strip = max(1, spec.get_int_attribute("tiff:RowsPerStrip", 1))
        self.tiled = spec.tile_width > 0
        self.block = (
            (int(spec.tile_height), int(spec.tile_width)) if self.tiled else (min(strip, spec.height), spec.width)
        )
        self.packed = str(spec.getattribute("compression") or "none") != "none"
        self._stored, self._kind = stored_type(path, spec, self._layer)
        self._path = path

    def read(self, window: Window) -> RasterImage:
        """Return a window.

        Raises
        ------
        InputError
            If a part of it is missing or damaged.
        """
        values = self._tiles(window) if self.tiled else self._rows(window)
        return picture_of(
            self._source, self._spec, self._layer, chosen_channels(values, self._layer), self._stored, placed=True
        )

    def _tiles(self, window: Window) -> NDArray[Any]:
        around = tuple(
            slice(part.start // unit * unit, min(size, -(-part.stop // unit) * unit))
            for part, unit, size in zip(window, self.block, self.shape, strict=True)
        )
        rows, cols = around
        span = channel_span(self._layer)
        values = self._source.reader.read_tiles(
            self._layer.part,
            0,
            *(self._spec.x + cols.start, self._spec.x + cols.stop),
            *(self._spec.y + rows.start, self._spec.y + rows.stop),
            *(0, 1),
            *span,
            self._kind,
        )
        return self._checked(values, rows)[within(window, (rows, cols))]

    def _rows(self, window: Window) -> NDArray[Any]:
        rows, cols = window
        span = channel_span(self._layer)
        a_row = max(1, self.shape[1] * (span[1] - span[0]) * 4)
        count = max(1, _BAND_BYTES // a_row)
        bands = []
        for first in range(rows.start, rows.stop, count):
            band = slice(first, min(first + count, rows.stop))
            top, bottom = self._spec.y + band.start, self._spec.y + band.stop
            values = self._source.reader.read_scanlines(self._layer.part, 0, top, bottom, 0, *span, self._kind)
            bands.append(self._checked(values, band)[:, cols].copy())
        return bands[0] if len(bands) == 1 else np.concatenate(bands)

    def _checked(self, values: Any, rows: slice) -> NDArray[Any]:
        if values is None:
            self._source.reader.geterror()
            raise _damaged(self._path, rows)
        return np.asarray(values).reshape(rows.stop - rows.start, -1, np.shape(values)[-1])


class RarePage:
    """A page that tifffile decodes; attributes as those of `CommonPage`."""

    def __init__(self, path: Path, request: Request) -> None:
        self._path, self._request = path, request
        self._facts = tiff_facts(path, request)
        self._number = page_number(path, request, self._facts)
        with tiff_damage_named(path):
            tiff = tifffile.TiffFile(path)
            weakref.finalize(self, tiff.close)
            page = usable_page(path, tiff, self._number)
            self._page = page
            self.shape = (int(page.imagelength), int(page.imagewidth))
            rows = page.tilelength if page.is_tiled else min(page.rowsperstrip, page.imagelength)
            self.block = (int(rows), int(page.tilewidth if page.is_tiled else page.imagewidth))
            self._decode = page.decode
        self.packed = page.compression != 1
        self.tiled = bool(page.is_tiled)
        self._lock = threading.Lock()

    def read(self, window: Window) -> RasterImage:
        """Return a window; errors as of `CommonPage.read`."""
        planes, _, _, _, count = self._page.shaped
        shape = tuple(part.stop - part.start for part in window)
        grid = tuple(-(-size // unit) for size, unit in zip(self.shape, self.block, strict=True))
        values = np.empty((planes, *shape, count), self._page.dtype)
        for piece in pieces(window, self.block):
            for plane in range(planes):
                number = (plane * grid[0] + piece.block[0]) * grid[1] + piece.block[1]
                values[plane][piece.window] = self._segment(number, piece.block)[piece.inside]
        return picture_of_page(self._path, self._request, self._facts, page_of(self._page, self._number, values))

    def _segment(self, number: int, block: tuple[int, int]) -> NDArray[Any]:
        page, first = self._page, block[0] * self.block[0]
        rows = slice(first, min(first + self.block[0], self.shape[0]))
        with tiff_damage_named(self._path):
            offset, size = page.dataoffsets[number], page.databytecounts[number]
            with self._lock:
                page.parent.filehandle.seek(offset)
                data = page.parent.filehandle.read(size) if offset and size else b""
        if not data or len(data) < size:
            raise _damaged(self._path, rows)
        tables = {"jpegtables": page.jpegtables, "jpegheader": page.jpegheader} if page.compression in (6, 7) else {}
        try:
            with tiff_damage_named(self._path), codecs_named(self._path, page):
                values = self._decode(data, number, **tables, _fullsize=True)[0]
        except InputError as error:
            if "codecs" in str(error):
                raise
            raise _damaged(self._path, rows) from None
        if values is None:
            raise _damaged(self._path, rows)
        found: NDArray[Any] = np.asarray(values)[0]
        return found


def _damaged(path: Path, rows: slice) -> InputError:
    return InputError(
        f"{path}: a part of rows {rows.start} to {rows.stop} is missing or damaged; export or download the file again"
    )
