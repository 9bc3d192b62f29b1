"""Decode the pages of TIFF files whose numbers or packing OpenImageIO does not know, with tifffile."""

from __future__ import annotations

import contextlib
import logging
import lzma
import struct
import warnings
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import tifffile
from numpy.typing import NDArray

from nmaptool.core.errors import InputError, LimitError
from nmaptool.io.pictures.facts import Facts
from nmaptool.io.pictures.layer_names import matching, page_name, pages_note
from nmaptool.io.pictures.metadata import depth_facts, own_lines
from nmaptool.io.pictures.request import Request, damaged
from nmaptool.io.pictures.sample_types import as_pixels
from nmaptool.types.picture import RasterImage

_DAMAGE = (
    *(tifffile.TiffFileError, ValueError, OSError, EOFError, KeyError, IndexError, TypeError, AttributeError),
    *(struct.error, ArithmeticError, UnicodeError, AssertionError, UserWarning),
    # of imagecodecs, and of Python's own unpackers without it
    *(RuntimeError, zlib.error, lzma.LZMAError),
)
_COLORS = {0: ("Y",), 1: ("Y",), 2: ("R", "G"), 3: ("R", "G", "B")}
_ORIENTATION, _RGB, _PALETTE, _ALPHA, _WHOLE = 274, 2, 3, (1, 2), 16
# colours that must be converted, and the packings after which tifffile gives RGB
_CONVERTED = {5: "CMYK inks", 6: "luminance and chroma"}
_CONVERTING = (6, 7, 33003, 33005, 34712, 34892, 34927, 50001, 50002)


@contextlib.contextmanager
def tiff_damage_named(path: Path) -> Iterator[None]:
    """Turn any error of tifffile about a damaged file into one clear line; its own messages are not shown.

    Raises
    ------
    InputError, LimitError
    """
    logger = logging.getLogger("tifffile")
    before = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except (InputError, LimitError):
        raise
    except _DAMAGE:
        raise damaged(path, "TIFF") from None
    except MemoryError:
        raise LimitError(f"{path}: does not fit in memory; make it smaller") from None
    finally:
        logger.setLevel(before)


def decoded(path: Path, request: Request, facts: Facts) -> RasterImage:
    """Read a page with tifffile, and imagecodecs for packings such as ZSTD and LERC.

    Raises
    ------
    InputError
        Also if imagecodecs is needed and not installed.
    LimitError
    """
    number = page_number(path, request, facts)
    with tiff_damage_named(path):
        page = _page(path, number, 0)
        # tifffile fills what is missing; what differs between two fillings is missing
        if not np.array_equal(page.values, _page(path, number, 1).values, equal_nan=page.values.dtype.kind in "fc"):
            raise damaged(path, "TIFF")
    return picture_of_page(path, request, facts, page)


def picture_of_page(path: Path, request: Request, facts: Facts, page: Page) -> RasterImage:
    """Make a picture of a decoded page, or of a window of it.

    Raises
    ------
    InputError
        If its values are not numbers.
    """
    own = facts.of_part(page.number)
    values, channels = _named(page)
    if own.white_is_zero:
        values = np.iinfo(values.dtype).max - values
    pixels = as_pixels(str(path), values)
    attributes = {**own_lines(page.description), **own.attributes}
    more = pages_note(path.name, facts.pages, facts.names) if request.layer is None else ()
    return RasterImage(
        pixels=np.ascontiguousarray(pixels.values),
        channels=channels,
        name=str(path) if request.layer is None else f"{path}:{request.layer}",
        bits=pixels.bits,
        lossy=own.lossy,
        attributes=attributes,
        color_chunks=("ICC profile",) if page.profile else (),
        layer=request.layer,
        depth_facts=depth_facts(attributes),
        nodata=own.nodata,
        orientation=page.orientation,
        notes=(*own.notes, *more, *pixels.notes),
        coarse=own.coarse,
    )


def page_number(path: Path, request: Request, facts: Facts) -> int:
    """The number of the page that is wanted.

    Raises
    ------
    InputError
        If there is no such page, or its numbers are not read.
    """
    number = 0
    if request.layer is not None:
        names = facts.names or (page_name(0),)
        found = matching(request.layer, [[name, page_name(number)] for number, name in enumerate(names)])
        if not found:
            raise InputError(f"{path}: has no layer {request.layer!r}; it holds: {', '.join(names)}")
        number = found[0]
    refusal = facts.of_part(number).refusal
    if refusal:
        raise InputError(f"{path}: {refusal}")
    return number


