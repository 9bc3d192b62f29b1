"""Normals at outlines: where a surface ends at a jump, its normals are extrapolated from inside.

Where a surface turns away, its slope is unbounded at the outline, and differences of heights fail well before it. Its
normals change evenly: those of a sphere are linear in the picture up to the outline, those of a plane are constant. So
x and y of the normals beside a jump are extrapolated by a plane fitted to those a few pixels behind; z follows from
them.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.grid import places
from nmaptool.core.parallel import map_parallel
from nmaptool.core.vectors import unit
from nmaptool.depth.tiles import along
from nmaptool.depth.window import DOWN, RIGHT, WINDOW_X, WINDOW_Y, around, reached

# pixels per batch, which fits in the processor's cache
_CHUNK = 1024
_MOST_THREADS = 4
_CROSS = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
# layers of pixels next to a jump that are extrapolated; on clean heights the third layer is inaccurate, too
_CONTINUED = 2
_LAYER_BIT = 2
# the layer of a pixel, by the number of nested layer masks that contain it
_LAYER_OF_COUNT = np.zeros(256, np.uint8)
_LAYER_OF_COUNT[1:4] = 3, 2, 1
# sigma in px of the weights of normals by their distance; stepped heights need more normals
_CLEAN_SPREAD, _FITTED_SPREAD = 2.5, 3.5
# how far (length of the difference) normals may turn from the mean of those behind, and from the last one behind
_MOST_TURN, _MOST_STEP = np.float32(0.6), np.float32(0.3)
_LEAST_Z = np.float32(0.02)
_MOST_XY = np.sqrt(1 - _LEAST_Z * _LEAST_Z)
# px^2: regularises the fit where the pixels behind are hardly spread
_STIFF = np.float32(1e-3)
# largest variance of an extrapolated normal: with more, the pixels behind are too few or too narrow
_MOST_DOUBT = np.float32(2.0)
_NO_WEIGHT = np.float32(1e-5)
# deviation of the second layer's normals from the plane at which its share begins to fall, and at which it is 0
_BENT, _CREASED = np.float32(0.12), np.float32(0.25)
_X, _Y = WINDOW_X, WINDOW_Y
_DISTANCE2 = _X * _X + _Y * _Y
_PLANE = np.stack([np.ones_like(_X), _X, _Y])
_MOMENTS = np.concatenate([_PLANE, [_X * _X, _X * _Y, _Y * _Y]])
_CLOSE_PLACES = int(np.flatnonzero(_DISTANCE2 < 7)[-1]) + 1  # places are sorted by distance


def _nearness(spread: float) -> Float32:
    """Return the (M, 1) float32 weights of the places around a pixel."""
    return np.asarray(np.exp(_DISTANCE2 / np.float32(-2 * spread * spread))[:, None])


_CLOSE = _nearness(1.5)[:_CLOSE_PLACES]


def continue_to_jumps(normals: Float32, across: Mask, down: Mask, flat: Mask | None, *, clean: bool) -> None:
    """Extrapolate the normals beside jumps from those behind them, in place.

    Parameters
    ----------
    normals : (H, W, 3) float32
    across, down : (H, W) bool
        Links to the next pixel to the right, and below.
    flat : (H, W) bool or None
        Pixels that are not changed.
    clean : bool
        Whether normals are exact except near jumps; the fit then uses fewer and closer pixels.
    """
    layers = _layers(across, down)
    if not layers.any():
        return
    _turn_on(normals, across, down, layers, flat)
    wanted = layers - np.uint8(1) < _CONTINUED
    if flat is not None:
        wanted &= ~flat
    row, col = places(wanted)
    del wanted
    state = layers
    state <<= _LAYER_BIT
    state |= across.view(np.uint8) * RIGHT
    state |= down.view(np.uint8) * DOWN

    def work(start: int) -> Float32:
        part = slice(start, start + _CHUNK)
        return _continued(normals, state, row[part], col[part], clean)

    found = map_parallel(range(0, len(row), _CHUNK), work, _MOST_THREADS)
    if found:
        normals[row, col] = np.concatenate(found)


def _turn_on(normals: Float32, across: Mask, down: Mask, layers: NDArray[np.uint8], flat: Mask | None) -> None:
    """Extrapolate the normals beside a jump from the two behind, in place; this is right even at a crease."""
    wanted = layers == 1
    if flat is not None:
        wanted &= ~flat
    row, col = places(wanted)
    inward = []
    for axis, links in ((0, down), (1, across)):
        place = (row, col)[axis]
        before = (row - (axis == 0), col - (axis == 1))  # -1 is the last pixel, which has no link
        forth = links[row, col] | (place == links.shape[axis] - 1)
        back = links[before] | (place == 0)
        inward.append(forth.astype(np.intp) - back.astype(np.intp))
    near, far = (
        ((row + by * inward[0]).clip(0, layers.shape[0] - 1), (col + by * inward[1]).clip(0, layers.shape[1] - 1))
        for by in (1, 2)
    )
    sound = (layers[near] != 1) & (layers[far] != 1)
    first, second = (normals[place[0][sound], place[1][sound]] for place in (near, far))
    turn = first - second
    size = np.sqrt(np.einsum("ij,ij->i", turn, turn))
    turn *= np.minimum(np.float32(1), _MOST_STEP / np.maximum(size, _MOST_STEP))[:, None]
    turned = first + turn
    np.maximum(turned[:, 2], _LEAST_Z, out=turned[:, 2])
    normals[row[sound], col[sound]] = unit(turned)


def _layers(across: Mask, down: Mask) -> NDArray[np.uint8]:
    """Return (H, W) uint8: 1 beside a jump or unknown height, 2 and 3 behind; the picture's edge is not a jump."""
    beside = np.zeros(across.shape, np.uint8)
    for axis, links in ((0, down), (1, across)):
        first, last = along(axis, None, -1), along(axis, 1, None)
        broken = ~links[first]
        beside[first] |= broken
        beside[last] |= broken
    if not beside.any():
        return beside
    second = cv2.dilate(beside, _CROSS)
    third = cv2.dilate(second, _CROSS)
    third += second
    third += beside
    return np.asarray(cv2.LUT(third, _LAYER_OF_COUNT))


