"""Multigrid against the matrices it does without, and the counts of its iterations."""

import numpy as np
import pytest
from scipy import sparse
from solver_cases import free_system

import nmaptool as nm
from bench import masks
from nmaptool.errors import ConvergenceError
from nmaptool.grid import corner_sum, touching
from nmaptool.solver import QuadSystem, prepare, slope_load
from nmaptool.solver.amg import assemble as assemble_system
from nmaptool.solver.multigrid import hierarchy as building
from nmaptool.solver.multigrid.coarsest import assemble
from nmaptool.solver.multigrid.finest import Finest
from nmaptool.solver.multigrid.hierarchy import Hierarchy, coarsen
from nmaptool.solver.multigrid.level import inner, new_field
from nmaptool.vectors import unit

FAMILIES = ("statue", "holes", "islands", "gaps", "comb", "bridge", "hair", "checkerboard")
THIN = ("tree", "lines", "spiral", "maze", "noise")


def mask_of(family, side):
    return masks.statue(side, side) if family == "statue" else getattr(masks, family)(side)


def load_for(weight, seed=1):
    return slope_load(*(np.random.default_rng(seed).normal(size=(2, *weight.shape)) * weight))


def iterations(family, side, beta, tolerance=1e-8):
    weight = mask_of(family, side)
    return prepare(free_system(weight, beta), "multigrid").solve(load_for(weight), tolerance=tolerance).iterations


# at side 128 and 384, for beta 1, 0.001 and 0
COUNTS = {
    "statue": (7, 7, 7, 7, 7, 7),
    "holes": (8, 9, 9, 8, 9, 9),
    "islands": (8, 8, 8, 8, 8, 8),
    "gaps": (8, 7, 7, 8, 7, 7),
    "comb": (8, 7, 7, 7, 7, 7),
    "bridge": (8, 7, 7, 7, 7, 7),
    "hair": (7, 9, 9, 7, 11, 11),
    "checkerboard": (7, 7, 7, 7, 7, 7),
    "tree": (7, 8, 8, 8, 11, 12),
    "lines": (8, 10, 10, 8, 11, 12),
    "spiral": (8, 7, 7, 8, 8, 8),
    "maze": (7, 8, 8, 7, 10, 11),
    "noise": (8, 10, 10, 8, 11, 11),
}


@pytest.mark.parametrize("family", [*FAMILIES, *THIN])
def test_iterations_are_few_and_hold_with_size_and_beta(family):
    found = [iterations(family, side, beta) for side in (128, 384) for beta in (1, 1e-3, 0)]
    # one more or less is rounding
    assert np.abs(np.subtract(found, COUNTS[family])).max() <= 1, found
    assert max(found) <= 15


@pytest.mark.parametrize("family", [*FAMILIES, *THIN])
@pytest.mark.parametrize("beta", [1e-2, 0])
def test_agrees_with_amg_on_every_mask(family, beta):
    weight = mask_of(family, 96)
    system, load = free_system(weight, beta), load_for(weight)
    found, expected = (prepare(system, name).solve(load, tolerance=1e-11).z for name in ("multigrid", "amg"))
    assert np.abs(found - expected).max() <= 1e-7 * np.ptp(expected)


@pytest.mark.parametrize("family", ["statue", "noise", "tree"])
@pytest.mark.parametrize("span", [1e2, 1e6, 1e12])
def test_agrees_with_amg_for_weights_that_span_much(family, span):
    rng = np.random.default_rng(4)
    weight = mask_of(family, 64) * 10 ** (rng.uniform(-0.5, 0.5, (64, 64)) * np.log10(span))
    held = rng.random((65, 65)) < 0.1
    system = QuadSystem(weight, corner_sum(weight) * rng.random((65, 65)) * 1e-3, held)
    held_z, load = rng.normal(size=held.shape), load_for(weight)
    found, expected = (prepare(system, name).solve(load, held_z, tolerance=1e-11).z for name in ("multigrid", "amg"))
    assert np.abs(found - expected).max() <= 1e-6 * np.ptp(expected)
    assert np.array_equal(found[held & (touching(weight > 0))], held_z[held & touching(weight > 0)])


