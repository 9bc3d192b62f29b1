"""The triangles of a height field, in NumPy: the twin of ``faces.h``."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64, Mask

Ints = NDArray[np.int32]


def falling_diagonals(z: Float64, width: int, before: int, out: Mask) -> float:
    """Whether the surface bends less along the falling diagonal of each pixel of some rows.

    Parameters
    ----------
    z : (k, width) float64
        The heights at the corners of those rows, and a row more above and below where there is one.
    width : int
        Pixels in a row, and one more.
    before : int
        Rows of ``z`` above the corners of the first row of pixels, 0 or 1.
    out : (n, width - 1) bool
    """
    rows, count = z.reshape(-1, width), out.size // (width - 1)
    z = np.pad(
        rows[np.clip(np.arange(before - 1, before + count + 2), 0, len(rows) - 1)], ((0, 0), (1, 1)), mode="edge"
    )
    bend_falling = np.abs(z[:-3, :-3] - z[1:-2, 1:-2] - z[2:-1, 2:-1] + z[3:, 3:])
    bend_rising = np.abs(z[3:, :-3] - z[2:-1, 1:-2] - z[1:-2, 2:-1] + z[:-3, 3:])
    np.less_equal(bend_falling, bend_rising, out=out.reshape(count, width - 1))
    return 0.0


def pixel_faces(inside: Mask, falls: Mask, width: int, is_back: bool, out: Ints) -> float:
    """Two triangles for each pixel inside, counter-clockwise seen from +z, or for a back from -z.

    Parameters
    ----------
    inside, falls : (n, width - 1) bool
        Which pixels have triangles, and which are split along the falling diagonal.
    width : int
        Vertices in a row; they are numbered row by row.
    is_back : bool
    out : (m, 3) int32

    Returns
    -------
    float
        How many pixels have triangles.
    """
    row, col = np.nonzero(inside.reshape(-1, width - 1))
    nw = (row * width + col).astype(np.int32)
    faces = two_each((nw, nw + 1, nw + width, nw + width + 1), falls[inside])
    out[: len(faces)] = faces[:, ::-1] if is_back else faces
    return float(len(row))


def two_each(corners: Sequence[Ints], falls: Mask) -> Ints:
    """(2 n, 3) int32: two triangles for each of n pixels with corners nw, ne, sw, se, counter-clockwise from +z."""
    nw, ne, sw, se = corners
    faces = np.empty((len(nw), 2, 3), np.int32)
    # falling: nw sw se, nw se ne; rising: nw sw ne, sw se ne
    faces[:, 0, 0] = nw
    faces[:, 0, 1] = sw
    faces[:, 0, 2] = np.where(falls, se, ne)
    faces[:, 1, 0] = np.where(falls, nw, sw)
    faces[:, 1, 1] = se
    faces[:, 1, 2] = ne
    return faces.reshape(-1, 3)
