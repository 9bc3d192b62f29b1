"""TGA files, which no identifying bytes begin: a plausible header and the extension, or the footer of version 2."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import NamedTuple

from nmaptool.io.pictures.facts import Facts
from nmaptool.io.pictures.request import Request, damaged

_ENDINGS = (".tga", ".icb", ".vda", ".vst")
_FOOTER = b"TRUEVISION-XFILE.\0"
# bits per pixel by type of picture: with a palette, colours, grey; 8 more is the same in run lengths
_BITS = {1: (8, 16), 2: (15, 16, 24, 32), 3: (8, 16)}


class _Header(NamedTuple):
    palette: int
    kind: int
    first: int
    entries: int
    entry_bits: int
    cols: int
    rows: int
    bits: int
    flags: int


def _header(head: bytes) -> _Header | None:
    """The header, if it can be that of a TGA."""
    if len(head) < 18:
        return None
    header = _Header(*struct.unpack("<xBBHHB4xHHBB", head[:18]))
    kind = header.kind & ~8
    if kind not in _BITS or header.kind > 11 or header.bits not in _BITS[kind] or not header.cols or not header.rows:
        return None
    if header.palette > 1 or (kind == 1) != (header.palette == 1 and header.entries > 0 and kind == 1):
        return None
    return header


def is_tga(path: Path, head: bytes) -> bool:
    """Whether the header is plausible, and the extension or the footer says that it is a TGA."""
    if _header(head) is None:
        return False
    if path.suffix.lower() in _ENDINGS:
        return True
    with path.open("rb") as stream:
        size = stream.seek(0, 2)
        stream.seek(max(0, size - len(_FOOTER)))
        return stream.read() == _FOOTER


def tga_facts(path: Path, request: Request) -> Facts:
    """Check the size in the header.

    Raises
    ------
    InputError, LimitError
    """
    with path.open("rb") as stream:
        header = _header(stream.read(18))
    if header is None:
        raise damaged(path, "TGA")
    request.check_size(path, header.cols, header.rows)
    kind = header.kind & ~8
    notes: tuple[str, ...] = ()
    if kind == 1:
        notes = (f"its colours are a palette of {header.entries}",)
    elif kind == 2 and header.bits < 24:
        notes = ("has only 5 bits per channel",)
    grey_alpha = ("Y", "A") if kind == 3 and header.bits == 16 else ()
    return Facts(
        notes=notes, coarse=bool(notes), channels=grey_alpha, spare_alpha=header.bits == 32 and not header.flags & 15
    )
