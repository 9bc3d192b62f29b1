"""Move, rotate and stretch maps: pixels, their vectors and their coverage.

Coordinates run across and down from the top left corner, with pixel centres at .5; a matrix takes coordinates of the
map to those of the canvas. Slopes g become k A^-T g, where A is the matrix with y up and k the factor on heights.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.composition.interpolation import border, interpolated
from nmaptool.core.arrays import Float32, Float64, Mask
from nmaptool.core.errors import LimitError, UsageError
from nmaptool.core.parallel import for_each_band
from nmaptool.core.units import Length
from nmaptool.core.vectors import FLAT, unit
from nmaptool.types.picture import Frame

# scales that differ by less differ by the rounding of sizes in px, not by stretching
_UNEVEN = 0.01
_EXACT = 1e-7
_WHOLE = 1e-4  # px
_LARGEST_FACTOR = 1e3
_TILE = 128
_PIXELS_AT_ONCE = 1 << 16  # fits one band of `unit`
_LONGEST_SIDE = 32_000  # what OpenCV can address


@dataclass(frozen=True, eq=False)
class Piece:
    """The part of a canvas that a layer covers.

    Attributes
    ----------
    normals : (h, w, 3) float32
    coverage : (h, w) float32
    foreground : (h, w) bool
    left, top : int
        Position of its corner on the canvas.
    """

    normals: Float32
    coverage: Float32
    foreground: Mask
    left: int = 0
    top: int = 0


def linear_part(
    scale: tuple[float, float] = (1.0, 1.0), flip_h: bool = False, flip_v: bool = False, rotate_deg: float = 0.0
) -> Float64:
    """Return the (2, 2) matrix that scales, mirrors, then rotates counter-clockwise; quarter turns are exact."""
    quarters = rotate_deg / 90
    if quarters == round(quarters):
        cos, sin = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[round(quarters) % 4]
    else:
        cos, sin = float(np.cos(np.radians(rotate_deg))), float(np.sin(np.radians(rotate_deg)))
    turn = np.array([[cos, sin], [-sin, cos]])  # rows go down
    return turn @ np.diag([-scale[0] if flip_h else scale[0], -scale[1] if flip_v else scale[1]])


def with_fixed_point(linear: Float64, source: tuple[float, float], target: tuple[float, float]) -> Float64:
    """Return the (2, 3) matrix that takes ``source`` to ``target``, rounded to whole pixels if nothing is resampled."""
    move = np.array(target) - linear @ np.array(source)
    if is_exact(linear):
        move = np.floor(move + 0.5 + _EXACT)
    return np.column_stack([linear, move])


def scale_factors(scale: tuple[float, float] | Length, frame: Frame, cols: int) -> tuple[float, float]:
    """Return the factors across and down for a map with ``cols`` columns; a length is its new width, % is of ``frame``.

    Raises
    ------
    UsageError
        If a length is in mm and the pitch of the frame is unknown, or it is less than 0.001 or more than 1000 times the
        width of the map.
    """
    if not isinstance(scale, Length):
        return scale
    if scale.is_absolute and frame.pitch_mm is None:
        raise UsageError(f"`scale='{scale}'`: the size of a pixel is not known; give `width='100mm'`, or a factor")
    pitch = frame.pitch_mm or 1.0
    factor = scale.to_mm(pitch, frame.cols) / pitch / cols
    if not 1 / _LARGEST_FACTOR <= factor <= _LARGEST_FACTOR:
        raise UsageError(f"`scale='{scale}'`: is {factor:.3g} times the layer's size; use 0.001 to 1000 times")
    return factor, factor


def is_exact(linear: Float64) -> bool:
    """Whether pixels map exactly to pixels: quarter turns and mirrors."""
    whole = np.round(linear)
    return bool(np.abs(linear - whole).max() < _EXACT and np.array_equal(np.abs(whole @ whole.T), np.eye(2)))


def default_height_factor(linear: Float64) -> float:
    """Return the factor on heights in px: the scale if it is the same in all directions, which keeps slopes; else 1."""
    stretch = np.linalg.svd(linear, compute_uv=False)
    return 1.0 if is_uneven(stretch) else float(np.sqrt(stretch.prod()))


def is_uneven(scales: Iterable[float]) -> bool:
    """Whether two scales differ by more than the rounding of sizes in px."""
    low, high = sorted(scales)
    return high > low * (1 + _UNEVEN)


def turn_vectors(normals: Float32, linear: Float64, height_factor: float) -> Float32:
    """Return the normals of a surface after its picture is mapped by ``linear`` and its heights are multiplied.

    Parameters
    ----------
    normals : (..., 3) float32
        Unit normals.
    linear : (2, 2) float64
        Matrix of picture coordinates, with y down.
    height_factor : float

    Returns
    -------
    (..., 3) float32
        Unit normals; rotations, mirrors and uniform scaling with the same height factor keep lengths up to rounding.
    """
    up = linear * np.array([[1, -1], [-1, 1]])
    gradient = (height_factor * np.linalg.inv(up).T).astype(np.float32)
    if np.array_equal(gradient, np.eye(2)):
        return normals
    out = np.empty_like(normals)
    x, y = normals[..., 0], normals[..., 1]
    for axis in range(2):
        np.multiply(x, gradient[axis, 0], out=out[..., axis])
        out[..., axis] += y * gradient[axis, 1]
    out[..., 2] = normals[..., 2]
    keeps_length = np.allclose(gradient @ gradient.T, np.eye(2), atol=1e-6)
    return out if keeps_length else unit(out)


def map_piece(
    source: Piece,
    matrix: Float64,
    window: tuple[int, int, int, int],
    height_factor: float | None = None,
    name: str = "a picture",
) -> Piece:
    """Map a piece to a window of a canvas.

    Parameters
    ----------
    source : Piece
        Its ``left`` and ``top`` are ignored.
    matrix : (2, 3) float64
    window : (left, top, cols, rows)
        Part of the canvas; at least one pixel.
    height_factor : float, optional
        Default: `default_height_factor`.
    name : str
        Name for messages.

    Returns
    -------
    Piece
        Bit-exact if pixels map to pixels; otherwise resampled by Lanczos interpolation inside the coverage, linear
        along its edge and next to jumps, after averaging if it shrinks. An edge of the picture that falls between
        pixels stays hard.

    Raises
    ------
    LimitError
        If a side is longer than 32,000 px and must be resampled.
    """
    linear = matrix[:, :2]
    k = default_height_factor(linear) if height_factor is None else height_factor
    if is_exact(linear) and np.abs(matrix[:, 2] - np.round(matrix[:, 2])).max() < 1e-4:
        piece = _move_pixels(source, np.round(matrix), window)
        return Piece(turn_vectors(piece.normals, linear, k), piece.coverage, piece.foreground, piece.left, piece.top)
    if max(*source.coverage.shape, window[2], window[3]) > _LONGEST_SIDE:
        raise LimitError(
            f"{name}: has a side of more than {_LONGEST_SIDE} px, the limit for rotating and resizing; crop it, or "
            "make it smaller"
        )
    return _resample(source, matrix, window, k)


def bounds(matrix: Float64, cols: int, rows: int) -> tuple[int, int, int, int]:
    """Return (left, top, right, bottom) of a mapped picture in whole px."""
    corners = matrix[:, :2] @ np.array([[0, cols, 0, cols], [0, 0, rows, rows]]) + matrix[:, 2:]
    low, high = np.floor(corners.min(axis=1) + 1e-6), np.ceil(corners.max(axis=1) - 1e-6)
    return int(low[0]), int(low[1]), int(high[0]), int(high[1])


def _move_pixels(source: Piece, matrix: Float64, window: tuple[int, int, int, int]) -> Piece:
    """Mirror, rotate by quarter turns and shift by whole pixels."""
    left, top, cols, rows = window
    arrays = []
    low = bounds(matrix, source.coverage.shape[1], source.coverage.shape[0])
    for array, empty in ((source.normals, FLAT), (source.coverage, 0), (source.foreground, False)):
        moved = array.swapaxes(0, 1) if matrix[0, 0] == 0 else array
        across = matrix[0, 0] or matrix[0, 1]
        down = matrix[1, 1] or matrix[1, 0]
        moved = moved[:: int(down), :: int(across)]
        out = np.empty((rows, cols, *array.shape[2:]), array.dtype)
        out[...] = empty
        x, y = low[0] - left, low[1] - top
        x0, x1 = max(x, 0), min(x + moved.shape[1], cols)
        y0, y1 = max(y, 0), min(y + moved.shape[0], rows)
        if x0 < x1 and y0 < y1:
            _copy_in_tiles(moved[y0 - y : y1 - y, x0 - x : x1 - x], out[y0:y1, x0:x1])
        arrays.append(out)
    return Piece(arrays[0], arrays[1], arrays[2], left, top)


def _copy_in_tiles(source: NDArray[Any], out: NDArray[Any]) -> None:
    """Copy a picture that may be transposed; in tiles, because whole rows would miss the cache at every pixel."""

    def copy(band: slice) -> None:
        for first in range(0, out.shape[1], _TILE):
            out[band, first : first + _TILE] = source[band, first : first + _TILE]

    for_each_band(len(out), _TILE, copy)


def _resample(source: Piece, matrix: Float64, window: tuple[int, int, int, int], height_factor: float) -> Piece:
    import cv2

    linear = matrix[:, :2]
    full = bool((source.coverage >= 1).all())
    mixed = np.dstack([source.normals if full else source.normals * source.coverage[..., None], source.coverage])
    plain = np.array_equal(source.foreground, source.coverage >= 0.5)
    motif = None if plain else source.foreground * source.coverage
    shrunk = _shrunk_size(matrix, source.coverage.shape)
    if shrunk != source.coverage.shape:
        rows, cols = source.coverage.shape
        mixed = cv2.resize(mixed, shrunk[::-1], interpolation=cv2.INTER_AREA)
        motif = None if motif is None else cv2.resize(motif, shrunk[::-1], interpolation=cv2.INTER_AREA)
        matrix = matrix @ np.diag([cols / shrunk[1], rows / shrunk[0], 1])
    left, top, cols, rows = window
    # the origin of OpenCV is the centre of the first pixel
    centred = np.column_stack([matrix[:, :2], matrix[:, :2] @ [0.5, 0.5] + matrix[:, 2] - (left + 0.5, top + 0.5)])
    whole = _has_whole_edges(matrix, mixed.shape)
    box = np.subtract(bounds(matrix, mixed.shape[1], mixed.shape[0]), (left, top, left, top)) if whole else None
    inside = (mixed[..., 3] >= 1 - 1e-6).astype(np.uint8)
    inside = cv2.erode(inside, np.ones((9, 9), np.uint8), borderType=cv2.BORDER_CONSTANT, borderValue=int(whole))
    out = Piece(
        np.empty((rows, cols, 3), np.float32),
        np.empty((rows, cols), np.float32),
        np.empty((rows, cols), bool),
        left,
        top,
    )

    def fill(band: slice) -> None:
        """Fill a band; in bands, because interpolation needs work arrays several times as large as its result."""
        moved = centred - np.array([[0, 0, 0], [0, 0, band.start]])
        size = (cols, band.stop - band.start)
        vectors, coverage = interpolated(mixed, inside, moved, size, None if box is None else box - (0, band.start) * 2)
        out.normals[band] = turn_vectors(vectors, linear, height_factor)
        out.coverage[band] = coverage
        out.foreground[band] = coverage >= 0.5
        if motif is not None:
            shown = cv2.warpAffine(motif, moved, size, flags=cv2.INTER_LINEAR, borderMode=border(box))
            out.foreground[band] = (shown >= 0.5 * coverage) & (coverage > 0)

    for_each_band(rows, max(1, _PIXELS_AT_ONCE // cols), fill)
    return out


def _shrunk_size(matrix: Float64, shape: tuple[int, ...]) -> tuple[int, int]:
    """Return the rows and columns to average down to before interpolation."""
    across, down = (float(np.linalg.norm(matrix[:, axis])) for axis in range(2))
    rows, cols = shape
    return max(1, round(rows * min(down, 1.0))), max(1, round(cols * min(across, 1.0)))


def _has_whole_edges(matrix: Float64, shape: tuple[int, ...]) -> bool:
    """Whether the edges of the picture fall between pixels of the canvas, as after resizing."""
    linear = matrix[:, :2]
    upright = min(np.abs(np.diag(linear)).max(), np.abs(np.diag(linear[::-1])).max()) < _EXACT
    corners = np.column_stack([matrix[:, 2], linear @ [shape[1], shape[0]] + matrix[:, 2]])
    return bool(upright and np.abs(corners - np.round(corners)).max() < _WHOLE)
