"""Process a large picture in tiles that fit in the processor's cache, several at a time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

from nmaptool.core.parallel import map_parallel

_SIDE = 384
_MOST_THREADS = 4
Window = tuple[slice, slice]


@dataclass(frozen=True)
class Tile:
    """A tile of a picture: the pixels that it computes, and those that it reads.

    Attributes
    ----------
    core : (slice, slice)
        Rows and columns that the tile computes.
    outer : (slice, slice)
        The same with a halo, clipped at the picture's edge.
    inner : (slice, slice)
        Position of the core in the outer window.
    """

    core: Window
    outer: Window
    inner: Window


def _spans(length: int, halo: int, side: int) -> list[tuple[slice, slice, slice]]:
    spans = []
    for start in range(0, length, side):
        stop = min(start + side, length)
        low, high = max(start - halo, 0), min(stop + halo, length)
        spans.append((slice(start, stop), slice(low, high), slice(start - low, stop - low)))
    return spans


def for_tiles(shape: tuple[int, int], halo: int, work: Callable[[Tile], object], side: int = _SIDE) -> None:
    """Call ``work`` once per tile, in several threads; tiles must not write outside their core.

    Parameters
    ----------
    shape : (int, int)
        Shape of the picture.
    halo : int
        Pixels around the core that ``work`` reads.
    work : callable
    side : int
        Side of the core in pixels.
    """
    tiles = [
        Tile((rows[0], cols[0]), (rows[1], cols[1]), (rows[2], cols[2]))
        for rows, cols in product(_spans(shape[0], halo, side), _spans(shape[1], halo, side))
    ]
    map_parallel(tiles, work, _MOST_THREADS)


def along(axis: int, start: int | None, stop: int | None) -> Window:
    """Return a window of a picture that is cut along one axis only."""
    part = slice(start, stop)
    return (part, slice(None)) if axis == 0 else (slice(None), part)
