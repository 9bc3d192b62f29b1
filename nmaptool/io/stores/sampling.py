"""A sample of a picture: windows that are spread over it and reach all its edges."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from nmaptool.types.picture import RasterImage
from nmaptool.types.windows import PictureStore

# so many windows down and across, of this size
_SAMPLES, _SAMPLE_PX = 4, 512


def spread_windows(rows: int, cols: int) -> Iterator[tuple[slice, slice]]:
    """The windows of the sample; a small picture is one window."""
    return itertools.product(_spans(rows), _spans(cols))


def sample_of(picture: PictureStore) -> tuple[RasterImage, list[tuple[slice, slice]]]:
    """Windows spread over a picture, joined into one, and their places in it; a small picture is taken whole."""
    down, across = (_spans(size) for size in (picture.rows, picture.cols))
    if len(down) == len(across) == 1:
        whole = picture.read(down[0], across[0])
        return whole, [(down[0], across[0])]
    rows = [[picture.read(row, col) for col in across] for row in down]
    pixels = np.concatenate([np.concatenate([one.pixels for one in row], axis=1) for row in rows], axis=0)
    places = [(row, col) for row in _joined(down) for col in _joined(across)]
    return replace(rows[0][0], pixels=pixels), places


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
