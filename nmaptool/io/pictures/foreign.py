"""Formats that are not read, recognised by their first bytes, each with the way to a format that is."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

_EXPORT = "export the map as PNG, EXR or TIFF"


@dataclass(frozen=True)
class ForeignFormat:
    """A format that is not read: what a file is, what to do, and how to recognise it."""

    what: str
    way: str
    magic: tuple[tuple[int, bytes], ...] = ()
    endings: tuple[str, ...] = ()

    def fits(self, path: Path, head: bytes) -> bool:
        """Whether a file with these first bytes is of this format; of extensions alone, only TIFF files are judged."""
        if any(head[at:].startswith(magic) for at, magic in self.magic):
            return True
        return path.suffix.lower() in self.endings and head.startswith((b"II*\0", b"MM\0*"))


def _at(offset: int, *magic: bytes) -> tuple[tuple[int, bytes], ...]:
    return tuple((offset, one) for one in magic)


FOREIGN_FORMATS = (
    ForeignFormat("is a GIF, which holds at most 256 colours", _EXPORT, _at(0, b"GIF8")),
    ForeignFormat("is an AVIF picture, which is lossy", _EXPORT, _at(4, b"ftypavif", b"ftypavis")),
    ForeignFormat("is a JPEG XL picture", _EXPORT, _at(0, b"\xff\x0a", b"\0\0\0\x0cJXL ")),
    ForeignFormat("is a JPEG 2000 picture", _EXPORT, _at(0, b"\0\0\0\x0cjP  ", b"\xff\x4f\xff\x51")),
    ForeignFormat(
        "is a KTX texture",
        "unpack it with ktx extract, or convert it to DDS or PNG",
        _at(0, b"\xabKTX 11", b"\xabKTX 20"),
    ),
    ForeignFormat("is a layered file", "read its layers with nmap compose unpack", _at(0, b"8BPS")),
    ForeignFormat("is an OpenRaster file", "read its layers with nmap compose unpack", _at(38, b"image/openraster")),
    ForeignFormat("is a GIMP file", "export it as PNG or TIFF, or as PSD for nmap compose unpack", _at(0, b"gimp xcf")),
    ForeignFormat(
        "is a Krita file", "export it as PNG or EXR, or as PSD for nmap compose unpack", _at(38, b"application/x-krita")
    ),
    ForeignFormat(
        "is a camera raw file",
        "develop it to a 16-bit TIFF first",
        (*_at(0, b"FUJIFILMCCD-RAW", b"IIRO", b"IIRS", b"MMOR", b"IIU\0"), *_at(8, b"CR\x02"), *_at(4, b"ftypcrx")),
        (".dng", ".nef", ".nrw", ".arw", ".sr2", ".pef", ".srw", ".cr2", ".raw", ".rw2", ".orf"),
    ),
    ForeignFormat(
        "is a video", "export one frame as PNG or TIFF", _at(4, b"ftypisom", b"ftypmp4", b"ftypqt", b"ftypM4V")
    ),
    ForeignFormat("is a PDF or PostScript document", "render it as PNG", _at(0, b"%PDF", b"%!PS", b"\xc5\xd0\xd3\xc6")),
    ForeignFormat(
        "is a text of numbers (PGM or PPM, plain)",
        "save it in binary form, or as PNG",
        _at(0, b"P1\n", b"P2\n", b"P3\n"),
    ),
    ForeignFormat("is a FITS file", "save its array with numpy.save as .npy", _at(0, b"SIMPLE  =")),
    ForeignFormat(
        "is an HDF5 or MATLAB file", "save its array with numpy.save as .npy", _at(0, b"\x89HDF", b"MATLAB 5.0 MAT")
    ),
    ForeignFormat(
        "is a Python pickle", "save its array with numpy.save as .npy", _at(0, *(b"\x80%c" % n for n in (2, 3, 4, 5)))
    ),
    ForeignFormat("is a mesh", "render its maps first with nmap bake", _at(0, b"glTF", b"ply\n", b"ply\r")),
)


def way_of(path: Path, head: bytes) -> str | None:
    """Return what a file of a foreign format is and the way to a readable one, or None."""
    if _is_svg(head):
        return "is an SVG drawing; render it as PNG in the size that you need"
    found = next((one for one in FOREIGN_FORMATS if one.fits(path, head)), None)
    return None if found is None else f"{found.what}; {found.way}"


def zip_way(path: Path) -> str:
    """What a ZIP archive is that holds no arrays, and the way to a picture."""
    if path.suffix.lower() in (".3mf", ".usdz"):
        return "is a mesh; render its maps first with nmap bake"
    return "is a ZIP archive; unpack it and give the picture in it"


def _is_svg(head: bytes) -> bool:
    text = head.removeprefix(b"\xef\xbb\xbf").lstrip()
    return text.startswith(b"<svg") or (text.startswith((b"<?xml", b"<!DOCTYPE svg")) and b"<svg" in text)
