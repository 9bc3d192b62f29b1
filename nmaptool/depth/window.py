"""The places around a pixel that it reaches over links: a window of places, and the paths to them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Mask

REACH = 6
# bits of the links in the state of a pixel
RIGHT, DOWN = np.uint8(1), np.uint8(2)
_Way = tuple[int, int, np.uint8]


def _disc() -> tuple[tuple[int, int], ...]:
    """Return the offsets (down, right) of the places, those with fewer steps first."""
    side = range(-REACH, REACH + 1)
    places = [(y, x) for y in side for x in side if x * x + y * y <= REACH * (REACH + 1)]
    return tuple(sorted(places, key=lambda place: abs(place[0]) + abs(place[1])))


def _ways(places: tuple[tuple[int, int], ...]) -> tuple[tuple[_Way, ...], ...]:
    """Return for each place the last steps of its paths: the nearer place, the pixel that holds the link, its kind."""
    number = {place: i for i, place in enumerate(places)}
    found = []
    for y, x in places:
        ways = []
        if x:
            nearer = number[y, x - (1 if x > 0 else -1)]
            ways.append((nearer, nearer if x > 0 else number[y, x], RIGHT))
        if y:
            nearer = number[y - (1 if y > 0 else -1), x]
            ways.append((nearer, nearer if y > 0 else number[y, x], DOWN))
        found.append(tuple(ways))
    return tuple(found)


_PLACES = _disc()
_WAYS = _ways(_PLACES)
WINDOW_Y, WINDOW_X = (np.array([place[axis] for place in _PLACES], np.float32) for axis in (0, 1))


def around(shape: tuple[int, int], row: NDArray[np.intp], col: NDArray[np.intp]) -> tuple[NDArray[np.int32], Mask]:
    """Return the (M, K) int32 flat indices of the places around K pixels, and whether they are in the picture."""
    y = row.astype(np.int32) + WINDOW_Y.astype(np.int32)[:, None]
    x = col.astype(np.int32) + WINDOW_X.astype(np.int32)[:, None]
    inside = (y >= 0) & (y < shape[0]) & (x >= 0) & (x < shape[1])
    if not inside.all():
        np.clip(y, 0, shape[0] - 1, out=y)
        np.clip(x, 0, shape[1] - 1, out=x)
    y *= np.int32(shape[1])
    y += x
    return y, inside


def reached(state: NDArray[np.uint8], inside: Mask) -> Mask:
    """Return (M, K) bool: which places are reached from the centre by paths that only lead away from it.

    Parameters
    ----------
    state : (M, K) uint8
        Links of the places: bit 0 to the right, bit 1 down.
    inside : (M, K) bool
        Whether each place is in the picture.
    """
    right, down = (state & RIGHT) > 0, (state & DOWN) > 0
    out = np.zeros(state.shape, bool)
    out[0] = True
    for place, ways in enumerate(_WAYS):
        for nearer, link, kind in ways:
            out[place] |= out[nearer] & (right if kind == RIGHT else down)[link]
        out[place] &= inside[place]
    return out
