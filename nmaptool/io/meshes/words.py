"""Words and lines of a text found with a few array operations, and numbers read from chosen words."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Mask
from nmaptool.io.meshes.polygons import Integers

_BLOCK = 1 << 20  # bytes looked at in one go: what is worked out for them stays in the cache
_LARGEST = np.iinfo(np.int64).max


@dataclass(frozen=True)
class Words:
    """Where the words of a text are. Blanks are spaces, tabs, line feeds, vertical tabs and form feeds.

    Attributes
    ----------
    data : (B,) uint8
        The text between two line feeds.
    begin, end : (W,) int64
        Where each word begins in ``data``, and the byte after its last.
    first : (L,) int64
        Number of the first word of each line that holds any.
    count : (L,) int64
        How many words each of these lines holds.
    """

    data: NDArray[np.uint8]
    begin: Integers
    end: Integers
    first: Integers
    count: Integers

    @classmethod
    def of(cls, text: bytes) -> Words:
        """Find the words of a text whose lines end with a line feed."""
        data = np.frombuffer(b"\n%b\n" % text, np.uint8)
        blank = (data == ord(" ")) | ((data - ord("\t")) <= 3)  # less than a tab wraps round
        edges = np.flatnonzero(blank[1:] != blank[:-1]) + 1
        begin, end = edges[::2], edges[1::2]
        before = np.searchsorted(begin, np.flatnonzero(data == ord("\n")))
        count = np.diff(before)
        filled = count > 0
        return cls(data, begin, end, before[:-1][filled], count[filled])

    def starts_with(self, letter: bytes) -> Mask:
        """(L,) bool: whether the first word of a line is this one letter."""
        begin = self.begin[self.first]
        return np.asarray((self.data[begin] == ord(letter)) & (self.end[self.first] == begin + 1))

    def of_lines(self, lines: Mask, skip: int) -> tuple[Integers, Integers]:
        """Numbers of the words on some lines, without the first ``skip`` of each, and how many are left of each."""
        left = np.maximum(self.count[lines] - skip, 0)
        return runs(self.first[lines] + skip, left), left

    def cut(self, begin: Integers, end: Integers) -> bytes:
        """The bytes from each ``begin`` to each ``end``, with blanks for all between; in order, none within another."""
        if not len(begin):
            return b""
        kept = self.data[begin[0] : end[-1]].copy()
        kept[runs(end[:-1] - begin[0], begin[1:] - end[:-1])] = ord(" ")
        return kept.tobytes()

    def until(self, mark: bytes, begin: Integers) -> Integers:
        """Where the next mark stands at or behind each ``begin``; the end of the text if there is none."""
        marks = np.append(np.flatnonzero(self.data == ord(mark)), len(self.data))
        return np.asarray(marks[np.searchsorted(marks, begin)])


def runs(first: Integers, count: Integers) -> Integers:
    """The numbers ``first``, ``first + 1``, ... of each run, ``count`` of them, one run after the other.

    Examples
    --------
    >>> runs(np.array([5, 20]), np.array([3, 2])).tolist()
    [5, 6, 7, 20, 21]
    """
    behind = np.cumsum(count)
    return np.asarray(np.arange(behind[-1] if len(behind) else 0) + np.repeat(first - (behind - count), count))


def numbers(text: bytes, dtype: type[np.generic], count: int | None = None) -> NDArray[Any]:
    """Numbers with blanks between.

    Parameters
    ----------
    text : bytes
    dtype : type
        ``np.float64``, which may be ``nan`` and ``inf``, or ``np.int64``.
    count : int, optional
        How many there must be.

    Returns
    -------
    (N,) of dtype

    Raises
    ------
    ValueError
        If a word is no such number, an integer is too large, or there are not ``count``.
    """
    text = text.strip()
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)  # NumPy 1's way of saying that it stopped at a word
        try:
            found = np.fromstring(text, dtype, sep=" ") if text else np.zeros(0, dtype)
        except DeprecationWarning:
            raise ValueError from None
    too_large = dtype is np.int64 and len(found) and (found.max() == _LARGEST or found.min() < -_LARGEST)
    if too_large or (count is not None and len(found) != count):
        raise ValueError
    return found


def line_feeds(data: bytes) -> bytes:
    """A text with line feeds for all its line ends, and without a byte order mark."""
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return data.removeprefix(b"\xef\xbb\xbf")


def blocks(text: bytes, mark: bytes = b"\n") -> Iterator[bytes]:
    """Pieces of a long text, at least one, each but the last cut behind a mark."""
    start = 0
    while len(text) - start > _BLOCK:
        place = text.rfind(mark, start, start + _BLOCK)
        place = text.find(mark, start) if place < 0 else place
        if place < 0:
            break
        yield text[start : place + len(mark)]
        start = place + len(mark)
    yield text[start:]
