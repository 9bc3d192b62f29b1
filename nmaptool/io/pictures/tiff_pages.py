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
from typing import Any

import numpy as np
import tifffile
from numpy.typing import NDArray

from nmaptool.core.errors import InputError, LimitError
from nmaptool.io.pictures.facts import Facts
from nmaptool.io.pictures.request import Request, damaged
from nmaptool.io.pictures.sample_types import as_pixels
from nmaptool.types.picture import RasterImage

_DAMAGE = (
    *(tifffile.TiffFileError, ValueError, OSError, EOFError, KeyError, IndexError, TypeError, AttributeError),
    *(struct.error, ArithmeticError, UnicodeError, AssertionError, UserWarning),
    # of imagecodecs, and of Python's own unpackers without it
    *(RuntimeError, zlib.error, lzma.LZMAError),
)
_CHANNELS = {1: ("Y",), 2: ("Y", "A"), 3: ("R", "G", "B"), 4: ("R", "G", "B", "A")}


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
    with tiff_damage_named(path):
        number = _page_number(path, request)
        values = _values(path, number, 0)
        # tifffile fills what is missing; what differs between two fillings is missing
        if not np.array_equal(values, _values(path, number, 1), equal_nan=values.dtype.kind in "fc"):
            raise damaged(path, "TIFF")
    if values.shape[2] not in _CHANNELS:
        raise InputError(f"{path}: has {values.shape[2]} channels; a picture has 1 to 4")
    if facts.white_is_zero:
        values = np.iinfo(values.dtype).max - values
    pixels = as_pixels(str(path), values)
    channels = _CHANNELS[values.shape[2]]
    return RasterImage(
        pixels=np.ascontiguousarray(pixels.values),
        channels=channels,
        name=str(path) if request.layer is None else f"{path}:{request.layer}",
        bits=pixels.bits,
        lossy=facts.lossy,
        attributes=facts.attributes,
        layer=request.layer,
        nodata=facts.nodata,
        notes=(*facts.notes, *pixels.notes),
        coarse=facts.coarse,
    )


def _page_number(path: Path, request: Request) -> int:
    if request.layer is None:
        return 0
    with tifffile.TiffFile(path) as tiff:
        names = [f"page {number + 1}" for number in range(len(tiff.pages))]
    if request.layer.lower() not in names:
        raise InputError(f"{path}: has no layer {request.layer!r}; it holds: {', '.join(names)}")
    return names.index(request.layer.lower())


def _values(path: Path, number: int, filling: int) -> NDArray[Any]:
    """(H, W, C): the numbers of a page."""
    with tifffile.TiffFile(path) as tiff:
        page = tiff.pages[number]
        page = page if isinstance(page, tifffile.TiffPage) else page.aspage()
        page.nodata = filling
        try:
            values: NDArray[Any] = page.asarray()
        except (ValueError, ImportError) as error:  # DelayedImportError is an ImportError
            if "imagecodecs" in str(error) or isinstance(error, ImportError):
                raise InputError(
                    f"{path}: is packed as {page.compression.name}; save it with LZW or Deflate, or install the "
                    'reader: pip install "nmaptool-relief[codecs]"'
                ) from None
            raise
        planes, slices, rows, cols, count = page.shaped
    if slices != 1:
        raise InputError(f"{path}: holds a volume; save one slice of it")
    values = values.reshape(planes, rows, cols, count)
    return values[0] if planes == 1 else np.moveaxis(values[..., 0], 0, -1)
