"""The parts of multigrid, compared with explicit matrices, which multigrid itself avoids."""

import numpy as np
import pytest
from scipy import sparse
from solver_cases import free_system, mask_of

from nmaptool.core.grid import corner_sum
from nmaptool.solver import QuadSystem
from nmaptool.solver.amg import assemble as assemble_system
from nmaptool.solver.multigrid.coarsest import assemble
from nmaptool.solver.multigrid.finest import Finest
from nmaptool.solver.multigrid.hierarchy import Hierarchy, coarsen
from nmaptool.solver.multigrid.level import inner, new_field


def random_system(seed, shape=(23, 30), span=10, held_share=0.0):
    rng = np.random.default_rng(seed)
    weight = (rng.random(shape) < 0.7) * span ** rng.uniform(-0.5, 0.5, shape)
    held = rng.random((shape[0] + 1, shape[1] + 1)) < held_share
    return QuadSystem(weight, corner_sum(weight) * 1e-3 * rng.random(held.shape), held)


@pytest.mark.parametrize("held_share", [0.0, 0.2])
def test_the_finest_level_equals_the_system(held_share):
    system = random_system(0, held_share=held_share)
    finest = Finest(system, np.float64)
    z = np.where(system.unknown, np.random.default_rng(1).normal(size=finest.shape), 0)
    # a direction that turns into z
    x, out = new_field(finest.shape, np.float64), 0.5 * z.ravel()
    inner(x, finest.shape)[:] = z
    energy = finest.advance(x, out, 0.5)
    assert np.allclose(inner(x, finest.shape), z, rtol=0, atol=1e-15)
    expected = np.where(system.unknown, system.apply(z), 0)
    assert np.allclose(out.reshape(finest.shape), expected, rtol=0, atol=1e-13)
    assert energy == pytest.approx(float((z * expected).sum()), rel=1e-12)


def dense(rows):
    """A matrix of `Rows` as an array."""
    out = np.zeros((len(rows), rows.count))
    np.add.at(out, (rows.row, rows.column), rows.value)
    return out


def prolongation(way, off_grid):
    """P as a matrix: the prolongation of each unit vector; rows and columns of off-grid vertices come last."""
    coarse, fine = (shape[0] * shape[1] for shape in (way.coarse, way.fine))
    kept = 0 if way.off_grid is None else way.off_grid.kept
    matrix = np.zeros((fine + kept, coarse + off_grid))
    for number in range(coarse):
        unit, out = new_field(way.coarse, way.dtype), new_field(way.fine, way.dtype)
        inner(unit, way.coarse).flat[number] = 1
        way.prolong(unit, out)
        matrix[:fine, number] = inner(out, way.fine).ravel()
    if way.off_grid is not None:
        matrix[way.off_grid.rows, coarse:] = dense(way.off_grid.weights)
        matrix[fine + np.arange(kept), coarse + np.arange(kept)] = 1
    return matrix


def full_matrix(level):
    """The matrix of a level over all its vertices."""
    coarsest = assemble(level)
    small, places = coarsest.matrix(), coarsest.places
    size = level.size + level.off_grid.count
    spread = sparse.csr_matrix((np.ones(len(places)), (places, np.arange(len(places)))), shape=(size, len(places)))
    return (spread @ small @ spread.T).toarray()


# in float32, the loops are compiled
@pytest.mark.parametrize(("dtype", "accuracy"), [(np.float64, 1e-9), (np.float32, 2e-5)])
@pytest.mark.parametrize("seed", range(4))
def test_coarse_levels_are_galerkin_products(seed, dtype, accuracy):
    system = random_system(seed, span=30)
    finest = Finest(system, dtype)
    anchors = np.zeros(finest.shape, bool)
    places = np.flatnonzero(system.unknown)
    matrix = np.zeros((finest.size, finest.size))
    matrix[np.ix_(places, places)] = assemble_system(system, system.unknown & ~anchors).toarray()
    level = finest
    off_grid = 0
    for _ in range(3):
        way, below = coarsen(level)
        p = prolongation(way, below.off_grid.count)
        active = np.flatnonzero(np.concatenate([below.diagonal > 0, below.off_grid.diagonal > 0]))
        # ties are lumped, so they are not part of the couplings
        ties = np.diag(matrix.sum(axis=1))
        couplings = p.T @ (matrix - ties) @ p
        np.fill_diagonal(couplings, 0)
        found = full_matrix(below)
        np.fill_diagonal(found, 0)
        pick = np.ix_(active, active)
        assert np.allclose(
            found[pick], np.minimum(couplings, 0)[pick], rtol=accuracy, atol=1e-3 * accuracy * np.abs(found).max()
        )
        rows = (p.T @ matrix @ p.sum(axis=1))[active]
        found_ties = full_matrix(below).sum(axis=1)[active]
        assert np.allclose(found_ties, np.maximum(rows, 0), rtol=0, atol=accuracy * np.abs(found).max())
        level, matrix = below, full_matrix(below)
        off_grid += below.off_grid.count
    assert off_grid > 0  # otherwise, half of the above was not tested


def test_restriction_is_the_transpose_of_prolongation():
    rng = np.random.default_rng(3)
    way, _ = coarsen(Finest(random_system(5), np.float64))
    fine, coarse = rng.normal(size=way.fine), new_field(way.coarse, np.float64)
    inner(coarse, way.coarse)[:] = rng.normal(size=way.coarse)
    down, up = np.empty(way.coarse[0] * way.coarse[1]), new_field(way.fine, np.float64)
    way.restrict(fine.ravel(), down)
    way.prolong(coarse, up)
    one, two = (down * inner(coarse, way.coarse).ravel()).sum(), (fine * inner(up, way.fine)).sum()
    assert one == pytest.approx(two, rel=1e-12)


@pytest.mark.parametrize("family", ["statue", "tree", "maze"])
def test_a_cycle_is_symmetric_and_positive(family):
    system = free_system(mask_of(family, 140), 1e-4)
    hierarchy, rng = Hierarchy(system, np.float64), np.random.default_rng(0)
    size = hierarchy.finest.size

    def cycle(residual):
        out = np.empty(size)
        hierarchy.cycle(residual, out)
        return out

    one, two = (rng.normal(size=size) * system.unknown.ravel() for _ in range(2))
    assert one @ cycle(two) == pytest.approx(two @ cycle(one), rel=1e-9)
    assert one @ cycle(one) > 0


@pytest.mark.parametrize("family", ["gaps", "islands", "comb", "noise", "tree"])
@pytest.mark.parametrize("beta", [1e-3, 0])
def test_islands_never_merge_and_free_constants_stay_free(family, beta):
    system = free_system(mask_of(family, 150), beta)
    labels, _ = system.islands()
    level = Finest(system, np.float32)
    while min(level.shape) > 5:
        _, level = coarsen(level)
        labels = labels[::2, ::2]
        if beta:  # with beta, even an island reduced to one vertex has an entry in the matrix
            coarsest = assemble(level)
            parts = sparse.csgraph.connected_components(coarsest.matrix(), directed=False)[1]
            islands = labels.ravel()[coarsest.places[coarsest.places < level.size]]
            pairs = set(zip(islands, parts, strict=False))
            assert len(pairs) == len(set(islands)) == len({part for _, part in pairs})
        else:
            assert not level.tie.any()
            assert not level.off_grid.tie.any()
