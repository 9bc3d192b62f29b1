"""The table of picture formats that are read, identified by their first bytes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, cast

from nmaptool.core.errors import InputError
from nmaptool.core.text import listed
from nmaptool.io.opening import read_head
from nmaptool.io.pictures.foreign import way_of
from nmaptool.io.pictures.truevision import is_tga

_HEAD_BYTES = 4096


@dataclass(frozen=True)
class PictureFormat:
    """A format of picture files.

    Attributes
    ----------
    name : str
        Name for messages.
    endings : tuple of str
        File extensions, the usual one first.
    magic : tuple of (int, bytes)
        The bytes that identify it, each with its offset; one of them is enough.
    reader : str
        ``module:function`` in `nmaptool.io.pictures`, loaded on first use: ``function(path, request)`` returns a
        `nmaptool.RasterImage`.
    check : str
        For formats that OpenImageIO reads: ``module:function``, see `nmaptool.io.pictures.facts.Facts`.
    advised : bool
        Whether messages recommend it for exporting maps.
    recognise : callable, optional
        ``recognise(path, head)`` for a format without identifying bytes at its start.
    """

    name: str
    endings: tuple[str, ...]
    magic: tuple[tuple[int, bytes], ...]
    reader: str = "through_oiio:read_checked"
    check: str = ""
    advised: bool = False
    recognise: Callable[[Path, bytes], bool] | None = None

    def begins(self, head: bytes) -> bool:
        """Whether a file with these first bytes is of this format."""
        return any(head[at:].startswith(magic) for at, magic in self.magic)

    def function(self, text: str) -> Callable[..., Any]:
        """The function that ``reader`` or ``check`` names."""
        module, _, name = text.partition(":")
        return cast("Callable[..., Any]", getattr(import_module(f"nmaptool.io.pictures.{module}"), name))


def _first(*magic: bytes) -> tuple[tuple[int, bytes], ...]:
    return tuple((0, one) for one in magic)


_HEIF_BRANDS = (b"heic", b"heix", b"heim", b"heis", b"hevc", b"hevx", b"mif1", b"msf1")

PNG = PictureFormat("PNG", (".png",), _first(b"\x89PNG"), check="png:png_facts", advised=True)
EXR = PictureFormat("EXR", (".exr",), _first(b"\x76\x2f\x31\x01"), advised=True)
TIFF = PictureFormat(
    "TIFF",
    (".tif", ".tiff"),
    _first(b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"),
    reader="tiff:read_tiff",
    check="tiff:tiff_facts",
    advised=True,
)
JPEG = PictureFormat("JPEG", (".jpg", ".jpeg", ".jpe", ".jfif"), _first(b"\xff\xd8\xff"), check="photos:jpeg_facts")
BMP = PictureFormat("BMP", (".bmp", ".dib"), _first(b"BM"), reader="bmp:read_bmp")
WEBP = PictureFormat("WebP", (".webp",), ((8, b"WEBP"),), check="photos:webp_facts")
TGA = PictureFormat("TGA", (".tga", ".icb", ".vda", ".vst"), (), check="truevision:tga_facts", recognise=is_tga)
DDS = PictureFormat("DDS", (".dds",), _first(b"DDS "), reader="dds:read_dds", check="dds:dds_facts")
HDR = PictureFormat("HDR", (".hdr", ".rgbe", ".pic"), _first(b"#?RADIANCE", b"#?RGBE"), check="photos:hdr_facts")
PFM = PictureFormat("PFM", (".pfm",), _first(b"PF\n", b"PF\r", b"PF ", b"Pf\n", b"Pf\r", b"Pf "), "netpbm:read_pfm")
PNM = PictureFormat(
    "PGM/PPM",
    (".pgm", ".ppm", ".pnm"),
    _first(*(b"P%d%c" % (n, c) for n in (5, 6) for c in b"\n\r ")),
    "netpbm:read_pnm",
)
NPY = PictureFormat("NumPy .npy", (".npy",), _first(b"\x93NUMPY"), reader="arrays:read_npy")
NPZ = PictureFormat("NumPy .npz", (".npz",), _first(b"PK\x03\x04"), reader="arrays:read_npz")
HEIC = PictureFormat(
    "HEIC", (".heic", ".heif", ".hif"), tuple((4, b"ftyp" + b) for b in _HEIF_BRANDS), "heic:read_heic"
)
READ_FORMATS = (PNG, EXR, TIFF, JPEG, BMP, WEBP, TGA, DDS, HDR, PFM, PNM, NPY, NPZ, HEIC)
# shorter identifying bytes could also begin a text
_TELLING_BYTES = 3


def format_names() -> str:
    """Return the names of the formats for a sentence: ``PNG, EXR, ... or HEIC``."""
    return listed(one.name for one in READ_FORMATS)


def is_picture(head: bytes) -> bool:
    """Whether the first bytes of a file are those of a supported picture format."""
    return any(one.begins(head) and all(len(m) >= _TELLING_BYTES for _, m in one.magic) for one in READ_FORMATS)


def find_format(path: Path) -> PictureFormat:
    """Identify the format of a file by its first bytes; TGA has none and needs its extension or its footer.

    Raises
    ------
    InputError
        If the file is missing or empty, is a folder, is not in a supported format, or has the extension of another
        format.
    """
    head, _ = read_head(path, _HEAD_BYTES, "a picture file", "read a stream with -")
    way = way_of(path, head)
    if way is not None:
        raise InputError(f"{path}: {way}")
    for one in READ_FORMATS:
        if one.begins(head) or (one.recognise is not None and one.recognise(path, head)):
            if path.suffix and path.suffix.lower() not in one.endings:
                right = path.with_suffix(one.endings[0]).name
                raise InputError(f"{path}: holds {one.name} data; rename it to {right}")
            return one
    advised = listed(one.name for one in READ_FORMATS if one.advised)
    raise InputError(f"{path}: is not a picture in a supported format; export it as {advised}")
