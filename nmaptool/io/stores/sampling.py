"""A sample of a picture: windows that are spread over it, reach all its edges, and show its most varied places."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from nmaptool.io.stores.tiff_files import TiffPicture
from nmaptool.io.stores.zarr_pictures import ZarrPicture
from nmaptool.types.picture import RasterImage
from nmaptool.types.windows import PictureStore

# so many windows down and across, of this size
_SAMPLES, _SAMPLE_PX = 4, 512
# the places that the inner windows are chosen from: so many down and across, looked at in spots of this size; fewer
# where a spot needs a whole tile
_PROBES, _FEWER_PROBES, _PROBE_PX = 16, 8, 64

Window = tuple[slice, slice]


def spread_windows(rows: int, cols: int) -> Iterator[Window]:
    """Windows on a regular grid that reaches all edges; a small picture is one window."""
    return itertools.product(_spans(rows), _spans(cols))


def sample_of(
    picture: PictureStore, check: Callable[[RasterImage, tuple[int, int]], object]
) -> tuple[RasterImage, list[Window]]:
    """Windows spread over a picture, joined into one, and their places in it; a small picture is taken whole.

    The windows of the outer rows and columns lie along the edges of the picture. Those between them lie where the
    picture varies most, so that a small motif on a large background is not missed.

    Parameters
    ----------
    picture : PictureStore
    check : callable
        Called with each window and the row and column of its first pixel, to refuse it.
    """

    def read(rows: slice, cols: slice) -> RasterImage:
        image = picture.read(rows, cols)
        check(image, (rows.start, cols.start))
        return image

    down, across = (_spans(size) for size in (picture.rows, picture.cols))
    if len(down) == len(across) == 1:
        return read(down[0], across[0]), [(down[0], across[0])]
    windows = [[(row, col) for col in across] for row in down]
    if len(down) == len(across) == _SAMPLES:
        inner = itertools.product(range(1, _SAMPLES - 1), repeat=2)
        for (row, col), window in zip(inner, _varied(picture), strict=False):
            windows[row][col] = window
    images = [[read(*window) for window in row] for row in windows]
    pixels = np.concatenate([np.concatenate([one.pixels for one in row], axis=1) for row in images], axis=0)
    places = [(row, col) for row in _joined(down) for col in _joined(across)]
    return replace(images[0][0], pixels=pixels), places


def _spans(size: int) -> list[slice]:
    """The rows or columns of the sample."""
    if size <= _SAMPLES * _SAMPLE_PX:
        return [slice(0, size)]
    starts: list[Any] = np.linspace(0, size - _SAMPLE_PX, _SAMPLES).astype(int).tolist()
    return [slice(start, start + _SAMPLE_PX) for start in starts]


def _joined(spans: Sequence[slice]) -> list[slice]:
    """The places of spans that are put side by side."""
    ends = np.cumsum([span.stop - span.start for span in spans]).tolist()
    return [slice(end - (span.stop - span.start), end) for end, span in zip(ends, spans, strict=True)]


def _varied(picture: PictureStore) -> list[Window]:
    """Windows around the spots that vary most, the most varied first."""
    if isinstance(picture, TiffPicture) and picture.is_slow:
        return []
    count = _PROBES if isinstance(picture, ZarrPicture) else _FEWER_PROBES
    found = []
    for row, col in itertools.product(*(_starts(size, count) for size in (picture.rows, picture.cols))):
        spot = picture.read(slice(row, row + _PROBE_PX), slice(col, col + _PROBE_PX)).pixels
        with np.errstate(over="ignore", invalid="ignore"):
            spread = float(np.nan_to_num(spot.astype(np.float32), posinf=0, neginf=0).std(axis=(0, 1)).sum())
        found.append((spread, row, col))
    found.sort(reverse=True)
    best = found[: (_SAMPLES - 2) ** 2]
    return [(_around(row, picture.rows), _around(col, picture.cols)) for _, row, col in best]


def _starts(size: int, count: int) -> list[int]:
    """Where the spots begin, in the middle of ``count`` equal parts."""
    return [int((number + 0.5) * size / count) - _PROBE_PX // 2 for number in range(count)]


def _around(start: int, size: int) -> slice:
    """The rows or columns of a window around a spot."""
    first = min(max(0, start + _PROBE_PX // 2 - _SAMPLE_PX // 2), size - _SAMPLE_PX)
    return slice(first, first + _SAMPLE_PX)