class Page(NamedTuple):
    """A decoded page.

    Attributes
    ----------
    values : (H, W, C)
        Its numbers, with colours in place of places in a palette, and codes of few bits widened.
    alpha : int or None
        Position of the channel that the file calls alpha.
    colored : bool
        Whether the first three channels are red, green and blue by the file's own words.
    description : str
    profile : bool
        Whether it has an ICC profile.
    orientation : int
    number : int
    """

    values: NDArray[Any]
    alpha: int | None
    colored: bool
    description: str
    profile: bool
    orientation: int
    number: int


def _page(path: Path, number: int, filling: int) -> Page:
    with tifffile.TiffFile(path) as tiff:
        page = usable_page(path, tiff, number)
        page.nodata = filling
        with codecs_named(path, page):
            values: NDArray[Any] = page.asarray()
        planes, _, rows, cols, count = page.shaped
        return page_of(page, number, values.reshape(planes, rows, cols, count))


def usable_page(path: Path, tiff: tifffile.TiffFile, number: int) -> tifffile.TiffPage:
    """A page of an open TIFF.

    Raises
    ------
    InputError
        If its colours cannot be converted, or it holds a volume.
    """
    page = tiff.pages[number]
    page = page if isinstance(page, tifffile.TiffPage) else page.aspage()
    if page.photometric in _CONVERTED and page.compression not in _CONVERTING:
        words = f"{_CONVERTED[page.photometric]} packed as {page.compression.name}"
        raise InputError(f"{path}: stores {words}; save it as RGB or grey with LZW or Deflate")
    if page.shaped[1] != 1:
        raise InputError(f"{path}: holds a volume; save one slice of it")
    return page


@contextlib.contextmanager
def codecs_named(path: Path, page: tifffile.TiffPage) -> Iterator[None]:
    """Turn the errors about a missing imagecodecs into a clear line.

    Raises
    ------
    InputError
    """
    try:
        yield
    except (ValueError, ImportError) as error:  # DelayedImportError is an ImportError
        if "imagecodecs" in str(error) or isinstance(error, ImportError):
            raise InputError(
                f"{path}: is packed as {page.compression.name}; save it with LZW or Deflate, or install the "
                'reader: pip install "nmaptool-relief[codecs]"'
            ) from None
        raise


def page_of(page: tifffile.TiffPage, number: int, values: NDArray[Any]) -> Page:
    """A page with its (planes, h, w, samples) values, or those of a window of it."""
    extra, depth = tuple(page.extrasamples), page.bitspersample
    palette, orientation = page.colormap, int(page.tags.valueof(_ORIENTATION, 1))
    description, profile = str(page.description), page.iccprofile is not None
    colored = page.photometric in (_RGB, *_CONVERTED)
    values = values[0] if len(values) == 1 else np.moveaxis(values[..., 0], 0, -1)
    if palette is not None and page.photometric == _PALETTE:
        values, colored = (palette >> 8).astype(np.uint8).T[values[..., 0]], True
    elif values.dtype.kind == "u" and depth < _WHOLE:
        values = _widened(values, depth)
    alpha = next((values.shape[2] - len(extra) + i for i, kind in enumerate(extra) if kind in _ALPHA), None)
    turned = orientation if 1 <= orientation <= 8 else 1
    return Page(values, alpha, colored, description, profile, turned, number)


def _widened(values: NDArray[Any], depth: int) -> NDArray[Any]:
    """Codes of less than 8 or 16 bits as codes of these."""
    full = 255 if depth <= 8 else 65535
    wide = np.rint(values.astype(np.float64) * (full / ((1 << depth) - 1)))
    return wide.astype(np.uint8 if full == 255 else np.uint16)


def _named(page: Page) -> tuple[NDArray[Any], tuple[str, ...]]:
    """The channels to use and their names, as OpenImageIO chooses them from other files."""
    colors = [channel for channel in range(page.values.shape[2]) if channel != page.alpha]
    if page.colored or len(colors) >= 3:
        colors = colors[:3]
    names = _COLORS[len(colors)]
    if page.alpha is not None and colors:
        colors, names = [*colors, page.alpha], (*names, "A")
    return page.values[..., colors or [0]], names
