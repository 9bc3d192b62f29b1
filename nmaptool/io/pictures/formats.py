"""The supported picture formats, identified by their first bytes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from nmaptool.core.errors import InputError
from nmaptool.core.text import listed
from nmaptool.io.opening import read_head


@dataclass(frozen=True)
class PictureFormat:
    """A format of picture files.

    Attributes
    ----------
    name : str
        Name for messages.
    endings : tuple of str
        File extensions, the usual one first.
    magic : tuple of bytes
        The bytes with which a file may begin.
    """

    name: str
    endings: tuple[str, ...]
    magic: tuple[bytes, ...]


PNG = PictureFormat("PNG", (".png",), (b"\x89PNG",))
EXR = PictureFormat("EXR", (".exr",), (b"\x76\x2f\x31\x01",))
TIFF = PictureFormat("TIFF", (".tif", ".tiff"), (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"))
JPEG = PictureFormat("JPEG", (".jpg", ".jpeg"), (b"\xff\xd8\xff",))
BMP = PictureFormat("BMP", (".bmp",), (b"BM",))
READ_FORMATS = (PNG, EXR, TIFF, JPEG, BMP)
# shorter magic bytes could also begin a text
_TELLING_BYTES = 3


def format_names() -> str:
    """Return the names of the formats for a sentence: ``PNG, EXR, TIFF, JPEG or BMP``."""
    return listed(one.name for one in READ_FORMATS)


def is_picture(head: bytes) -> bool:
    """Whether the first bytes of a file are those of a supported picture format."""
    return any(head.startswith(magic) for one in READ_FORMATS for magic in one.magic if len(magic) >= _TELLING_BYTES)


def find_format(path: Path) -> PictureFormat:
    """Identify the format of a file by its first bytes.

    Raises
    ------
    InputError
        If the file is missing or empty, is a folder, is not in a supported format, or has the extension of another
        format.
    """
    head, _ = read_head(path, 8, "a picture file", "read a stream with -")
    for one in READ_FORMATS:
        if head.startswith(one.magic):
            if path.suffix and path.suffix.lower() not in one.endings:
                right = path.with_suffix(one.endings[0]).name
                raise InputError(f"{path}: holds {one.name} data; rename it to {right}")
            return one
    raise InputError(f"{path}: is not a picture in a supported format; export it as {format_names()}")
