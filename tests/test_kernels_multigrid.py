"""The compiled loops that make the levels of the multigrid solver, and their twins in NumPy."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from nmaptool import kernels
from nmaptool.kernels import coarsening, row_twins
from nmaptool.solver.multigrid import rows as sparse

needs_compiler = pytest.mark.skipif(not kernels.IS_COMPILED, reason="built without a C compiler")
# one block, many blocks, and sides that are not multiples of anything
SHAPES = [(7, 5), (61, 45), (103, 301), (131, 260)]


def links(random, shape, down, across, share):
    """A field of couplings in one direction, none of which leaves the grid."""
    rows, cols = shape
    values = random.random(shape) * (random.random(shape) < share)
    values[rows - down :] = 0
    values[:, cols - across if across > 0 else cols :] = 0
    values[:, : -across if across < 0 else 0] = 0
    return np.pad(values.ravel(), cols + 1).astype(np.float32)


def results(shape, back):
    rows, cols = shape
    coarse = (rows + 1) // 2, (cols + 1) // 2
    fields = [np.zeros(coarse[0] * coarse[1] + 2 * (coarse[1] + 1), np.float32) for _ in range(13)]
    return (*fields, *(np.zeros(rows * cols, np.float32) for _ in range(back)))


def coarsened(loop, inputs, shape, back=0, after=(), bands=1):
    """Results of a loop, called once for each of some bands."""
    out = results(shape, back)
    edges = np.linspace(0, (shape[0] + 1) // 2, bands + 1).astype(int)
    for first, last in pairwise(edges):
        loop(inputs, out, *shape, int(first), int(last), *after)
    return out


@needs_compiler
@pytest.mark.parametrize("holds", [False, True])
@pytest.mark.parametrize("shape", SHAPES)
def test_coarsening_the_finest_level_matches_its_twin(shape, holds):
    random = np.random.default_rng(3)
    size = shape[0] * shape[1]
    beta = (random.random(size) * (random.random(size) < 0.3)).astype(np.float32)
    inputs = (links(random, shape, 1, 1, 0.9), beta, random.random(size) < 0.8)
    found = coarsened(kernels.coarsen_finest, inputs, shape, after=(holds,))
    expected = coarsened(coarsening.coarsen_finest, inputs, shape, after=(holds,))
    for one, two in zip(found, expected, strict=True):
        assert np.allclose(one, two, rtol=0, atol=5e-6)
        assert two.any()
    banded = coarsened(kernels.coarsen_finest, inputs, shape, after=(holds,), bands=3)
    assert all(np.array_equal(one, two) for one, two in zip(found, banded, strict=True))


@needs_compiler
@pytest.mark.parametrize("has_off_grid", [False, True])
@pytest.mark.parametrize("shape", SHAPES)
def test_coarsening_a_coarse_level_matches_its_twin(shape, has_off_grid):
    random = np.random.default_rng(4)
    size = shape[0] * shape[1]
    couplings = [links(random, shape, down, across, 0.6) for down, across in ((0, 1), (1, 0), (1, 1), (1, -1))]
    out = (random.random(size) * (random.random(size) < 0.1)).astype(np.float32)
    inputs = (*couplings, links(random, shape, 0, 0, 0.1), out if has_off_grid else out[:0])
    found = coarsened(kernels.coarsen_coarse, inputs, shape, back=4)
    expected = coarsened(coarsening.coarsen_coarse, inputs, shape, back=4)
    for one, two in zip(found[:13], expected[:13], strict=True):
        assert np.allclose(one, two, rtol=0, atol=5e-6)
    stray, scale, lack, rest = (pair for pair in zip(found[13:], expected[13:], strict=True))
    assert np.array_equal(*stray)
    assert stray[0].any()
    # an isolated vertex has no couplings to scale
    linked = expected[14] < 1e30
    assert np.allclose(scale[0][linked], scale[1][linked], rtol=1e-5)
    assert np.allclose(*lack, atol=1e-5)
    assert np.allclose(*rest, atol=5e-6)


@needs_compiler
def test_blocks_without_couplings_are_left_alone():
    """Weights of a motif in one corner of a large grid: what is far from it stays as it was."""
    shape = (300, 300)
    quarter = np.zeros(shape, np.float32)
    quarter[10:60, 20:70] = 1
    inputs = np.pad(quarter.ravel(), shape[1] + 1), np.zeros(shape[0] * shape[1], np.float32), np.ones(90000, bool)
    found = results(shape, 0)
    for each in found:
        each[:] = 7
    kernels.coarsen_finest(inputs, found, *shape, 0, 150, False)
    first = found[0][151 : 151 + 150 * 150].reshape(150, 150)
    assert (first[60:, 80:] == 7).all()
    assert (first[10:24, 15:30] == 0.5).all()


def random_rows(random, rows, cols, share=0.1):
    """A sparse matrix and the same as an array; a row and a column are empty."""
    full = (random.random((rows, cols)) * (random.random((rows, cols)) < share)).astype(np.float32)
    full[2] = full[:, 1] = 0
    row, column = np.nonzero(full)
    order = random.permutation(len(row))
    row, column = row[order], column[order]
    return sparse.from_entries(row, column, full[row, column], full.shape), full


def dense(matrix):
    out = np.zeros((len(matrix), matrix.count), np.float32)
    np.add.at(out, (matrix.row, matrix.column), matrix.value)
    return out


@pytest.mark.parametrize("compiled", [pytest.param(True, marks=needs_compiler), False])
def test_sparse_matrices_compute_like_full_ones(compiled, monkeypatch):
    if not compiled:
        monkeypatch.setattr(sparse, "kernels", row_twins)
    random = np.random.default_rng(5)
    (one, full), (two, other) = random_rows(random, 40, 23), random_rows(random, 23, 31)
    assert np.array_equal(dense(one), full)
    assert np.array_equal(dense(one.transposed()), full.T)
    x = random.random(23).astype(np.float32)
    assert np.allclose(one.times(x), full @ x, rtol=1e-5)
    assert np.allclose(one.sums(), full.sum(axis=1), rtol=1e-5)
    product = one.product(two)
    assert np.allclose(dense(product), full @ other, rtol=1e-5)
    assert len(set(zip(product.row, product.column, strict=True))) == len(product.row)
    stacked = sparse.below_each_other([one, sparse.identity(23, np.float32), sparse.none(3, 23, np.float32)], 23)
    assert np.array_equal(dense(stacked), np.vstack([full, np.eye(23), np.zeros((3, 23))]))
    assert np.array_equal(dense(one.where(one.value > 0.5)), full * (full > 0.5))


@needs_compiler
def test_entries_outside_a_matrix_are_refused():
    matrix = sparse.identity(4, np.float32)
    out = np.empty(4, np.float32)
    with pytest.raises(ValueError, match="sizes of the arrays do not match"):
        kernels.rows_times(matrix.start, matrix.column + 1, matrix.value, out, out)
    with pytest.raises(ValueError, match="sizes of the arrays do not match"):
        kernels.rows_times(matrix.start[::-1].copy(), matrix.column, matrix.value, out, out)
    with pytest.raises(ValueError, match="number of arrays does not match"):
        kernels.coarsen_finest((out,), (out,), 2, 2, 0, 1, False)
    wide = sparse.Rows(matrix.start, matrix.column + 2, matrix.value, 6)
    with pytest.raises(ValueError, match="sizes of the arrays do not match"):
        kernels.rows_product(
            *(matrix.start, matrix.column, matrix.value, matrix.start, wide.column, wide.value, 4),
            *(np.empty(5, np.int64), np.empty(4, np.int64), np.empty(4, np.float32)),
        )