def test_agrees_with_dct_on_a_rectangle():
    weight = np.ones((75, 110))
    system = free_system(weight, 1e-4)
    load = load_for(weight)
    found, expected = (prepare(system, name).solve(load, tolerance=1e-11).z for name in ("multigrid", "dct"))
    assert np.abs(found - expected).max() <= 1e-7 * np.ptp(expected)


@pytest.mark.parametrize("family", ["statue", "maze", "noise"])
@pytest.mark.parametrize(("span", "most"), [(1e2, 13), (1e4, 16), (1e12, 24)])
def test_iterations_stay_few_where_every_pixel_has_its_own_weight(family, span, most):
    weight = mask_of(family, 256) * masks.spanning((256, 256), span)
    for beta in (1e-3, 0):
        solution = prepare(free_system(weight, beta), "multigrid").solve(load_for(weight))
        assert solution.iterations <= most


@pytest.mark.parametrize("background", ["plane", "free", "cut", "surface"])
@pytest.mark.parametrize("family", ["statue", "hair", "tree", "noise", "gaps"])
def test_reliefs_agree_with_amg_on_every_background(family, background):
    side, rng = 72, np.random.default_rng(2)
    slopes = rng.normal(size=(2, side, side)) * 0.5
    normals = unit(np.dstack([*-slopes, np.ones((side, side))]))
    original = nm.NormalMap(normals, np.ones((side, side), np.float32), nm.Frame(side, side))
    detail = nm.NormalMap(normals[::-1].copy(), np.ones((side, side), np.float32), nm.Frame(side, side))
    given = {"mask": mask_of(family, side), "mu_map": rng.random((side, side)).astype(np.float32)}
    given["beta_map"] = rng.random((side, side)).astype(np.float32)
    if background == "surface":
        hill = 5 * np.sin(np.linspace(0, 3, side + 1))[:, None] * np.ones(side + 1)
        given["surface"] = nm.Height(hill * 100 / side, np.ones((side, side), bool), nm.Frame(side, side, 100 / side))
    found, expected = (
        nm.relief(
            original, detail, options=nm.ReliefOptions(background=background, solver=name, tolerance=1e-11), **given
        ).z_mm
        for name in ("multigrid", "amg")
    )
    assert np.abs(found - expected).max() <= 1e-7 * np.ptp(expected)


@pytest.mark.parametrize("shape", [(1, 1), (1, 2), (2, 1), (1, 700), (700, 1), (2, 333), (3, 3), (40, 1)])
@pytest.mark.parametrize("beta", [0.1, 0])
def test_strips_and_single_pixels(shape, beta):
    weight = np.ones(shape)
    system, load = free_system(weight, beta), load_for(weight)
    found, expected = (prepare(system, name).solve(load, tolerance=1e-11).z for name in ("multigrid", "amg"))
    assert np.abs(found - expected).max() <= 1e-7 * max(np.ptp(expected), 1e-12)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-10, 1e-12])
def test_reaches_what_float32_alone_cannot(tolerance):
    weight = mask_of("statue", 256)
    solution = prepare(free_system(weight), "multigrid").solve(load_for(weight), tolerance=tolerance)
    assert solution.residual <= tolerance
    assert solution.iterations <= 14


def test_wide_smooth_heights_keep_their_low_frequencies():
    side = 1500
    x = np.linspace(0, np.pi, side + 1)
    z = 400 * np.cos(x) * np.cos(2 * x)[:, None]
    weight = np.ones((side, side), np.float32)
    weight[700:800, 700:800] = 0
    system = free_system(weight)
    inside = touching(weight > 0)
    z = np.where(inside, z - z[inside].mean(), 0)
    found = prepare(system, "multigrid").solve(system.apply(z), tolerance=1e-10).z
    assert np.abs(found - z).max() <= 1e-6 * np.ptp(z)


