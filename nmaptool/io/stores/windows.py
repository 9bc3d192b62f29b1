"""Windows of pictures: their bounds, and the blocks of a regular grid that they cut."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from nmaptool.core.errors import UsageError


class Piece(NamedTuple):
    """The part of a window that lies in one block of a grid.

    Attributes
    ----------
    block : (int, int)
        Row and column of the block in the grid.
    inside : (slice, slice)
        The part in the block.
    window : (slice, slice)
        The part in the window.
    """

    block: tuple[int, int]
    inside: tuple[slice, slice]
    window: tuple[slice, slice]


def bounds(name: str, rows: slice, cols: slice, shape: tuple[int, int]) -> tuple[slice, slice]:
    """Check a window of a picture.

    Parameters
    ----------
    name : str
        Of the picture, for messages.
    rows, cols : slice
        Without a step; None means the edge of the picture.
    shape : (int, int)
        Of the picture.

    Returns
    -------
    (slice, slice)
        With both ends set.

    Raises
    ------
    UsageError
        If it is empty or does not lie in the picture.
    """
    found = []
    for part, size in zip((rows, cols), shape, strict=True):
        first, end = 0 if part.start is None else part.start, size if part.stop is None else part.stop
        if part.step not in (None, 1) or not 0 <= first < end <= size:
            raise UsageError(
                f"{name}: the window of rows {rows.start} to {rows.stop} and columns {cols.start} to {cols.stop} does "
                f"not lie in a picture of {shape[1]} x {shape[0]}"
            )
        found.append(slice(first, end))
    return found[0], found[1]


def widened(window: tuple[slice, slice], margin: int, shape: tuple[int, int]) -> tuple[slice, slice]:
    """A window with a margin on all sides, as far as the picture reaches.

    >>> widened((slice(0, 8), slice(4, 8)), 2, (20, 9))
    (slice(0, 10, None), slice(2, 9, None))
    """
    rows, cols = (
        slice(max(0, part.start - margin), min(size, part.stop + margin))
        for part, size in zip(window, shape, strict=True)
    )
    return rows, cols


def within(inner: tuple[slice, slice], outer: tuple[slice, slice]) -> tuple[slice, slice]:
    """The place of a window in another that holds it.

    >>> within((slice(5, 8), slice(4, 6)), (slice(3, 9), slice(4, 8)))
    (slice(2, 5, None), slice(0, 2, None))
    """
    rows, cols = (
        slice(part.start - around.start, part.stop - around.start) for part, around in zip(inner, outer, strict=True)
    )
    return rows, cols


def pieces(window: tuple[slice, slice], block: tuple[int, int]) -> Iterator[Piece]:
    """The parts of a window in the blocks of a grid that begins at the picture's corner.

    Parameters
    ----------
    window : (slice, slice)
    block : (int, int)
        Rows and columns of a block.
    """
    rows, cols = window
    for row in range(rows.start // block[0], -(-rows.stop // block[0])):
        top, bottom = max(rows.start, row * block[0]), min(rows.stop, (row + 1) * block[0])
        for col in range(cols.start // block[1], -(-cols.stop // block[1])):
            left, right = max(cols.start, col * block[1]), min(cols.stop, (col + 1) * block[1])
            yield Piece(
                (row, col),
                (
                    slice(top - row * block[0], bottom - row * block[0]),
                    slice(left - col * block[1], right - col * block[1]),
                ),
                (slice(top - rows.start, bottom - rows.start), slice(left - cols.start, right - cols.start)),
            )


def grid_windows(shape: tuple[int, int], block: tuple[int, int]) -> Iterator[tuple[slice, slice]]:
    """The windows of a grid that cover a picture, row by row; those at the edge may be smaller."""
    for row in range(0, shape[0], block[0]):
        for col in range(0, shape[1], block[1]):
            yield slice(row, min(row + block[0], shape[0])), slice(col, min(col + block[1], shape[1]))
