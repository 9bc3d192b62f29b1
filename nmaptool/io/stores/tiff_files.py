"""Read TIFF files by windows, without decoding the rest."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import tifffile

from nmaptool.core.errors import InputError, reason_of
from nmaptool.io.pictures.formats import TIFF
from nmaptool.io.pictures.layer_names import Holds
from nmaptool.io.pictures.request import Request
from nmaptool.io.pictures.tiff import is_common_tiff
from nmaptool.io.stores.names import split_name
from nmaptool.io.stores.tiff_segments import CommonPage, RarePage
from nmaptool.io.stores.windows import bounds
from nmaptool.types.picture import RasterImage

_HEAD_BYTES = 8
# wider pages in strips are slow, because a window is narrower than what must be decoded for it
_WIDE_PX = 8192
_IN_STRIPS = (
    "is packed in strips, so that every window unpacks whole rows: nmap compose convert to .zarr makes it faster"
)


def tiff_layout(path: Path) -> tuple[float, bool]:
    """Megapixels of the first page of a TIFF and whether it has tiles; 0 if the file is not one or is damaged."""
    try:
        with path.open("rb") as stream:
            if not TIFF.begins(stream.read(_HEAD_BYTES)):
                return 0.0, False
        with tifffile.TiffFile(path) as tiff:
            page = tiff.pages[0]
            return float(page.imagewidth) * float(page.imagelength) / 1e6, bool(page.is_tiled)
    except (OSError, ValueError, TypeError, AttributeError, IndexError, KeyError, tifffile.TiffFileError):
        return 0.0, False


class TiffPicture:
    """A picture in a TIFF; see `nmaptool.types.windows.PictureStore`.

    Parameters
    ----------
    name : str
        ``FILE``, or ``FILE:page``.
    layer : str, optional
        The page.
    holds : str
        As for `nmaptool.read_raster`.

    Raises
    ------
    InputError
        If it cannot be read.
    """

    def __init__(self, name: str, layer: str | None = None, holds: Holds = "normals") -> None:
        self._asked = (name, layer, holds)
        place, stated = split_name(name)
        self._path = Path(place)
        request = Request(layer or stated, math.inf, holds)
        page = CommonPage if is_common_tiff(self._path) else RarePage
        self._page: CommonPage | RarePage = page(self._path, request)
        self.rows, self.cols = self._page.shape
        self.chunk = self._page.block
        corner = self._page.read((slice(0, 1), slice(0, 1)))
        self.name = corner.name
        self.channels = corner.channels
        self.pitch_mm = corner.frame.pitch_mm
        self.attributes: Mapping[str, str] = corner.attributes
        self.is_slow = not self._page.tiled and self._page.packed and self.cols > _WIDE_PX
        self._notes = (_IN_STRIPS,) if self.is_slow else ()

    def __reduce__(self) -> tuple[Any, ...]:
        return TiffPicture, self._asked

    def read(self, rows: slice, cols: slice) -> RasterImage:
        """Return one window as it is stored.

        Raises
        ------
        InputError
            If a part of it is missing or damaged.
        UsageError
            If the window does not lie in the picture.
        """
        image = self._page.read(bounds(self.name, rows, cols, (self.rows, self.cols)))
        return replace(image, notes=(*image.notes, *self._notes))

    def stamp(self) -> str:
        """Return a text that changes when the file changes."""
        try:
            told = self._path.stat()
        except OSError as error:
            raise InputError(f"{self._path}: cannot be read ({reason_of(error)})") from None
        return hashlib.sha256(repr((told.st_size, told.st_mtime_ns)).encode()).hexdigest()
