"""Read PFM (floats, bottom row first) and binary PGM and PPM files."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.errors import InputError
from nmaptool.io.pictures.request import Request, damaged
from nmaptool.io.pictures.sample_types import as_pixels
from nmaptool.types.picture import RasterImage

# the magic, then three numbers, with comments between them; one white character before the data
_TOKEN = rb"(?:\s+|#[^\n\r]*[\n\r])+"
_HEADER = re.compile(
    rb"(P[Ff56])" + _TOKEN + rb"(\d{1,9})" + _TOKEN + rb"(\d{1,9})" + _TOKEN + rb"([-+0-9.eE]{1,40})(?:\r\n|\s)"
)
_MOST_HEADER = 4096
_CHANNELS = {1: ("Y",), 3: ("R", "G", "B")}


def _open(path: Path, request: Request, kind: str) -> tuple[re.Match[bytes], int, int]:
    """The header, columns and rows."""
    request.refuse_layer(path, kind)
    with path.open("rb") as stream:
        header = _HEADER.match(stream.read(_MOST_HEADER))
    if header is None:
        raise damaged(path, kind)
    cols, rows = int(header[2]), int(header[3])
    request.check_size(path, cols, rows)
    if not cols or not rows:
        raise damaged(path, kind)
    return header, cols, rows


def read_pfm(path: Path, request: Request) -> RasterImage:
    """Read a PFM.

    Raises
    ------
    InputError, LimitError
    """
    header, cols, rows = _open(path, request, "PFM")
    count = 3 if header[1] == b"PF" else 1
    try:
        scale = float(header[4])
    except ValueError:
        scale = math.nan
    if not math.isfinite(scale) or scale == 0:
        raise damaged(path, "PFM")
    values = _data(path, header.end(), "<f4" if scale < 0 else ">f4", rows * cols * count, "PFM")
    pixels = as_pixels(str(path), values.reshape(rows, cols, count)[::-1])
    notes = () if abs(scale) == 1 else (f"states a scale of {abs(scale):g}, which is not applied",)
    return RasterImage(np.ascontiguousarray(pixels.values), _CHANNELS[count], str(path), pixels.bits, notes=notes)


def read_pnm(path: Path, request: Request) -> RasterImage:
    """Read a binary PGM or PPM; codes whose largest is not 255 or 65535 are scaled to that.

    Raises
    ------
    InputError, LimitError
    """
    header, cols, rows = _open(path, request, "PGM/PPM")
    count = 3 if header[1] == b"P6" else 1
    try:
        top = int(header[4])
    except ValueError:
        top = 0
    if not 1 <= top <= 65535:
        raise damaged(path, "PGM/PPM")
    values = _data(path, header.end(), ">u2" if top > 255 else "u1", rows * cols * count, "PGM/PPM")
    full: int = 65535 if top > 255 else 255
    notes: tuple[str, ...] = ()
    if values.size and int(values.max()) > top:
        raise InputError(f"{path}: holds the code {int(values.max())}, above its largest, {top}; save it again")
    if top != full:
        values = np.rint(values.astype(np.float64) * (full / top)).astype(values.dtype)
        notes = (f"its codes go to {top} and are scaled to {full}",)
    pixels = as_pixels(str(path), values.reshape(rows, cols, count))
    return RasterImage(pixels.values, _CHANNELS[count], str(path), pixels.bits, notes=notes)


def _data(path: Path, start: int, kind: str, count: int, name: str) -> NDArray[Any]:
    """The samples after the header, exactly as many as it declares."""
    with path.open("rb") as stream:
        size = stream.seek(0, 2)
        if size - start < count * np.dtype(kind).itemsize:
            raise damaged(path, name)
        stream.seek(start)
        return np.fromfile(stream, kind, count)
