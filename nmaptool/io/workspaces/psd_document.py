"""Open Photoshop documents with limits: check the header, parse the structures with psd-tools, report damage.

psd-tools' low-level structures (``psd_tools.psd``) are used here and in `nmaptool.io.workspaces.psd_reader` and
`nmaptool.io.workspaces.psd_writer`, but none of its private names: `layer_records` finds layers of 16 and 32 bits as
its ``PSD._get_layer_info`` does. tests/test_private_names.py shows which structure or parameter is gone after an
update.
"""

from __future__ import annotations

import contextlib
import logging
import struct
import warnings
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from psd_tools import ParseLimits
from psd_tools.constants import Compression, Tag
from psd_tools.psd import PSD
from psd_tools.psd.layer_and_mask import LayerRecord

from nmaptool.core.errors import InputError, LimitError
from nmaptool.io.pictures.size_limit import check_size

_MOST_OBJECTS = 2_000_000
_MODES = {0: "bitmap", 1: "grey", 2: "palette", 4: "CMYK", 7: "multichannel", 8: "duotone", 9: "Lab"}
_DAMAGE = (
    *(ValueError, OSError, EOFError, KeyError, IndexError, TypeError, AttributeError, AssertionError),
    *(struct.error, zlib.error, RecursionError, ArithmeticError, UserWarning, UnicodeError),
)


@contextlib.contextmanager
def explain_damage(path: Path) -> Iterator[None]:
    """Turn any error of psd-tools about a damaged file into one clear line; its own messages are not shown."""
    logger = logging.getLogger("psd_tools")
    before, logger.disabled = logger.level, False
    logger.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # a channel that cannot be decoded would be black, with a warning
            yield
    except (InputError, LimitError):
        raise
    except _DAMAGE:
        raise damaged(path) from None
    except MemoryError:
        raise LimitError(f"{path}: does not fit in memory; make it smaller") from None
    finally:
        logger.setLevel(before)


def damaged(path: Path) -> InputError:
    """The error for a truncated or damaged file."""
    return InputError(f"{path}: the PSD file is truncated or damaged; save or download it again")


def check_header(path: Path, max_megapixels: float) -> tuple[int, int, int]:
    """Return (rows, cols, depth) from the first 26 bytes of a document, or refuse it."""
    with path.open("rb") as stream:
        head = stream.read(26)
        size = stream.seek(0, 2)
    if len(head) < 26:
        raise damaged(path)
    version, channels, rows, cols, depth, mode = struct.unpack(">4xH6xHIIHH", head)
    if version not in (1, 2) or not 1 <= channels <= 56 or min(rows, cols) < 1:
        raise damaged(path)
    check_size(path, cols, rows, max_megapixels)
    if size > max_megapixels * 1e6 * 16 + 1e8:  # the size of all layers, uncompressed in 32 bits
        raise LimitError(f"{path}: is too large, {size / 1e9:.1f} GB; make it smaller or raise `max_megapixels`")
    if mode != 3:
        found = f"a {_MODES[mode]} picture" if mode in _MODES else "a picture of an unknown colour mode"
        raise InputError(f"{path}: is {found}; normal maps need RGB: convert it to 16-bit RGB")
    if depth not in (8, 16, 32):
        raise InputError(f"{path}: has a depth of {depth} per channel; use 8, 16 or 32 bits")
    return rows, cols, depth


def parse(path: Path) -> PSD:
    """Parse the structures of a document; false sizes in it cannot take much more memory than the file."""
    with path.open("rb") as stream:
        size = stream.seek(0, 2)
        stream.seek(0)
        limits = ParseLimits(max_total_bytes=16 * size + 1_000_000, max_objects=_MOST_OBJECTS)
        return PSD.read(stream, parse_limits=limits)


def layer_records(document: PSD) -> tuple[list[LayerRecord], list[Any]]:
    """Return the records of the layers and groups, bottom to top, and the channels of each.

    Photoshop keeps layers of 16 and 32 bits in a separate block, which takes precedence if it exists.
    """
    information = document.layer_and_mask_information
    blocks, info = information.tagged_blocks, information.layer_info
    if blocks is not None:
        deep = next((tag for tag in (Tag.LAYER_16, Tag.LAYER_32) if tag in blocks), None)
        info = info if deep is None else blocks.get_data(deep)
    if info is None:
        return [], []
    return list(info.layer_records or ()), list(info.channel_image_data or ())


def check_end(path: Path, document: PSD, header: tuple[int, int, int]) -> None:
    """Refuse a file whose merged picture, its last section, is incomplete."""
    rows, cols, depth = header
    data, channels = document.image_data.data, document.header.channels
    needed = 0
    if document.image_data.compression == Compression.RAW:
        needed = rows * cols * channels * depth // 8
    elif document.image_data.compression == Compression.RLE:
        size = 2 * document.header.version
        needed = rows * channels * size
        if len(data) >= needed:
            needed += int(np.frombuffer(data[:needed], f">u{size}").sum(dtype=np.int64))
    if 0 < len(data) < needed:
        raise damaged(path)
