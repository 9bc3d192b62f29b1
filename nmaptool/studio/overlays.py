"""What the page shows over the relief and only the composed map can tell: its curl and its coverage."""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from nmaptool.core.errors import InputError, UsageError
from nmaptool.figures.curl import curl_codes
from nmaptool.studio.document import Document
from nmaptool.studio.worker import Worker
from nmaptool.types.normal_map import NormalMap

Codes: TypeAlias = NDArray[np.uint8]

# longer side of a picture for the page
MOST_PX = 1024


def overlay(worker: Worker, document: Document, name: str) -> bytes:
    """Return an overlay of the composed map of a document, in any thread.

    Two little-endian uint32, columns and rows, come first; one byte for each pixel follows, row by row. At most
    `MOST_PX` on the longer side: of larger maps, each pixel has the largest curl or the mean coverage of its block.

    Parameters
    ----------
    worker : Worker
    document : Document
    name : {"curl", "coverage"}
        |curl| on the logarithmic scale of `nmaptool.curl_picture`, or the coverage, as 0 to 255.

    Raises
    ------
    UsageError
        If there is no such overlay.
    InputError
        If the maps of the document have not been read, or could not be.
    """
    if name not in _OVERLAYS:
        raise UsageError(f"`{name}`: is not an overlay; the studio has {' and '.join(_OVERLAYS)}")
    # an engine never changes once it is made, so that the solver may go on meanwhile
    engine = worker.engine_of(document)
    if engine is None:
        raise InputError(f"{document.name}: its maps have not been read yet; try again when the relief is shown")
    codes = _OVERLAYS[name](engine.scene.composition.normal_map)
    rows, cols = codes.shape
    return struct.pack("<II", cols, rows) + codes.tobytes()


def _curl(normal_map: NormalMap) -> Codes:
    codes = curl_codes(normal_map)
    for axis in (0, 1):
        starts = _starts(codes.shape[axis], max(codes.shape))
        codes = np.maximum.reduceat(codes, starts, axis=axis)
    return codes


def _coverage(normal_map: NormalMap) -> Codes:
    codes = np.rint(normal_map.coverage * 255).astype(np.uint8)
    rows, cols = (len(_starts(count, max(codes.shape))) for count in codes.shape)
    return np.asarray(cv2.resize(codes, (cols, rows), interpolation=cv2.INTER_AREA), np.uint8)


def _starts(count: int, longest: int) -> NDArray[np.intp]:
    """Return where the blocks of a side begin that become one pixel each."""
    blocks = max(1, round(count * min(1.0, MOST_PX / longest)))
    return np.arange(blocks) * count // blocks


_OVERLAYS: dict[str, Callable[[NormalMap], Codes]] = {"curl": _curl, "coverage": _coverage}