def test_runs_agree_to_the_bit_and_one_setup_serves_many():
    weight = mask_of("hair", 200)
    system = free_system(weight, 1e-3)
    solver = prepare(system, "multigrid")
    one, two = load_for(weight, 1), load_for(weight, 2)
    first = solver.solve(one).z
    other = solver.solve(two).z
    assert np.array_equal(solver.solve(one).z, first)
    assert np.array_equal(prepare(system, "multigrid").solve(two).z, other)


def test_not_converging_is_an_error_with_the_history():
    weight = mask_of("tree", 128)
    with pytest.raises(ConvergenceError, match=r"multigrid solver stopped at a .* after 3 it") as e:
        prepare(free_system(weight), "multigrid").solve(load_for(weight), max_iterations=3)
    assert len(e.value.history) == 3


# what it is made of


def random_system(seed, shape=(23, 30), span=10, held_share=0.0):
    rng = np.random.default_rng(seed)
    weight = (rng.random(shape) < 0.7) * span ** rng.uniform(-0.5, 0.5, shape)
    held = rng.random((shape[0] + 1, shape[1] + 1)) < held_share
    return QuadSystem(weight, corner_sum(weight) * 1e-3 * rng.random(held.shape), held)


@pytest.mark.parametrize("held_share", [0.0, 0.2])
def test_finest_level_is_the_system(held_share):
    system = random_system(0, held_share=held_share)
    finest = Finest(system, np.float64)
    z = np.where(system.unknown, np.random.default_rng(1).normal(size=finest.shape), 0)
    x, out = new_field(finest.shape, np.float64), np.empty(finest.size)
    inner(x, finest.shape)[:] = z
    energy = finest.times(x, out)
    expected = np.where(system.unknown, system.apply(z), 0)
    assert np.allclose(out.reshape(finest.shape), expected, rtol=0, atol=1e-13)
    assert energy == pytest.approx(float((z * expected).sum()), rel=1e-12)


def prolongation(way, strays):
    """P as a matrix: what comes up for each unit vector; strays' rows and columns last."""
    coarse, fine = (shape[0] * shape[1] for shape in (way.coarse, way.fine))
    kept = 0 if way.strays is None else way.strays.kept
    matrix = np.zeros((fine + kept, coarse + strays))
    for number in range(coarse):
        unit, out = new_field(way.coarse, np.float64), new_field(way.fine, np.float64)
        inner(unit, way.coarse).flat[number] = 1
        way.prolong(unit, out)
        matrix[:fine, number] = inner(out, way.fine).ravel()
    if way.strays is not None:
        matrix[way.strays.rows, coarse:] = way.strays.weights.toarray()
        matrix[fine + np.arange(kept), coarse + np.arange(kept)] = 1
    return matrix


def full_matrix(level):
    """The matrix of a level over all its places."""
    small, places = assemble(level)
    size = level.size + level.strays.count
    spread = sparse.csr_matrix((np.ones(len(places)), (places, np.arange(len(places)))), shape=(size, len(places)))
    return (spread @ small @ spread.T).toarray()


