"""Read BMP files with any header: 1 to 32 bits, palettes, run lengths, channel masks, top row first or last.

OpenImageIO ignores the channel masks, so it swaps red and blue of some files without a word.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.errors import InputError
from nmaptool.io.pictures.bmp_runs import unpack_runs
from nmaptool.io.pictures.request import Request, damaged
from nmaptool.types.picture import RasterImage

_FILE_HEADER = 14
_OS2_HEADER, _PLAIN_HEADER, _V4_HEADER = 12, 40, 108
_HEADERS = (_OS2_HEADER, 16, _PLAIN_HEADER, 52, 56, 64, _V4_HEADER, 124)
_RGB, _RLE8, _RLE4, _MASKS, _ALPHA_MASKS = 0, 1, 2, 3, 6
_EMBEDDED = {4: "JPEG", 5: "PNG"}
_RUN_BITS = {_RLE8: 8, _RLE4: 4}
# channel masks of files that state none
_USUAL_MASKS = {16: (0x7C00, 0x3E0, 0x1F, 0), 32: (0xFF0000, 0xFF00, 0xFF, 0xFF000000)}
_LEAST_PROFILE = 0x4D424544  # 'MBED' of an embedded ICC profile


@dataclass(frozen=True)
class _Header:
    """The headers of a file."""

    cols: int
    rows: int
    top_down: bool
    bits: int
    packing: int
    size: int
    data: int
    entries: int
    masks: tuple[int, int, int, int]
    profile: bool

    @property
    def entry_bytes(self) -> int:
        return 3 if self.size == _OS2_HEADER else 4


def read_bmp(path: Path, request: Request) -> RasterImage:
    """Read a BMP.

    Raises
    ------
    InputError, LimitError
    """
    request.refuse_layer(path, "BMP")
    data = path.read_bytes()
    try:
        header = _header(path, data)
    except struct.error:
        raise damaged(path, "BMP") from None
    request.check_size(path, header.cols, header.rows)
    if header.bits <= 8:
        pixels, channels, notes = _indexed(path, header, data)
    elif header.bits == 24:
        rows = _rows(path, header, data)[:, : header.cols * 3]
        pixels, channels, notes = rows.reshape(header.rows, header.cols, 3)[..., ::-1], ("R", "G", "B"), ()
    else:
        pixels, channels, notes = _masked(path, header, data)
    if not header.top_down:
        pixels = pixels[::-1]
    colors = ("ICC profile",) if header.profile else ()
    bits = 8 * pixels.dtype.itemsize
    return RasterImage(
        np.ascontiguousarray(pixels), channels, str(path), bits, color_chunks=colors, notes=notes, coarse=bool(notes)
    )


def _header(path: Path, data: bytes) -> _Header:
    start, size = struct.unpack_from("<I", data, 10)[0], struct.unpack_from("<I", data, _FILE_HEADER)[0]
    if size not in _HEADERS:
        raise damaged(path, "BMP")
    if size == _OS2_HEADER:
        cols, rows, planes, bits = struct.unpack_from("<HHHH", data, _FILE_HEADER + 4)
        packing, entries = _RGB, 0
    else:
        cols, rows, planes, bits = struct.unpack_from("<iiHH", data, _FILE_HEADER + 4)
        packing, entries = 0, 0
        if size >= _PLAIN_HEADER:
            (packing,), (entries,) = (struct.unpack_from("<I", data, _FILE_HEADER + at) for at in (16, 32))
    if packing in _EMBEDDED:
        raise InputError(f"{path}: is a BMP around a {_EMBEDDED[packing]}; export it as PNG")
    plain = packing == _RGB and bits in (1, 2, 4, 8, 16, 24, 32)
    runs = _RUN_BITS.get(packing) == bits and rows > 0
    masked = packing in (_MASKS, _ALPHA_MASKS) and bits in (16, 32) and size != 64
    if cols < 1 or not rows or planes != 1 or not (plain or runs or masked) or start < _FILE_HEADER + size:
        raise damaged(path, "BMP")
    masks = _USUAL_MASKS.get(bits, (0, 0, 0, 0))
    if masked:
        count = 4 if packing == _ALPHA_MASKS or size >= 56 else 3
        masks = (*struct.unpack_from(f"<{count}I", data, _FILE_HEADER + _PLAIN_HEADER), 0)[:4]
    space = struct.unpack_from("<I", data, _FILE_HEADER + 56)[0] if size >= _V4_HEADER else 0
    top_down = size != _OS2_HEADER and rows < 0
    return _Header(
        cols, abs(rows), top_down, bits, packing, size, start, entries, masks, size == 124 and space == _LEAST_PROFILE
    )


def _rows(path: Path, header: _Header, data: bytes) -> NDArray[np.uint8]:
    """(rows, bytes per row) in the order of the file."""
    stride = (header.cols * header.bits + 31) // 32 * 4
    if len(data) < header.data + stride * header.rows:
        raise damaged(path, "BMP")
    return np.frombuffer(data, np.uint8, stride * header.rows, header.data).reshape(header.rows, stride)


def _indexed(path: Path, header: _Header, data: bytes) -> tuple[NDArray[Any], tuple[str, ...], tuple[str, ...]]:
    """A picture with a palette, as grey if the palette is grey."""
    if header.packing == _RGB:
        index = _places(_rows(path, header, data), header)
    else:
        found = unpack_runs(data[header.data :], header.cols, header.rows, header.bits)
        if found is None:
            raise damaged(path, "BMP")
        index = found
    begin = _FILE_HEADER + header.size
    room = max(0, min(header.data, len(data)) - begin) // header.entry_bytes
    count = min(header.entries or 1 << header.bits, 1 << header.bits, room)
    if not count or int(index.max()) >= count:
        raise damaged(path, "BMP")
    entries = np.frombuffer(data, np.uint8, count * header.entry_bytes, begin).reshape(count, -1)[:, 2::-1]
    if (entries[:, 0] == entries[:, 1]).all() and (entries[:, 0] == entries[:, 2]).all():
        notes = () if header.bits == 8 else (f"has only {1 << header.bits} shades of grey",)
        return entries[:, :1][index], ("Y",), notes
    return entries[index], ("R", "G", "B"), (f"its colours are a palette of {count}",)


def _places(packed: NDArray[np.uint8], header: _Header) -> NDArray[np.uint8]:
    """(rows, cols) places in the palette, the first in the highest bits of a byte."""
    if header.bits == 8:
        return packed[:, : header.cols]
    shifts = np.arange(8 - header.bits, -1, -header.bits, dtype=np.uint8)
    places = packed[..., None] >> shifts & np.uint8((1 << header.bits) - 1)
    return np.asarray(places.reshape(header.rows, -1)[:, : header.cols])


def _masked(path: Path, header: _Header, data: bytes) -> tuple[NDArray[Any], tuple[str, ...], tuple[str, ...]]:
    """A picture whose channels are bits of 16- or 32-bit numbers."""
    width = header.bits // 8
    rows = _rows(path, header, data)[:, : header.cols * width]
    numbers = np.ascontiguousarray(rows).view(f"<u{width}")
    masks = [mask for mask in header.masks if mask]
    if len(masks) < 3 or not all(header.masks[:3]) or any(not _is_run(mask) for mask in masks):
        raise damaged(path, "BMP")
    depth = min(mask.bit_count() for mask in masks[:3])
    full = 255 if depth <= 8 else 65535
    pixels = np.dstack([_channel(numbers, mask, full) for mask in masks])
    notes: tuple[str, ...] = (f"has only {depth} bits per channel",) if depth < 8 else ()
    if pixels.shape[2] == 4 and np.ptp(pixels[..., 3]) == 0 and (not pixels[0, 0, 3] or header.packing == _RGB):
        pixels = pixels[..., :3]  # an unused byte
    return pixels, ("R", "G", "B", "A")[: pixels.shape[2]], notes


def _is_run(mask: int) -> bool:
    """Whether the bits of a mask are neighbours."""
    low = mask >> ((mask & -mask).bit_length() - 1)
    return low & (low + 1) == 0


def _channel(numbers: NDArray[Any], mask: int, full: int) -> NDArray[Any]:
    """The bits of a mask as codes from 0 to ``full``."""
    shift, top = (mask & -mask).bit_length() - 1, (1 << mask.bit_count()) - 1
    values = (numbers & mask) >> shift
    kind = np.uint8 if full == 255 else np.uint16
    return values.astype(kind) if top == full else np.floor(values * (full / top) + 0.5).astype(kind)
