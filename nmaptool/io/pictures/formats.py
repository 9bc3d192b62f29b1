"""The table of picture formats that are read, identified by their first bytes."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, cast

from nmaptool.core.errors import InputError
from nmaptool.core.text import listed
from nmaptool.io.opening import read_head
from nmaptool.io.pictures.foreign import way_of, zip_way
from nmaptool.io.pictures.truevision import is_tga

_HEAD_BYTES = 4096


@dataclass(frozen=True)
class PictureFormat:
    """A format of picture files.

    Attributes
    ----------
    name : str
        Name for messages.
    description : str
        What is read, for the README.
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
    description: str
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


def _is_pfm(_: Path, head: bytes) -> bool:
    """A header on one line; "PF" and a blank alone could also begin a text."""
    return re.match(rb"P[Ff] \d+ \d+\s", head) is not None


def _is_pnm(_: Path, head: bytes) -> bool:
    return re.match(rb"P[56] \d+ \d+\s", head) is not None


_ZIP = b"PK\x03\x04"
_ZIP_NAME = 30  # place of the first member's name


def _is_npz(path: Path, head: bytes) -> bool:
    """A ZIP archive whose first member is an array, or that is called .npz."""
    name = head[_ZIP_NAME : _ZIP_NAME + int.from_bytes(head[26:28], "little")]
    return head.startswith(_ZIP) and (path.suffix.lower() == ".npz" or name.endswith(b".npy"))


_HEIF_BRANDS = (b"heic", b"heix", b"heim", b"heis", b"hevc", b"hevx", b"mif1", b"msf1")

PNG = PictureFormat(
    "PNG", "8 and 16 bits, palettes", (".png",), _first(b"\x89PNG"), check="png:png_facts", advised=True
)
EXR = PictureFormat(
    "EXR",
    "float, half, integers; layers such as `R,G,B`, `N.X,N.Y,N.Z`, `Nx,Ny,Nz`, `ViewLayer.Depth.Z`, and parts: "
    "`maps.exr:detail`",
    (".exr",),
    _first(b"\x76\x2f\x31\x01"),
    advised=True,
)
TIFF = PictureFormat(
    "TIFF",
    "integers and floats of any size, tiles, palettes, `GDAL_NODATA`; pages: `map.tif:page 2`; ZSTD, LERC and JPEG "
    "2000 need the codecs extra",
    (".tif", ".tiff"),
    _first(b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"),
    reader="tiff:read_tiff",
    check="tiff:tiff_facts",
    advised=True,
)
JPEG = PictureFormat(
    "JPEG", "8 bits, lossy", (".jpg", ".jpeg", ".jpe", ".jfif"), _first(b"\xff\xd8\xff"), check="photos:jpeg_facts"
)
BMP = PictureFormat(
    "BMP", "any header, channel masks, palettes, run lengths", (".bmp", ".dib"), _first(b"BM"), reader="bmp:read_bmp"
)
WEBP = PictureFormat("WebP", "8 bits, lossless or lossy", (".webp",), ((8, b"WEBP"),), check="photos:webp_facts")
TGA = PictureFormat(
    "TGA",
    "8 bits, palettes, run lengths, any corner first",
    (".tga", ".icb", ".vda", ".vst"),
    (),
    check="truevision:tga_facts",
    recognise=is_tga,
)
DDS = PictureFormat(
    "DDS",
    "BC1 to BC7 (BC5 holds x and y), 8 and 16 bits, half, float",
    (".dds",),
    _first(b"DDS "),
    reader="dds:read_dds",
    check="dds:dds_facts",
)
HDR = PictureFormat(
    "HDR",
    "Radiance: numbers with 8 significant bits, for depth",
    (".hdr", ".rgbe", ".pic"),
    _first(b"#?RADIANCE", b"#?RGBE"),
    check="photos:hdr_facts",
)
PFM = PictureFormat(
    "PFM", "float", (".pfm",), _first(b"PF\n", b"PF\r", b"Pf\n", b"Pf\r"), "netpbm:read_pfm", recognise=_is_pfm
)
PNM = PictureFormat(
    "PGM/PPM",
    "binary, 8 and 16 bits",
    (".pgm", ".ppm", ".pnm"),
    _first(b"P5\n", b"P5\r", b"P6\n", b"P6\r"),
    "netpbm:read_pnm",
    recognise=_is_pnm,
)
NPY = PictureFormat(
    "NumPy .npy",
    "(rows, columns), with channels last or first; floats, integers, bool masks; no pickles",
    (".npy",),
    _first(b"\x93NUMPY"),
    reader="arrays:read_npy",
)
NPZ = PictureFormat(
    "NumPy .npz",
    "the same, several arrays: `out.npz:normal`",
    (".npz",),
    (),
    "arrays:read_npz",
    recognise=_is_npz,
)
HEIC = PictureFormat(
    "HEIC",
    "photos, and the depth image of portrait mode: `photo.heic:depth`; needs the heic extra",
    (".heic", ".heif", ".hif"),
    tuple((4, b"ftyp" + brand) for brand in _HEIF_BRANDS),
    reader="heic:read_heic",
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
    if head.startswith(_ZIP):
        raise InputError(f"{path}: {zip_way(path)}")
    advised = listed(one.name for one in READ_FORMATS if one.advised)
    raise InputError(f"{path}: is not a picture in a supported format; export it as {advised}")
