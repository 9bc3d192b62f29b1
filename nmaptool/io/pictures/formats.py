"""The picture formats that are read, told by their first bytes."""

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
        In messages.
    endings : tuple of str
        The usual one first.
    magic : tuple of bytes
        What its files begin with.
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
# text, too, may begin with fewer bytes than these
_TELLING_BYTES = 3


def format_names() -> str:
    """The formats as a sentence lists them: ``PNG, EXR, TIFF, JPEG or BMP``."""
    return listed(one.name for one in READ_FORMATS)


def is_picture(head: bytes) -> bool:
    """Whether a file's first bytes are those of a picture that is read here."""
    return any(head.startswith(magic) for one in READ_FORMATS for magic in one.magic if len(magic) >= _TELLING_BYTES)


def find_format(path: Path) -> PictureFormat:
    """The format that the file's first bytes tell.

    Raises
    ------
    InputError
        If the file is missing, a folder, empty, none of the formats read here, or has another format's ending.
    """
    head, _ = read_head(path, 8, "a picture file", "read a stream with -")
    for one in READ_FORMATS:
        if head.startswith(one.magic):
            if path.suffix and path.suffix.lower() not in one.endings:
                right = path.with_suffix(one.endings[0]).name
                raise InputError(f"{path}: holds {one.name} data but is not named so; rename it to {right}")
            return one
    raise InputError(f"{path}: is not a picture that can be read here; accepted are {format_names()}")
