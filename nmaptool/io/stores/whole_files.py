"""Pictures in ordinary files behind the interface of stores: read once, as a whole."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from nmaptool.core.errors import InputError, reason_of
from nmaptool.io.pictures.layer_names import Holds
from nmaptool.io.pictures.normal_maps import read_raster, split_layer
from nmaptool.io.stores.windows import bounds
from nmaptool.options import ReadOptions
from nmaptool.types.picture import RasterImage


class WholeFile:
    """A picture in a file that is read as a whole; see `nmaptool.types.windows.PictureStore`.

    Parameters
    ----------
    name : str
        ``FILE`` or ``FILE.exr:layer``.
    layer : str, optional
    holds : str
        As for `nmaptool.read_raster`.
    max_megapixels : float
        Refuse larger ones.
    """

    def __init__(
        self,
        name: str,
        layer: str | None = None,
        holds: Holds = "normals",
        max_megapixels: float = ReadOptions.max_megapixels,
    ) -> None:
        self._asked = (name, layer, holds, max_megapixels)
        self.image = read_raster(name, ReadOptions(layer=layer, max_megapixels=max_megapixels), holds=holds)
        self.name = self.image.name
        self.rows, self.cols = self.image.frame.shape
        self.chunk = self.image.frame.shape
        self.channels = self.image.channels
        self.pitch_mm = self.image.frame.pitch_mm
        self.attributes: Mapping[str, str] = self.image.attributes

    def __reduce__(self) -> tuple[Any, ...]:
        return WholeFile, self._asked

    def read(self, rows: slice, cols: slice) -> RasterImage:
        """Return one window as it is stored."""
        window = bounds(self.name, rows, cols, (self.rows, self.cols))
        return replace(self.image, pixels=self.image.pixels[window])

    def stamp(self) -> str:
        """Return a text that changes when the file changes."""
        path, _ = split_layer(self._asked[0])
        try:
            told = path.stat()
        except OSError as error:
            raise InputError(f"{path}: cannot be read ({reason_of(error)})") from None
        return hashlib.sha256(repr((told.st_size, told.st_mtime_ns)).encode()).hexdigest()
