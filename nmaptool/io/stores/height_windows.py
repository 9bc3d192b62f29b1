"""Heights larger than memory, read by windows: their range, and windows as height fields."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Float64, Mask
from nmaptool.core.errors import InputError
from nmaptool.core.grid import touching_vertices
from nmaptool.core.progress import Progress
from nmaptool.io.pictures.height_samples import to_vertices
from nmaptool.solids.cutting.plan import surface_box
from nmaptool.types.height import Height
from nmaptool.types.picture import Frame

# heights that are read at once: as many rows as the chunks of a store have
_BLOCK_ROWS, _BLOCK_COLS = 512, 16384
# alpha of a corner whose pixel to the lower right is not surface, as in `nmaptool.io.pictures.height_samples`
_CORNER_ONLY = np.float32(0.5)
# pixels around a window that the heights of its corners depend on, where the source has heights at centres
_MARGIN_PX = 2


class HeightSource(Protocol):
    """Heights in mm, NaN outside the surface.

    Attributes
    ----------
    rows, cols : int
        Of the stored heights.
    pitch_mm : float
    at : str
        "centers" of the pixels, or their "corners", one more down and across.
    """

    @property
    def rows(self) -> int:
        """Rows of stored heights."""

    @property
    def cols(self) -> int:
        """Columns of stored heights."""

    @property
    def pitch_mm(self) -> float:
        """Millimetres per pixel."""

    @property
    def at(self) -> str:
        """Where they lie."""

    def window(self, rows: slice, cols: slice) -> NDArray[np.floating[Any]]:
        """(h, w) heights in mm; both ends of the slices are given."""


@dataclass(frozen=True, eq=False)
class ArrayHeights:
    """Heights in an array, which may be memory-mapped.

    Parameters
    ----------
    z_mm : (h, w) float
        NaN outside the surface.
    pitch_mm : float
    at : str
    """

    z_mm: NDArray[np.floating[Any]]
    pitch_mm: float
    at: str = "centers"

    @property
    def rows(self) -> int:
        """Rows of the array."""
        return int(self.z_mm.shape[0])

    @property
    def cols(self) -> int:
        """Columns of the array."""
        return int(self.z_mm.shape[1])

    def window(self, rows: slice, cols: slice) -> NDArray[np.floating[Any]]:
        """As `HeightSource.window`."""
        return np.asarray(self.z_mm[rows, cols])


@dataclass(frozen=True)
class HeightRange:
    """What is known of heights once all of them were seen.

    Attributes
    ----------
    low_mm, high_mm : float
    has_gaps : bool
        Whether some places do not belong to the surface.
    box : (slice, slice) or None
        The rows and columns of pixels that hold all of the surface; None if that is not known.
    """

    low_mm: float
    high_mm: float
    has_gaps: bool
    box: tuple[slice, slice] | None = None


def frame_of(source: HeightSource) -> Frame:
    """The pixels of the surface that a source describes.

    Raises
    ------
    InputError
        If there are fewer than 2 x 2 corners.
    """
    less = 1 if source.at == "corners" else 0
    if min(source.rows, source.cols) <= less:
        raise InputError(f"the heights are {source.cols} x {source.rows} corners; at least 2 x 2 are needed")
    return Frame(source.rows - less, source.cols - less, source.pitch_mm)


def blocks(source: HeightSource, side: int = _BLOCK_ROWS) -> Iterator[tuple[slice, slice]]:
    """Windows that cover all heights, row by row: each of ``side`` rows, and of columns in multiples of ``side``."""
    across = max(1, _BLOCK_COLS // side) * side
    for top in range(0, source.rows, side):
        for left in range(0, source.cols, across):
            yield slice(top, min(top + side, source.rows)), slice(left, min(left + across, source.cols))


def range_of(source: HeightSource, progress: Progress | None = None) -> HeightRange:
    """Read all heights once, block by block, and find their range.

    Raises
    ------
    InputError
        If no height is finite, or one is infinite.
    """
    low, high, has_gaps = np.inf, -np.inf, False
    for rows, cols in blocks(source):
        z_mm = source.window(rows, cols)
        if np.isinf(z_mm).any():
            raise InputError("the heights hold infinite values; use NaN for what is not surface")
        known = ~np.isnan(z_mm)
        has_gaps = has_gaps or not known.all()
        low = min(low, float(z_mm.min(initial=np.inf, where=known)))
        high = max(high, float(z_mm.max(initial=-np.inf, where=known)))
        if progress is not None:
            progress("range", rows.stop / source.rows)
    if low > high:
        raise InputError("the heights hold no surface: all of them are NaN")
    return HeightRange(low, high, has_gaps)


def samples_of(
    source: HeightSource, rows: slice, cols: slice, *, has_gaps: bool
) -> tuple[NDArray[np.floating[Any]], Float32 | None]:
    """A window of heights as files hold them: 0 outside the surface, with alpha.

    Parameters
    ----------
    source : HeightSource
    rows, cols : slice
    has_gaps : bool
        Whether files of this source have alpha.

    Returns
    -------
    z_mm : (h, w) float
    alpha : (h, w) float32 or None
        1 on the surface, 0 outside. For heights at corners 0.5 where the pixel to the lower right is not surface.
    """
    if not has_gaps:
        return source.window(rows, cols), None
    if source.at != "corners":
        z_mm = source.window(rows, cols)
        known = ~np.isnan(z_mm)
        return np.where(known, z_mm, 0), known.astype(np.float32)
    end_row, end_col = min(rows.stop + 1, source.rows), min(cols.stop + 1, source.cols)
    wide = source.window(slice(rows.start, end_row), slice(cols.start, end_col))
    domain = np.zeros(wide.shape, bool)
    domain[:-1, :-1] = surface_between(wide)
    height, width = rows.stop - rows.start, cols.stop - cols.start
    z_mm, known = wide[:height, :width], ~np.isnan(wide[:height, :width])
    alpha = np.where(domain[:height, :width], np.float32(1), np.where(known, _CORNER_ONLY, np.float32(0)))
    return np.where(known, z_mm, 0), alpha


def surface_between(z_mm: NDArray[np.floating[Any]]) -> Mask:
    """(h-1, w-1) bool: pixels whose four corners have heights."""
    known = ~np.isnan(z_mm)
    inside: Mask = known[:-1, :-1] & known[:-1, 1:] & known[1:, :-1] & known[1:, 1:]
    return inside


def height_window(source: HeightSource, rows: slice, cols: slice) -> Height | None:
    """A window of pixels as a height field.

    The height of a vertex depends only on heights near to it, so windows that overlap agree. Heights at corners are
    taken as they are: a pixel is surface if all its corners are. From heights at centres, corners are means of
    neighbours, extrapolated linearly at the edges.

    Parameters
    ----------
    source : HeightSource
    rows, cols : slice
        Pixels.

    Returns
    -------
    Height or None
        None if no pixel of the window is surface.
    """
    shape = (rows.stop - rows.start, cols.stop - cols.start)
    if min(shape) < 1:
        return None
    if source.at == "corners":
        z_mm = source.window(slice(rows.start, rows.stop + 1), slice(cols.start, cols.stop + 1)).astype(np.float64)
        domain = surface_between(z_mm)
    else:
        top, left = max(rows.start - _MARGIN_PX, 0), max(cols.start - _MARGIN_PX, 0)
        bottom, right = min(rows.stop + _MARGIN_PX, source.rows), min(cols.stop + _MARGIN_PX, source.cols)
        centre = source.window(slice(top, bottom), slice(left, right)).astype(np.float64)
        down, across = rows.start - top, cols.start - left
        domain = ~np.isnan(centre[down : down + shape[0], across : across + shape[1]])
        vertices = to_vertices(_filled(centre))
        z_mm = vertices[down : down + shape[0] + 1, across : across + shape[1] + 1]
    if not domain.any():
        return None
    z_mm = np.where(touching_vertices(domain), z_mm, 0.0)
    return Height(z_mm, domain, Frame(*shape, source.pitch_mm))


def _filled(centre: Float64) -> Float64:
    """Heights beside the surface continued: each is the mean of what lines through two neighbours say, or of them."""
    known = ~np.isnan(centre)
    if known.all():
        return centre
    rows, cols = centre.shape
    z_mm, has = np.pad(centre, 2, constant_values=np.nan), np.pad(known, 2)
    sums, counts = np.zeros((2, rows, cols)), np.zeros((2, rows, cols))

    def at(down: int, right: int) -> tuple[slice, slice]:
        return slice(2 + down, 2 + down + rows), slice(2 + right, 2 + right + cols)

    for down, right in itertools.product((-1, 0, 1), repeat=2):
        near, far = at(down, right), at(2 * down, 2 * right)
        for order, usable in enumerate((has[near] & has[far], has[near])):
            line = 2 * z_mm[near] - z_mm[far] if order == 0 else z_mm[near]
            sums[order][usable] += line[usable]
            counts[order] += usable
    with np.errstate(invalid="ignore", divide="ignore"):
        lines, neighbours = sums / counts
    filled = np.where(counts[0] > 0, lines, np.where(counts[1] > 0, neighbours, 0.0))
    return np.where(known, centre, filled)


def surface_range(source: HeightSource, progress: Progress | None = None) -> HeightRange:
    """The range of the surface's corners, which a base is measured from: as `range_of` for heights at corners.

    Raises
    ------
    InputError
        As `range_of`, or if no pixel is surface.
    """
    found = range_of(source, progress)
    if source.at == "corners" and not found.has_gaps:
        return found
    low, high, frame = np.inf, -np.inf, frame_of(source)
    ends = np.array([[frame.rows, frame.cols], [0, 0]])
    for rows, cols in blocks(source):
        window = height_window(
            source, slice(rows.start, min(rows.stop, frame.rows)), slice(cols.start, min(cols.stop, frame.cols))
        )
        if window is not None:
            low, high = min(low, window.range_mm[0]), max(high, window.range_mm[1])
            down, across = surface_box(window.domain)
            ends[0] = np.minimum(ends[0], [rows.start + down.start, cols.start + across.start])
            ends[1] = np.maximum(ends[1], [rows.start + down.stop, cols.start + across.stop])
    if low > high:
        raise InputError("the heights hold no surface: no pixel has heights at all its corners")
    (top, left), (bottom, right) = ends.tolist()
    return HeightRange(low, high, found.has_gaps, (slice(top, bottom), slice(left, right)))
