"""Read DDS textures: OpenImageIO unpacks blocks of colours; signed blocks and plain numbers are read here."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.errors import InputError
from nmaptool.io.pictures.dds_blocks import unpack_blocks
from nmaptool.io.pictures.facts import Facts
from nmaptool.io.pictures.request import Request, damaged
from nmaptool.io.pictures.sample_types import as_pixels
from nmaptool.io.pictures.through_oiio import read_checked
from nmaptool.types.picture import RasterImage

_CUBE, _VOLUME, _FOUR_LETTERS, _BUMPS = 0x200, 0x200000, 0x4, 0x80000
_CHANNELS = {1: ("Y",), 2: ("R", "G"), 3: ("R", "G", "B"), 4: ("R", "G", "B", "A")}
# blocks that OpenImageIO unpacks, by four letters and by DXGI number
_BLOCKS = {b"DXT1": "BC1", b"DXT2": "BC2", b"DXT3": "BC2", b"DXT4": "BC3", b"DXT5": "BC3", b"RXGB": "BC3"}
_BLOCKS |= {b"A2D5": "BC3", b"A2XY": "BC5"}
_DXGI_BLOCKS = {71: "BC1", 72: "BC1", 74: "BC2", 75: "BC2", 77: "BC3", 78: "BC3", 95: "BC6H", 96: "BC6H"}
_DXGI_BLOCKS |= {98: "BC7", 99: "BC7"}
# blocks without a type, which some programs write, are read as unsigned
_TYPELESS = {79: 80, 82: 83}
# blocks of one or two channels: how many, and whether they are signed
_FEW = {b"ATI1": (1, False), b"BC4U": (1, False), b"BC4S": (1, True)}
_FEW |= {b"ATI2": (2, False), b"BC5U": (2, False), b"BC5S": (2, True)}
_DXGI_FEW = {80: (1, False), 81: (1, True), 83: (2, False), 84: (2, True)}
# plain numbers: type and count of channels, by DXGI number and by the number in place of the four letters
_PLAIN = {2: ("<f4", 4), 6: ("<f4", 3), 10: ("<f2", 4), 11: ("<u2", 4), 13: ("<i2", 4), 16: ("<f4", 2)}
_PLAIN |= {28: ("u1", 4), 29: ("u1", 4), 31: ("i1", 4), 34: ("<f2", 2), 35: ("<u2", 2), 37: ("<i2", 2), 41: ("<f4", 1)}
_PLAIN |= {49: ("u1", 2), 51: ("i1", 2), 54: ("<f2", 1), 56: ("<u2", 1), 58: ("<i2", 1), 61: ("u1", 1), 63: ("i1", 1)}
# plain codes that OpenImageIO reads
_CODES = (85, 86, 87, 88, 91, 93, 115)
# signed numbers of older files, by their bits and the masks of the first two channels
_SIGNED = {(16, 0xFF, 0xFF00): 51, (32, 0xFF, 0xFF00): 31, (32, 0xFFFF, 0xFFFF0000): 37}
_NUMBERED = {36: 11, 110: 13, 111: 54, 112: 34, 113: 10, 114: 41, 115: 16, 116: 2}


@dataclass(frozen=True)
class _Header:
    """What the headers of a texture say."""

    cols: int
    rows: int
    letters: bytes
    dxgi: int
    start: int
    bits: int
    masks: tuple[int, ...]
    bumps: bool

    @property
    def blocks(self) -> str | None:
        """The kind of blocks that OpenImageIO unpacks."""
        return _DXGI_BLOCKS.get(self.dxgi) if self.letters == b"DX10" else _BLOCKS.get(self.letters)

    @property
    def few(self) -> tuple[int, bool] | None:
        """The number of channels of blocks of one or two, and whether they are signed."""
        return _DXGI_FEW.get(self.dxgi) if self.letters == b"DX10" else _FEW.get(self.letters)

    @property
    def unknown(self) -> str | None:
        """The name of a format that is not read."""
        if self.blocks is not None or self.few is not None or self.plain is not None or self.dxgi in _CODES:
            return None
        if self.letters == b"DX10":
            return f"DXGI format {self.dxgi}"
        if self.letters:
            name = self.letters.decode("latin-1")
            return f"format {name}" if name.isprintable() else f"format {int.from_bytes(self.letters, 'little')}"
        most = max(mask.bit_count() for mask in self.masks)
        return "signed numbers" if self.bumps else f"{most} bits per channel" if most > 8 else None

    @property
    def plain(self) -> tuple[str, int] | None:
        """Type and count of plain numbers."""
        if self.letters == b"DX10":
            return _PLAIN.get(self.dxgi)
        if self.letters:
            number = int.from_bytes(self.letters, "little")
            return _PLAIN.get(_NUMBERED.get(number, 0))
        if self.bumps:
            return _PLAIN.get(_SIGNED.get((self.bits, self.masks[0], self.masks[1]), 0))
        grey = self.bits == 16 and self.masks[0] == 0xFFFF and not any(self.masks[1:])
        return _PLAIN[56] if grey else _PLAIN[35] if self.masks[:2] == (0xFFFF, 0xFFFF0000) else None


def _header(path: Path, request: Request) -> _Header:
    """The headers of one flat picture.

    Raises
    ------
    InputError, LimitError
    """
    with path.open("rb") as stream:
        data = stream.read(148)
    if len(data) < 128 or struct.unpack_from("<I", data, 4)[0] != 124:
        raise damaged(path, "DDS")
    rows, cols = struct.unpack_from("<II", data, 12)
    flags, letters, bits, *masks = struct.unpack_from("<I4sI4I", data, 80)
    caps = struct.unpack_from("<I", data, 112)[0]
    letters = letters if flags & _FOUR_LETTERS else b""
    dxgi, start = 0, 128
    if letters == b"DX10":
        if len(data) < 148:
            raise damaged(path, "DDS")
        dxgi, _, misc, slices = struct.unpack_from("<4I", data, 128)
        caps |= _CUBE if misc & 4 else _VOLUME if slices > 1 else 0
        dxgi, start = _TYPELESS.get(dxgi, dxgi), 148
    if caps & (_CUBE | _VOLUME):
        raise InputError(f"{path}: is a cube map, volume or array of textures; save one picture of it")
    request.check_size(path, cols, rows)
    if not cols or not rows:
        raise damaged(path, "DDS")
    return _Header(cols, rows, letters, dxgi, start, bits, tuple(masks), bool(flags & _BUMPS))


def dds_facts(path: Path, request: Request) -> Facts:
    """What the blocks of a texture mean for its codes.

    Raises
    ------
    InputError, LimitError
    """
    blocks = _header(path, request).blocks
    return Facts() if blocks is None else Facts(lossy=True, notes=(f"is block-compressed ({blocks})",), coarse=True)


def read_dds(path: Path, request: Request) -> RasterImage:
    """Read the largest picture of a texture.

    Raises
    ------
    InputError, LimitError
    """
    header = _header(path, request)
    if header.few is None and header.plain is None:
        if header.unknown is not None:
            raise InputError(f"{path}: is a DDS in {header.unknown}; save it as BC5, BC7 or uncompressed, or as PNG")
        return read_checked(path, request)
    request.refuse_layer(path, "DDS")
    with path.open("rb") as stream:
        stream.seek(header.start)
        if header.plain is not None:
            kind, count = header.plain
            values = _plain(path, stream.read(header.rows * header.cols * count * np.dtype(kind).itemsize), header)
            return _signed_as_shares(path, values)
        count, signed = header.few or (1, False)
        size = -(-header.rows // 4) * -(-header.cols // 4) * 8 * count
        data = stream.read(size)
    if len(data) < size:
        raise damaged(path, "DDS")
    values = unpack_blocks(data, (header.rows, header.cols, count), signed=signed)
    notes = (f"is block-compressed (BC{3 + count}{', signed' if signed else ''})",)
    return RasterImage(values, _CHANNELS[count], str(path), 32 if signed else 8, lossy=True, notes=notes, coarse=True)


def _plain(path: Path, data: bytes, header: _Header) -> NDArray[Any]:
    kind, count = header.plain or ("u1", 1)
    if len(data) < header.rows * header.cols * count * np.dtype(kind).itemsize:
        raise damaged(path, "DDS")
    return np.frombuffer(data, kind).reshape(header.rows, header.cols, count)


def _signed_as_shares(path: Path, values: NDArray[Any]) -> RasterImage:
    """The picture of plain numbers; signed ones are shares of their largest, as the format says."""
    notes: tuple[str, ...] = ()
    if values.dtype.kind == "i":
        notes = (f"stores {8 * values.dtype.itemsize}-bit signed shares from -1 to 1",)
        values = np.maximum(values / np.iinfo(values.dtype).max, -1).astype(np.float32)
    pixels = as_pixels(str(path), values)
    channels = _CHANNELS[values.shape[2]]
    return RasterImage(pixels.values, channels, str(path), pixels.bits, notes=(*notes, *pixels.notes))
