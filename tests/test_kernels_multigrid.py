"""The compiled loops that make the levels of the multigrid solver, and their twins in NumPy."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from nmaptool import kernels
from nmaptool.kernels import coarsening, profile_twins, row_twins, sweep_twins
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


def finest_fields(random, shape):
    """Quarters, steps, a residual, beta, unknown vertices and the weights of an interpolation."""
    rows, cols = shape
    size = rows * cols
    quarter = links(random, shape, 1, 1, 0.9)
    step, residual, beta = (random.normal(size=(3, size))).astype(np.float32)
    coarse = (rows + 1) // 2, (cols + 1) // 2
    ways = coarsened(coarsening.coarsen_finest, (quarter, beta**2, np.ones(size, bool)), shape, after=(False,))[:8]
    x = np.pad(random.normal(size=coarse[0] * coarse[1]), coarse[1] + 1).astype(np.float32)
    return quarter, np.abs(step), residual, beta, random.random(size) < 0.8, ways, x


@needs_compiler
@pytest.mark.parametrize("bands", [1, 3])
@pytest.mark.parametrize("shape", [(2, 2), (7, 5), (8, 6), (61, 44), (40, 301)])
def test_sweeps_over_the_finest_level_match_their_twins(shape, bands):
    quarter, step, residual, _, _, ways, x = finest_fields(np.random.default_rng(6), shape)
    rows, cols = shape
    coarse = (rows + 1) // 2
    edges = np.linspace(0, coarse, bands + 1).astype(int)
    down, twin_down = np.full((2, coarse * ((cols + 1) // 2)), np.nan, np.float32)
    up, twin_up = np.full((2, rows * cols), np.nan, np.float32)
    product, expected = 0.0, 0.0
    for first, last in pairwise(map(int, edges)):
        kernels.finest_descend((quarter, step, residual), ways, (down,), rows, cols, first, last, -1 / 3)
        product += kernels.finest_ascend((quarter, step, residual, x), ways, (up,), rows, cols, first, last, -1 / 3)
    sweep_twins.finest_descend((quarter, step, residual), ways, (twin_down,), rows, cols, 0, coarse, -1 / 3)
    expected = sweep_twins.finest_ascend((quarter, step, residual, x), ways, (twin_up,), rows, cols, 0, coarse, -1 / 3)
    assert np.allclose(down, twin_down, rtol=0, atol=2e-5)
    assert np.allclose(up, twin_up, rtol=0, atol=5e-5)
    assert product == pytest.approx(expected, rel=1e-4, abs=1e-2)
    assert np.abs(twin_up).max() > 0.1


@pytest.mark.parametrize("loops", [pytest.param(kernels, marks=needs_compiler), sweep_twins])
@pytest.mark.parametrize("holds", [False, True])
def test_a_direction_in_bands_is_that_of_the_whole(loops, holds):
    shape = rows, cols = 13, 22
    random = np.random.default_rng(7)
    quarter, _, other, beta, unknown, _, _ = finest_fields(random, shape)
    direction = np.pad(random.normal(size=rows * cols), cols + 1).astype(np.float32)
    none = np.zeros(cols + 1, np.float32)
    whole, product = direction.copy(), other.copy()
    energy = sweep_twins.finest_advance(
        (quarter, beta, unknown, none, none), (whole, product), rows, cols, 0, rows, 0.3, holds
    )
    turned = 0.3 * direction[cols + 1 : -cols - 1] + other
    assert np.allclose(whole[cols + 1 : -cols - 1], turned, atol=1e-6)
    assert energy == pytest.approx(float(turned @ product), rel=1e-4)

    def row(number):
        here = np.zeros(cols + 1, np.float32)
        here[:cols] = turned[number * cols : (number + 1) * cols]
        return here

    found, total = (direction.copy(), other.copy()), 0.0
    for first, last in ((6, 13), (0, 4), (4, 6)):  # in any order
        above, below = (row(first - 1) if first else none), (row(last) if last < rows else none)
        inputs = (quarter, beta, unknown, above, below)
        total += loops.finest_advance(inputs, found, rows, cols, first, last, 0.3, holds)
    assert np.allclose(found[0], whole, atol=1e-6)
    assert np.allclose(found[1], product, rtol=0, atol=2e-5)
    assert total == pytest.approx(energy, rel=1e-4)


@pytest.mark.parametrize("loops", [pytest.param(kernels, marks=needs_compiler), profile_twins])
def test_a_small_system_is_ordered_by_part_factored_and_solved(loops):
    """Two grids and a single unknown, numbered at random."""
    random = np.random.default_rng(8)
    name = random.permutation(6 * 9 + 4 * 5 + 1)
    ends = []
    for begin, rows, cols in ((0, 6, 9), (54, 4, 5)):
        at = begin + np.arange(rows * cols).reshape(rows, cols)
        ends += [(at[:, :-1].ravel(), at[:, 1:].ravel()), (at[:-1].ravel(), at[1:].ravel())]
    one, two = (name[np.concatenate([end[i] for end in ends])] for i in (0, 1))
    row, column = np.concatenate([one, two]), np.concatenate([two, one])
    count = len(name)
    graph = sparse.from_entries(row, column, np.ones(len(row)), (count, count))
    order, part = np.empty(count, np.int64), np.empty(count, np.int64)
    assert loops.order_graph(graph.start, graph.column, order, part) == 3
    assert np.array_equal(np.sort(order), np.arange(count))
    grids = [set(part[name[:54]]), set(part[name[54:74]]), {part[name[74]]}]
    assert all(len(each) == 1 for each in grids)
    assert len(set.union(*grids)) == 3
    assert (np.diff(np.flatnonzero(np.diff(part[order], prepend=-1))) > 0).all()
    assert len(np.flatnonzero(np.diff(part[order]))) == 2  # each part in one piece

    position = np.argsort(order)
    first = np.arange(count)
    np.minimum.at(first, position[row], position[column])
    assert (np.arange(count) - first).max() <= 12  # about the short side of the larger grid
    offset = np.concatenate([[0], np.cumsum(np.arange(count) - first + 1)])
    full = np.diag(np.bincount(row, minlength=count) + random.random(count) + 0.01)
    full[row, column] = -1
    ordered = full[np.ix_(order, order)]
    values = np.concatenate([ordered[i, first[i] : i + 1] for i in range(count)])
    assert loops.profile_factor(first, offset, values) > 0
    load = random.normal(size=count)
    x = load[order]
    loops.profile_solve(first, offset, values, x)
    assert np.allclose(x, np.linalg.solve(full, load)[order], rtol=1e-10)
    assert loops.profile_factor(np.array([0, 0]), np.array([0, 1, 3]), np.array([1.0, 2.0, 4.0])) == 0
