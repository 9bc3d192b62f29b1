"""Read TIFF files: OpenImageIO decodes the usual ones, tifffile the numbers and packings that it does not know."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import tifffile

from nmaptool.core.errors import InputError
from nmaptool.io.pictures.facts import Facts
from nmaptool.io.pictures.layer_names import page_name
from nmaptool.io.pictures.photos import ink_facts
from nmaptool.io.pictures.request import Request, damaged
from nmaptool.io.pictures.through_oiio import read_checked
from nmaptool.io.pictures.tiff_pages import decoded, tiff_damage_named
from nmaptool.types.picture import RasterImage
from nmaptool.types.shown import counted

_NODATA, _PIXEL_SCALE, _GEO_KEYS, _PAGE_NAME = 42113, 33550, 34735, 285
_WHITE_IS_ZERO, _PALETTE, _INKS, _YCBCR, _LAB = 0, 3, 5, 6, (8, 9, 10)
_MASK_PAGE, _MOST_PAGES, _MOST_CHANNELS = 4, 10_000, 64
# packings that every libtiff decodes: none, CCITT, LZW, JPEG, Deflate, PackBits
_COMMON = {1, 2, 3, 4, 5, 6, 7, 8, 32946, 32773}
_LOSSY = {
    6: "JPEG",
    7: "JPEG",
    33003: "JPEG 2000",
    33005: "JPEG 2000",
    34712: "JPEG 2000",
    34892: "JPEG",
    34887: "LERC",
    34927: "WebP",
    50001: "WebP",
    50002: "JPEG XL",
}
_UNSIGNED, _SIGNED, _FLOAT, _COMPLEX = 1, 2, 3, (5, 6)
_MODEL_TYPE, _LINEAR_UNIT, _PROJECTED, _METRE = 1024, 3076, 1, 9001


@dataclass(frozen=True)
class _Page:
    """What the tags of a page say."""

    cols: int
    rows: int
    bits: int
    samples: int
    sample_format: int
    packing: int
    colors: int
    nodata: float | None
    metres_per_px: float | None
    reduced: bool
    tiled: bool
    name: str

    @property
    def through_oiio(self) -> bool:
        """Whether OpenImageIO decodes its numbers as stored."""
        # OpenImageIO 3.2 gets the numbers of doubles in tiles wrong
        doubles = self.bits == 64 and self.sample_format == _FLOAT and not self.tiled
        odd = self.bits in (24, 64) and not doubles
        return self.packing in _COMMON and not odd


def _pages(path: Path) -> list[_Page]:
    with tiff_damage_named(path), tifffile.TiffFile(path) as tiff:
        pages = itertools.islice(tiff.pages, _MOST_PAGES)
        found = [_page(page if isinstance(page, tifffile.TiffPage) else page.aspage()) for page in pages]
    if not found:
        raise damaged(path, "TIFF")
    return found


def _page(page: tifffile.TiffPage) -> _Page:
    tags = page.tags
    bits = tags.valueof(258, 1)
    kind = tags.valueof(339, 1)
    size = (page.imagewidth, page.imagelength, page.samplesperpixel)
    if not all(isinstance(number, int | np.integer) and number > 0 for number in size):
        raise ValueError("the size is not a number")
    return _Page(
        cols=int(size[0]),
        rows=int(size[1]),
        bits=int(max(bits) if isinstance(bits, tuple) else bits),
        samples=int(size[2]),
        sample_format=int(kind[0] if isinstance(kind, tuple) else kind),
        packing=int(tags.valueof(259, 1)),
        colors=int(tags.valueof(262, 1)),
        nodata=_nodata(tags.valueof(_NODATA, None)),
        metres_per_px=_metres(tags.valueof(_PIXEL_SCALE, None), tags.valueof(_GEO_KEYS, None)),
        reduced=bool(int(tags.valueof(254, 0)) & (1 | _MASK_PAGE)),
        tiled=bool(page.is_tiled),
        name=_text(tags.valueof(_PAGE_NAME, "")) or page_name(page.index),
    )


def _nodata(value: object) -> float | None:
    """The value that means "no data", as the nearest float32, because pixels are compared with it."""
    try:
        with np.errstate(over="ignore"):
            return float(np.float32(float(_text(value))))
    except ValueError:
        return None


def _text(value: object) -> str:
    text = value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
    return text.partition("\0")[0].strip()


def _metres(scale: Any, keys: Any) -> float | None:
    """Metres per pixel of a projected elevation model with square pixels."""
    if not isinstance(scale, tuple) or not isinstance(keys, tuple) or len(scale) < 2:
        return None
    known = {keys[at]: keys[at + 3] for at in range(4, len(keys) - 3, 4)}
    across, down = (float(size) for size in scale[:2])
    square = across > 0 and math.isfinite(across) and abs(across - down) <= 1e-6 * across
    in_metres = known.get(_MODEL_TYPE) == _PROJECTED and known.get(_LINEAR_UNIT, _METRE) == _METRE
    return across if square and in_metres else None


def tiff_facts(path: Path, request: Request) -> Facts:
    """What the tags of a TIFF say about the numbers and colours of its pages.

    Raises
    ------
    InputError, LimitError
    """
    return _facts(path, request, _pages(path))


def _facts(path: Path, request: Request, pages: list[_Page]) -> Facts:
    for page in pages:
        request.check_size(path, page.cols, page.rows)
    parts = tuple(_page_facts(page, request) for page in pages)
    if len(pages) == 1:
        return parts[0]
    count = sum(not page.reduced for page in pages)
    return replace(parts[0], parts=parts, pages=count, names=tuple(page.name for page in pages))


def _page_facts(page: _Page, request: Request) -> Facts:
    refusal = _refusal(page)
    if refusal:
        return Facts(refusal=refusal)
    inks = ink_facts(request) if page.colors == _INKS else Facts()
    notes = list(inks.notes)
    if page.colors == _PALETTE:
        notes.append(f"its colours are a palette of {2**page.bits}")
    elif page.bits < 8:
        notes.append(f"has only {counted(page.bits, 'bit')} per channel")
    elif page.bits in (10, 12, 14):
        notes.append(f"has {page.bits} bits per channel, widened to 16")
    inverted = page.colors == _WHITE_IS_ZERO and page.sample_format == _UNSIGNED
    if inverted:
        notes.append("states that 0 is white: shown, and read, as the negative of its numbers")
    if page.packing in _LOSSY:
        notes.append(f"is packed as {_LOSSY[page.packing]}, which may change its numbers")
    elif page.colors == _YCBCR:
        notes.append("stores luminance and chroma, converted to RGB")
    return Facts(
        lossy=page.packing in _LOSSY or page.colors == _YCBCR,
        nodata=page.nodata,
        notes=tuple(notes),
        coarse=page.colors in (_PALETTE, _INKS) or page.bits < 8,
        attributes={} if page.metres_per_px is None else {"metres_per_px": repr(page.metres_per_px)},
        white_is_zero=inverted,
        refusal=inks.refusal,
    )


def _refusal(page: _Page) -> str:
    """Why the numbers of a page are not read; empty if they are."""
    if page.samples > _MOST_CHANNELS:
        return f"has {page.samples} channels; a picture has 1 to 4"
    if page.colors in _LAB:
        return "stores CIELAB colours; export it as RGB"
    if page.sample_format in _COMPLEX:
        return "stores complex numbers; save their real part or their magnitude"
    return ""


def is_common_tiff(path: Path) -> bool:
    """Whether OpenImageIO decodes all pages of a TIFF.

    Raises
    ------
    InputError
    """
    return all(page.through_oiio for page in _pages(path))


def read_tiff(path: Path, request: Request) -> RasterImage:
    """Read a page of a TIFF.

    Raises
    ------
    InputError, LimitError
    """
    pages = _pages(path)
    if all(page.through_oiio for page in pages):
        return read_checked(path, request)
    return decoded(path, request, _facts(path, request, pages))


def refuse_unusual(path: Path) -> None:
    """Refuse a TIFF with pages that OpenImageIO does not decode.

    Raises
    ------
    InputError
    """
    for page in _pages(path):
        if page.packing not in _COMMON:
            packing = tifffile.COMPRESSION(page.packing).name
            raise InputError(f"{path}: its {page.name} is packed as {packing}; save it with LZW or Deflate")
        if not page.through_oiio:
            raise InputError(f"{path}: its {page.name} has {page.bits} bits per channel; save it with 8, 16 or 32 bits")
