"""Check the chunks of a PNG file before a decoder sees them."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from pathlib import Path

from nmaptool.core.errors import InputError
from nmaptool.io.pictures.facts import Facts
from nmaptool.io.pictures.request import Request
from nmaptool.io.pictures.size_limit import check_size
from nmaptool.types.shown import counted

SIGNATURE = b"\x89PNG\r\n\x1a\n"
_COLOR_CHUNKS = ("sRGB", "gAMA", "cHRM", "iCCP", "cICP")
_MAX_DEFLATE_RATIO = 1040


@dataclass(frozen=True)
class PngStructure:
    """Facts from the chunks of a PNG.

    Attributes
    ----------
    cols, rows : int
        Size that the header declares.
    color_chunks : tuple of str
        Colour-management chunks present.
    data_bytes : int
        Number of bytes of compressed picture data.
    pixel_bits : int
        Bits per pixel.
    palette : bool
        Whether pixels are places in a palette.
    sample_bits : int
        Bits per channel: 1, 2, 4, 8 or 16.
    """

    cols: int
    rows: int
    color_chunks: tuple[str, ...]
    data_bytes: int
    pixel_bits: int
    palette: bool = False
    sample_bits: int = 8

    @property
    def is_possible(self) -> bool:
        """Whether the compressed data can unpack to a picture of this size."""
        return self.cols * self.rows * self.pixel_bits / 8 <= self.data_bytes * _MAX_DEFLATE_RATIO + 65536


def read_structure(path: Path, max_megapixels: float) -> PngStructure:
    """Walk the chunks and check lengths and checksums.

    Raises
    ------
    InputError
        If the file is truncated or damaged.
    LimitError
        If the header declares more than ``max_megapixels``; checked first, since such a file is often just a header.
    """
    colors: list[str] = []
    header: tuple[int, int, int, int, int] | None = None
    data_bytes = 0
    damaged = InputError(f"{path}: the PNG file is truncated or damaged; export or download it again")
    with path.open("rb") as stream:
        if stream.read(8) != SIGNATURE:
            raise damaged
        while True:
            head = stream.read(8)
            if len(head) < 8:
                raise damaged
            size, kind = struct.unpack(">I4s", head)
            if size > 0x7FFFFFFF:
                raise damaged
            body = stream.read(size)
            check = stream.read(4)
            if len(body) < size or len(check) < 4 or zlib.crc32(body, zlib.crc32(kind)) != int.from_bytes(check, "big"):
                raise damaged
            name = kind.decode("latin-1")
            if name == "IHDR" and size == 13:
                cols, rows, depth, color = struct.unpack(">IIBB", body[:10])
                check_size(path, cols, rows, max_megapixels)
                header = (cols, rows, depth * {2: 3, 4: 2, 6: 4}.get(color, 1), depth, color)
            elif name == "IDAT":
                data_bytes += size
            elif name in _COLOR_CHUNKS:
                colors.append(name)
            elif name == "IEND":
                break
    if header is None or min(header[:4]) < 1:
        raise damaged
    return PngStructure(header[0], header[1], tuple(colors), data_bytes, header[2], header[4] == 3, header[3])


def png_facts(path: Path, request: Request) -> Facts:
    """Check the chunks of a PNG.

    Raises
    ------
    InputError, LimitError
        As `read_structure`; also if the data cannot be a picture of the declared size.
    """
    structure = read_structure(path, request.max_megapixels)
    if not structure.is_possible:
        raise InputError(f"{path}: the PNG file is truncated or damaged; export or download it again")
    notes: tuple[str, ...] = ()
    if structure.palette:
        notes = (f"its colours are a palette of at most {2**structure.sample_bits}",)
    elif structure.sample_bits < 8:
        notes = (f"has only {counted(structure.sample_bits, 'bit')} per channel",)
    return Facts(structure.color_chunks, notes=notes, coarse=bool(notes))
