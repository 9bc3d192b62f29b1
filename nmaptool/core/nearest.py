"""The nearest pixel of a mask, for pixels that mostly lie close to it."""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Mask
from nmaptool.core.grid import places

Places = NDArray[np.intp]
# farther pixels are looked up by a distance transform of the whole picture
_REACH_PX = 12


def nearest_places(sought: Mask, at: Mask) -> tuple[Places, Places]:
    """Rows and columns of the nearest pixel of one mask for each pixel of another, by Euclidean distance.

    Of several nearest pixels, that of the lowest column is chosen, in it that of the lowest row, as by
    `scipy.ndimage.distance_transform_edt`.

    Parameters
    ----------
    sought : (H, W) bool
        At least one pixel.
    at : (H, W) bool
        The N pixels to find the nearest one for.

    Returns
    -------
    rows, cols : (N,) int

    Examples
    --------
    >>> sought = np.array([[True, False, False, True]])
    >>> nearest_places(sought, ~sought)
    (array([0, 0]), array([0, 3]))
    """
    rows, cols = places(at)
    found_rows, found_cols = rows.copy(), cols.copy()
    # a border spares the checks for pixels outside the picture
    framed = np.pad(sought, _REACH_PX)
    width, flat = framed.shape[1], framed.ravel()
    here = (rows + _REACH_PX) * width + cols + _REACH_PX
    left = np.arange(len(rows))
    for down, right in _steps():
        hit = flat[here + (down * width + right)]
        if hit.any():
            found = left[hit]
            found_rows[found] += down
            found_cols[found] += right
            left, here = left[~hit], here[~hit]
        if not len(left):
            return found_rows, found_cols
    from scipy import ndimage  # takes long to load, and is rarely needed

    nearest = ndimage.distance_transform_edt(~sought, return_distances=False, return_indices=True)
    found_rows[left], found_cols[left] = nearest[:, rows[left], cols[left]]
    return found_rows, found_cols


@functools.cache
def _steps() -> tuple[tuple[int, int], ...]:
    """Steps (down, right) within reach, the shortest first, of equal ones by column and row."""
    reach = range(-_REACH_PX, _REACH_PX + 1)
    steps = [(down, right) for down in reach for right in reach if down**2 + right**2 <= _REACH_PX**2]
    return tuple(sorted(steps, key=lambda step: (step[0] ** 2 + step[1] ** 2, step[1], step[0])))