@pytest.mark.parametrize("seed", range(4))
def test_coarse_levels_are_galerkin(seed):
    system = random_system(seed, span=30)
    finest = Finest(system, np.float64)
    anchors = np.zeros(finest.shape, bool)
    places = np.flatnonzero(system.unknown)
    matrix = np.zeros((finest.size, finest.size))
    matrix[np.ix_(places, places)] = assemble_system(system, system.unknown & ~anchors).toarray()
    level = finest
    strays = 0
    for _ in range(3):
        way, below = coarsen(level)
        p = prolongation(way, below.strays.count)
        active = np.flatnonzero(np.concatenate([below.diagonal > 0, below.strays.diagonal > 0]))
        # ties are lumped: they are no part of the couplings
        ties = np.diag(matrix.sum(axis=1))
        couplings = p.T @ (matrix - ties) @ p
        np.fill_diagonal(couplings, 0)
        found = full_matrix(below)
        np.fill_diagonal(found, 0)
        pick = np.ix_(active, active)
        assert np.allclose(found[pick], np.minimum(couplings, 0)[pick], rtol=1e-9, atol=1e-12 * np.abs(found).max())
        rows = (p.T @ matrix @ p.sum(axis=1))[active]
        found_ties = full_matrix(below).sum(axis=1)[active]
        assert np.allclose(found_ties, np.maximum(rows, 0), rtol=0, atol=1e-9 * np.abs(found).max())
        level, matrix = below, full_matrix(below)
        strays += below.strays.count
    assert strays > 0  # or half of the above was not tried


def test_restriction_is_the_transpose_of_prolongation():
    rng = np.random.default_rng(3)
    way, _ = coarsen(Finest(random_system(5), np.float64))
    fine, coarse = rng.normal(size=way.fine), new_field(way.coarse, np.float64)
    inner(coarse, way.coarse)[:] = rng.normal(size=way.coarse)
    down, up = np.empty(way.coarse[0] * way.coarse[1]), new_field(way.fine, np.float64)
    way.restrict(lambda first, last: fine[first:last], down)
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
        hierarchy.cycle(residual, new_field(hierarchy.finest.shape, np.float64), out)
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
        if beta:  # so that what has shrunk to a single vertex still shows
            matrix, places = assemble(level)
            parts = sparse.csgraph.connected_components(matrix, directed=False)[1]
            islands = labels.ravel()[places[places < level.size]]
            pairs = set(zip(islands, parts, strict=False))
            assert len(pairs) == len(set(islands)) == len({part for _, part in pairs})
        else:
            assert not level.tie.any()
            assert not level.strays.tie.any()


def test_what_is_left_of_a_thin_shape_is_carried_down(monkeypatch):
    monkeypatch.setattr(building, "_MOST_STRAYS", 2.0)  # never hand over early
    assert iterations("maze", 128, 0) <= 15


@pytest.mark.parametrize(
    ("stiffer", "pulled", "borrowed"), [(1, 1.3, True), (2.5, 2, True), (1, 3, False), (8, 1, False)]
)
def test_coarse_levels_serve_a_similar_system_and_no_other(stiffer, pulled, borrowed):
    weight = mask_of("hair", 160)
    first = prepare(free_system(weight, 1e-3), "multigrid")
    system = QuadSystem(weight * np.float32(stiffer), first.system.beta * pulled, first.system.held)
    solver, load = prepare(system, "multigrid", like=first), load_for(weight)
    assert solver.method.borrowed is borrowed
    found = solver.solve(load, tolerance=1e-11)
    assert np.abs(found.z - prepare(system, "amg").solve(load, tolerance=1e-11).z).max() <= 1e-7 * np.ptp(found.z)
    assert found.iterations <= 16
    again = first.solve(load).z
    assert np.array_equal(again, prepare(first.system, "multigrid").solve(load).z)


@pytest.mark.parametrize("change", ["mask", "held", "size", "span"])
def test_coarse_levels_are_made_anew_where_the_shape_changes(change):
    weight = np.ones((40, 50))
    first = free_system(weight, 1e-3)
    weight, held = weight.copy(), first.held.copy()  # a system keeps the arrays it is given
    if change == "mask":
        weight[3, 3] = 0
    elif change == "held":
        held[5, 5] = True
    elif change == "size":
        weight, held = np.ones((50, 40)), np.zeros((51, 41), bool)
    else:
        weight[3, 3] = 1e-5
    system = QuadSystem(weight, corner_sum(np.ones_like(weight)) / 4 * 1e-3, held)
    assert not prepare(system, "multigrid", like=prepare(first, "multigrid")).method.borrowed
