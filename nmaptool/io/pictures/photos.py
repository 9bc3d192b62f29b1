"""Checks of JPEG, WebP and Radiance HDR files before they are decoded."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

from nmaptool.core.errors import InputError
from nmaptool.io.pictures.facts import Facts
from nmaptool.io.pictures.request import Request, damaged

# markers of a JPEG's frame header: every way of coding except the tables at C4, C8 and CC
_FRAMES = {0xC0 + n for n in range(16)} - {0xC4, 0xC8, 0xCC}
_SCAN = 0xDA
_SIZE = re.compile(rb"^[+-]([XY]) (\d{1,9}) [+-]([XY]) (\d{1,9})$")
_MOST_HEADER = 65536


def jpeg_facts(path: Path, request: Request) -> Facts:
    """Refuse a JPEG without its end mark, because the decoder would silently fill the missing part with grey.

    Raises
    ------
    InputError
    """
    data = path.read_bytes()
    components, scan = _frame_and_scan(data)
    if data.find(b"\xff\xd9", scan) < 0:
        raise damaged(path, "JPEG")
    if components == 4:
        return replace(ink_facts(request), lossy=True)
    return Facts(lossy=True)


def ink_facts(request: Request) -> Facts:
    """The facts of a picture in printing inks, which is read only as depth."""
    if request.holds == "normals":
        return Facts(refusal="stores CMYK inks, which bends the vectors of a normal map; export it as RGB")
    return Facts(notes=("stores CMYK inks, converted to RGB",), coarse=True)


def _frame_and_scan(data: bytes) -> tuple[int, int]:
    """The number of components that the frame header of a JPEG declares, 0 if none, and where its data begin.

    An end mark may stand before that, in a thumbnail; what follows the picture, such as a video, may hold any marks.
    """
    place, components = 2, 0
    while place + 9 < len(data) and data[place] == 0xFF:
        marker = data[place + 1]
        if marker == _SCAN:
            break
        if marker in _FRAMES and not components:
            components = data[place + 9]
        if marker == 0xFF or 0xD0 <= marker <= 0xD8 or marker == 0x01:
            place += 1 if marker == 0xFF else 2
        else:
            place += 2 + int.from_bytes(data[place + 2 : place + 4], "big")
    return components, place


def webp_facts(path: Path, request: Request) -> Facts:
    """Walk the chunks of a WebP: whether it is complete, lossy, or an animation.

    Raises
    ------
    InputError, LimitError
    """
    data = path.read_bytes()
    if len(data) < 20 or len(data) < 8 + int.from_bytes(data[4:8], "little"):
        raise damaged(path, "WebP")
    place, kinds = 12, []
    while place + 8 <= len(data):
        kind, size = data[place : place + 4], int.from_bytes(data[place + 4 : place + 8], "little")
        kinds.append(kind)
        body = data[place + 8 : place + 18]
        if kind == b"VP8X" and len(body) == 10:
            cols, rows = (int.from_bytes(body[at : at + 3], "little") + 1 for at in (4, 7))
            request.check_size(path, cols, rows)
        place += 8 + size + size % 2
    if b"ANIM" in kinds or b"ANMF" in kinds:
        raise InputError(f"{path}: is an animation; export one frame as PNG")
    lossy = b"VP8 " in kinds
    return Facts(lossy=lossy)


def hdr_facts(path: Path, request: Request) -> Facts:
    """Check the size in the header of a Radiance picture.

    Raises
    ------
    InputError, LimitError
    """
    with path.open("rb") as stream:
        lines = stream.read(_MOST_HEADER).split(b"\n")
    size = next((found for line in lines if (found := _SIZE.match(line.rstrip(b"\r")))), None)
    if size is None or size[1] == size[3]:
        raise damaged(path, "HDR")
    request.check_size(path, int(size[4]), int(size[2]))
    if any(line.strip() == b"FORMAT=32-bit_rle_xyze" for line in lines):
        raise InputError(f"{path}: stores XYZ colours; save it as RGB, or as EXR")
    return Facts(notes=("stores numbers with 8 significant bits and a shared exponent",), coarse=True)
