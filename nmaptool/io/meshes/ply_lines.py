"""Rows of a text PLY that hold more values than its header declares, line by line."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from nmaptool.io.meshes.polygons import Integers
from nmaptool.io.meshes.words import Words, line_feeds, numbers, runs


class _Property(Protocol):
    @property
    def is_list(self) -> bool: ...


class _Element(Protocol):
    @property
    def name(self) -> str: ...
    @property
    def rows(self) -> int: ...
    @property
    def properties(self) -> Sequence[_Property]: ...


def declared_values(elements: Sequence[_Element], text: bytes, line: int) -> tuple[bytes, tuple[str, ...]]:
    """Keep the values at the beginning of each line that the header declares.

    Parameters
    ----------
    elements : sequence
        In the order of the header.
    text : bytes
        The data, each row on a line of its own.
    line : int
        Number of the line before the data.

    Returns
    -------
    text : bytes
        The values that are declared.
    notes : tuple of str
        What was ignored.

    Raises
    ------
    ValueError
        If there are more or fewer lines than rows, or a line has too few values.
    """
    words = Words.of(line_feeds(text))
    if len(words.first) != sum(e.rows for e in elements):
        raise ValueError
    used = np.zeros(len(words.first), np.int64)
    notes = []
    row = 0
    for element in elements:
        part = slice(row, row + element.rows)
        row += element.rows
        used[part] = _used(element, words, words.first[part], words.count[part])
        surplus = words.count[part] - used[part]
        if (surplus > 0).any():
            place = int(np.flatnonzero(surplus > 0)[0])
            filled = np.flatnonzero(np.diff(np.searchsorted(words.begin, np.flatnonzero(words.data == ord("\n")))) > 0)
            where = line + int(filled[part.start + place]) + 1
            notes.append(
                f"rows of its element {element.name} hold up to {surplus.max()} values more than the header declares, "
                f"first in line {where}; they were ignored"
            )
    chosen = runs(words.first, used)
    return words.cut(words.begin[chosen], words.end[chosen]), tuple(notes)


def _used(element: _Element, words: Words, first: Integers, count: Integers) -> Integers:
    """Number of values that each row of an element should have."""
    used = np.zeros(len(first), np.int64)
    for prop in element.properties:
        if prop.is_list:
            if (used >= count).any():
                raise ValueError
            place = first + used
            length = numbers(words.cut(words.begin[place], words.end[place]), np.int64, len(place))
            if (length < 0).any():
                raise ValueError
            used = used + length
        used = used + 1
        if (used > count).any():
            raise ValueError
    return used
