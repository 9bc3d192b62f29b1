"""Names of stores: paths, URLs that fsspec opens, and the layer after a colon."""

from __future__ import annotations

import os
import re
from pathlib import Path, PurePosixPath
from typing import Literal, NamedTuple

_URL = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+://")
_FILE = "file://"
ZARR_ENDING = ".zarr"
_TIFF_ENDINGS = (".tif", ".tiff")
OutputKind = Literal["zarr", "tiles", "tiff"]
# the files that make a folder a Zarr array or group: of version 3, of version 2
ZARR_FILES = ("zarr.json", ".zarray", ".zgroup")


class StoreName(NamedTuple):
    """The parts of a name.

    Attributes
    ----------
    place : str
        The path or the URL.
    layer : str or None
        The array of a group, or the layer or page of a file.
    """

    place: str
    layer: str | None

    @property
    def path(self) -> Path | None:
        """The path of a store on this machine; None for other URLs."""
        return local_path(self.place)


def split_name(name: str) -> StoreName:
    """Split ``plate.zarr:detail`` into a place and a layer; a file or folder with exactly that name takes precedence.

    >>> split_name("s3://scans/plate.zarr:detail")
    StoreName(place='s3://scans/plate.zarr', layer='detail')
    >>> split_name("s3://scans/plate.zarr").layer is None
    True
    """
    head, mark, layer = name.rpartition(":")
    is_layer = mark and layer and not set(layer) & set("/\\") and PurePosixPath(head).suffix
    if is_layer and not os.path.exists(name):  # noqa: PTH110 - never raises
        return StoreName(head, layer)
    return StoreName(name, None)


def is_url(name: str) -> bool:
    """Whether a name is a URL.

    >>> is_url("memory://plate.zarr"), is_url("C:/plate.zarr")
    (True, False)
    """
    return _URL.match(name) is not None


def local_path(place: str) -> Path | None:
    """The path of a place on this machine, which may be written as file://; None for other URLs."""
    if place.lower().startswith(_FILE):
        from urllib.parse import urlsplit
        from urllib.request import url2pathname

        return Path(url2pathname(urlsplit(place).path))
    return None if is_url(place) else Path(place)


def is_zarr(place: str) -> bool:
    """Whether a place is a Zarr array or group, or is called so."""
    path = local_path(place)
    if path is None:
        return True
    if path.is_dir():
        return any((path / name).is_file() for name in ZARR_FILES) or path.suffix.lower() == ZARR_ENDING
    return not path.exists() and path.suffix.lower() == ZARR_ENDING


def output_kind(name: str) -> OutputKind | None:
    """What a name stands for: a Zarr store, a folder of tiles (without an ending, or with a slash), a TIFF.

    >>> [output_kind(name) for name in ("map.zarr", "tiles/", "tiles", "map.tif", "map.png")]
    ['zarr', 'tiles', 'tiles', 'tiff', None]
    """
    place, _ = split_name(name)
    ending = Path(place.rstrip("/")).suffix.lower()
    if ending == ZARR_ENDING:
        return "zarr"
    if name.endswith(("/", "\\")) or not ending:
        return "tiles"
    return "tiff" if ending in _TIFF_ENDINGS else None
