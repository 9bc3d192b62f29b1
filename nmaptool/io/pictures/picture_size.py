"""The size of a picture, from its header alone."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from nmaptool.core.errors import NmaptoolError
from nmaptool.io.pictures.formats import find_format
from nmaptool.io.pictures.layer_names import Holds
from nmaptool.io.pictures.normal_maps import split_layer
from nmaptool.io.pictures.request import Request


class _SizeKnown(Exception):  # noqa: N818 - no error
    """Ends a reader once it has read the header."""

    def __init__(self, cols: int, rows: int) -> None:
        self.size = cols, rows


@dataclass(frozen=True)
class _SizeRequest(Request):
    """Asks for the size instead of the pixels: every reader calls `check_size` before it allocates them."""

    def check_size(self, path: Path, cols: int, rows: int) -> None:
        raise _SizeKnown(cols, rows)


def picture_size(name: str | Path, holds: Holds = "normals") -> tuple[int, int] | None:
    """Return the columns and rows of a picture, such as ``map.exr:detail``; None if it cannot be read."""
    path, layer = split_layer(str(name))
    try:
        kind = find_format(path)
        kind.function(kind.reader)(path, _SizeRequest(layer, holds=holds))
    except _SizeKnown as found:
        return found.size
    except (NmaptoolError, OSError):
        return None
    return None
