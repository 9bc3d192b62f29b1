"""Sparse matrices by rows: the couplings of off-grid vertices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

import nmaptool.kernels.row_twins as row_twins
from nmaptool import kernels
from nmaptool.kernels.grid_twins import Values

Places = NDArray[np.int64]


def _loops_for(dtype: DTypeLike) -> Any:
    return kernels if np.dtype(dtype) == np.float32 else row_twins


@dataclass(frozen=True, eq=False)
class Rows:
    """A sparse matrix.

    Attributes
    ----------
    start : (rows + 1,) int64
        Where the entries of each row begin.
    column : (n,) int64
    value : (n,)
    count : int
        Number of columns.
    """

    start: Places
    column: Places
    value: Values
    count: int

    def __len__(self) -> int:
        return len(self.start) - 1

    @cached_property
    def row(self) -> Places:
        """The (n,) row of each entry."""
        return np.repeat(np.arange(len(self)), np.diff(self.start))

    def transposed(self) -> Rows:
        """Return the transpose."""
        return from_entries(self.column, self.row, self.value, (self.count, len(self)))

    def times(self, x: Values) -> Values:
        """Return the (rows,) product with ``x`` (columns,)."""
        out = np.empty(len(self), self.value.dtype)
        _loops_for(self.value.dtype).rows_times(self.start, self.column, self.value, x, out)
        return out

    def sums(self) -> Values:
        """Return the (rows,) sums of the rows."""
        return self.times(np.ones(self.count, self.value.dtype))

    def product(self, other: Rows) -> Rows:
        """Return the product of two matrices."""
        room = int(np.diff(other.start)[self.column].sum())
        start, column = np.empty(len(self) + 1, np.int64), np.empty(room, np.int64)
        value = np.empty(room, self.value.dtype)
        found = _loops_for(value.dtype).rows_product(
            *(self.start, self.column, self.value),
            *(other.start, other.column, other.value),
            other.count,
            *(start, column, value),
        )
        return Rows(start, column[: int(found)], value[: int(found)], other.count)

    def where(self, keep: NDArray[np.bool_]) -> Rows:
        """Return the matrix with only some entries, (n,) bool."""
        start = np.concatenate([[0], np.cumsum(keep)])[self.start]
        return Rows(start, self.column[keep], self.value[keep], self.count)


def from_entries(row: Places, column: Places, value: Values, shape: tuple[int, int]) -> Rows:
    """Return the matrix with these entries, each place at most once for `Rows.times`."""
    start, columns, values = np.empty(shape[0] + 1, np.int64), np.empty(len(row), np.int64), np.empty_like(value)
    _loops_for(value.dtype).sort_rows(row, column, value, start, columns, values)
    return Rows(start, columns, values, shape[1])


def below_each_other(parts: Sequence[Rows], count: int) -> Rows:
    """Return the rows of several matrices, one after the other, with ``count`` columns."""
    offsets = np.cumsum([0, *(len(part.column) for part in parts)])
    starts = [part.start[:-1] + offset for part, offset in zip(parts, offsets, strict=False)]
    return Rows(
        np.concatenate([*starts, offsets[-1:]]),
        np.concatenate([part.column for part in parts]),
        np.concatenate([part.value for part in parts]),
        count,
    )


def identity(count: int, dtype: DTypeLike) -> Rows:
    """Return the identity."""
    return Rows(np.arange(count + 1), np.arange(count), np.ones(count, dtype), count)


def none(rows: int, count: int, dtype: DTypeLike) -> Rows:
    """Return a matrix without entries."""
    return Rows(np.zeros(rows + 1, np.int64), np.zeros(0, np.int64), np.zeros(0, dtype), count)
