"""Find the words and lines of a text with a few array operations, and read numbers from chosen words."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Mask
from nmaptool.io.meshes.polygons import Integers

_BLOCK = 1 << 20  # bytes per block, few enough for the arrays of a block to stay in the cache
_FORTRAN = re.compile(rb"(?<=[\d.])[dD](?=[-+]?\d)")
_ODD_NAN = re.compile(rb"[-+]?1\.#(?:QNAN|SNAN|IND|INF)\w*", re.IGNORECASE)
_LARGEST = np.iinfo(np.int64).max


@dataclass(frozen=True)
class Words:
    """The positions of the words in a text. Blanks are spaces, tabs, line feeds, vertical tabs and form feeds.

    Attributes
    ----------
    data : (B,) uint8
        The text, with a line feed added before and after it.
    begin, end : (W,) int64
        Where each word begins in ``data``, and the byte after its last.
    first : (L,) int64
        Index of the first word of each line that has words.
    count : (L,) int64
        Number of words on each of these lines.
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
        blank = (data == ord(" ")) | ((data - ord("\t")) <= 3)  # codes below a tab wrap round
        edges = np.flatnonzero(blank[1:] != blank[:-1]) + 1
        begin, end = edges[::2], edges[1::2]
        before = np.searchsorted(begin, np.flatnonzero(data == ord("\n")))
        count = np.diff(before)
        filled = count > 0
        return cls(data, begin, end, before[:-1][filled], count[filled])

    def starts_with(self, letter: bytes) -> Mask:
        """(L,) bool: whether the first word of each line is just this letter."""
        begin = self.begin[self.first]
        return np.asarray((self.data[begin] == ord(letter)) & (self.end[self.first] == begin + 1))

    def of_lines(self, lines: Mask, skip: int) -> tuple[Integers, Integers]:
        """Indices of the words on the chosen lines after the first ``skip`` of each, and how many each line keeps."""
        left = np.maximum(self.count[lines] - skip, 0)
        return runs(self.first[lines] + skip, left), left

    def cut(self, begin: Integers, end: Integers) -> bytes:
        """The bytes from each ``begin`` to its ``end``, with blanks between; the ranges are in order and disjoint."""
        if not len(begin):
            return b""
        kept = self.data[begin[0] : end[-1]].copy()
        kept[runs(end[:-1] - begin[0], begin[1:] - end[:-1])] = ord(" ")
        return kept.tobytes()

    def until(self, mark: bytes, begin: Integers) -> Integers:
        """The position of the first mark at or after each ``begin``, or the end of the text."""
        marks = np.append(np.flatnonzero(self.data == ord(mark)), len(self.data))
        return np.asarray(marks[np.searchsorted(marks, begin)])


def runs(first: Integers, count: Integers) -> Integers:
    """The numbers ``first``, ``first + 1``, ... of each run, ``count`` of them, run by run.

    Examples
    --------
    >>> runs(np.array([5, 20]), np.array([3, 2])).tolist()
    [5, 6, 7, 20, 21]
    """
    behind = np.cumsum(count)
    return np.asarray(np.arange(behind[-1] if len(behind) else 0) + np.repeat(first - (behind - count), count))


def numbers(text: bytes, dtype: type[np.generic], count: int | None = None) -> NDArray[Any]:
    """Read numbers that are separated by blanks.

    Parameters
    ----------
    text : bytes
    dtype : type
        ``np.float64``, which accepts ``nan``, ``inf`` and the numbers of `plain_numbers`, or ``np.int64``.
    count : int, optional
        Required number of numbers.

    Returns
    -------
    (N,) of dtype

    Raises
    ------
    ValueError
        If a word is not such a number, an integer is too large, or the number of words is not ``count``.
    """
    text = text.strip()
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)  # NumPy 1 warns when it stops at a word
        try:
            found = np.fromstring(text, dtype, sep=" ") if text else np.zeros(0, dtype)
        except (DeprecationWarning, ValueError):
            plain = plain_numbers(text) if dtype is np.float64 else text
            if plain == text:
                raise ValueError from None
            return numbers(plain, dtype, count)
    too_large = dtype is np.int64 and len(found) and (found.max() == _LARGEST or found.min() < -_LARGEST)
    if too_large or (count is not None and len(found) != count):
        raise ValueError
    return found


def plain_numbers(text: bytes) -> bytes:
    """Numbers as C reads them: Fortran writes ``1.0D+02`` and old C libraries of Windows ``1.#QNAN`` and ``-1.#IND00``.

    >>> plain_numbers(b"1.0D+02 -1.#IND00")
    b'1.0e+02 nan'
    """
    return _ODD_NAN.sub(b"nan", _FORTRAN.sub(b"e", text))


def line_feeds(data: bytes) -> bytes:
    """The text with line feeds as line ends."""
    return data.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in data else data


def blocks(text: bytes, mark: bytes = b"\n") -> Iterator[bytes]:
    """Split a long text into at least one block; each but the last ends with a mark."""
    start = 0
    while len(text) - start > _BLOCK:
        place = text.rfind(mark, start, start + _BLOCK)
        place = text.find(mark, start) if place < 0 else place
        if place < 0:
            break
        yield text[start : place + len(mark)]
        start = place + len(mark)
    yield text[start:]