@dataclass(frozen=True, eq=False)
class _Line:
    """Planes fitted to x and y of the normals around K pixels.

    Attributes
    ----------
    here : (2, K) float32
        Their value at the pixel.
    slope : (2, 2, K) float32
        Their change per pixel to the right and down.
    doubt : (K,) float32
        Variance of the value, relative to that of one normal.
    """

    here: Float32
    slope: Float32
    doubt: Float32


def _line(weight: Float32, values: Float32) -> _Line:
    """Fit planes to (2, M, K) values with (M, K) weights."""
    total, x, y, xx, xy, yy = _MOMENTS @ weight
    nothing = total < _NO_WEIGHT
    share = 1 / np.maximum(total, _NO_WEIGHT)
    x, y, xx, xy, yy = (moment * share for moment in (x, y, xx, xy, yy))
    xx += _STIFF - x * x
    yy += _STIFF - y * y
    xy -= x * y
    area = xx * yy - xy * xy
    sums = np.stack([_PLANE @ (value * weight) for value in values]) * share
    mean = sums[:, 0]
    along_x, along_y = sums[:, 1] - mean * x, sums[:, 2] - mean * y
    slope = np.stack([yy * along_x - xy * along_y, xx * along_y - xy * along_x], axis=1) / area
    turn = -(slope[:, 0] * x + slope[:, 1] * y)
    size = np.hypot(turn[0], turn[1])
    turn *= np.minimum(np.float32(1), _MOST_TURN / np.maximum(size, _MOST_TURN))
    lever = 1 + (yy * x * x - 2 * xy * x * y + xx * y * y) / area
    doubt: Float32 = lever * np.einsum("mk,mk->k", weight, weight) * share * share
    doubt[nothing] = np.inf
    return _Line(mean + turn, slope, doubt)


def _continued(
    normals: Float32, state: NDArray[np.uint8], row: NDArray[np.intp], col: NDArray[np.intp], clean: bool
) -> Float32:
    """Return the (K, 3) float32 normals of pixels, extrapolated by planes fitted to those around."""
    index, inside = around(state.shape, row, col)
    there = state.reshape(-1)[index]
    linked = reached(there, inside)
    layer = there >> _LAYER_BIT
    behind = linked & ((layer == 0) if clean else (layer == 0) | (layer > _CONTINUED))
    index *= np.int32(3)
    components = normals.reshape(-1)
    values = np.stack([components.take(index), components.take(index + np.int32(1))])
    nearness = _nearness(_CLEAN_SPREAD if clean else _FITTED_SPREAD)
    line = _line(np.where(behind, nearness, np.float32(0)), values)
    here, slope, doubt = line.here, line.slope, line.doubt
    narrow = np.flatnonzero(~(doubt <= _MOST_DOUBT))  # such as a thin stem: use all layers behind the first
    if len(narrow):
        second = _line(np.where((linked & (layer != 1))[:, narrow], nearness, np.float32(0)), values[:, :, narrow])
        here[:, narrow], slope[:, :, narrow], doubt[narrow] = second.here, second.slope, second.doubt
    # the second layer shows whether the plane fits up to the jump
    close = slice(_CLOSE_PLACES)
    weight = _CLOSE * (linked[close] & (layer[close] == _CONTINUED))
    off = values[:, close] - here[:, None]
    off -= slope[:, :1] * _X[close, None]
    off -= slope[:, 1:] * _Y[close, None]
    apart = (np.hypot(off[0], off[1]) * weight).sum(axis=0) / np.maximum(weight.sum(axis=0), _NO_WEIGHT)
    share = ((_CREASED - apart) / (_CREASED - _BENT)).clip(0, 1) * (doubt <= _MOST_DOUBT)
    return _upright(values[:, 0] + share * (here - values[:, 0]))


def _upright(xy: Float32) -> Float32:
    """Return (K, 3) float32 unit normals from (2, K) x and y, with z at least _LEAST_Z."""
    size = np.maximum(np.hypot(xy[0], xy[1]), _MOST_XY)
    xy = xy * (_MOST_XY / size)
    return np.stack([xy[0], xy[1], np.sqrt(1 - xy[0] * xy[0] - xy[1] * xy[1])], axis=1)
