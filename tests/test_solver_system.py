"""The operator in bands, its residual, islands and weights of either precision."""

import numpy as np
import pytest
from scipy import ndimage
from solver_cases import blobs, free_system, random_system

from nmaptool.core.errors import InputError
from nmaptool.core.grid import corner_mean, corner_sum
from nmaptool.solver import QuadSystem, prepare, slope_load
from nmaptool.solver import operator as operators
from nmaptool.solver.islands import Islands


@pytest.fixture
def small_bands(monkeypatch):
    monkeypatch.setattr(operators, "ELEMENTS_AT_ONCE", 40)


def by_definition(system, z):
    """(L + diag(beta)) z by two 2x2 box sums."""
    weight = system.weight.astype(float)
    return (corner_sum(weight) + system.beta) * z - corner_sum(weight * corner_mean(z))


@pytest.mark.usefixtures("small_bands")
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (9, 1), (6, 7), (23, 12), (5, 60)])
def test_every_band_equals_the_operator(shape, dtype):
    rng = np.random.default_rng(0)
    weight = rng.random(shape).astype(dtype)
    beta = rng.random(np.add(shape, 1)).astype(dtype)
    system = QuadSystem(weight, beta, rng.random(beta.shape) < 0.3)
    z, load = rng.normal(size=(2, *beta.shape))
    expected = by_definition(system, z)
    assert np.allclose(system.apply(z), expected, rtol=0, atol=1e-14)
    for precision in (np.float32, np.float64):
        out = np.full(beta.shape, np.nan, precision)
        norm = system.residual(load, z, out)
        left = np.where(system.unknown, load - expected, 0)
        assert np.allclose(out, left, rtol=0, atol=1e-14 if precision == np.float64 else 1e-6)
        assert norm == pytest.approx(np.linalg.norm(left), rel=1e-12)
        assert system.residual(load, z, None) == norm
        assert system.residual(load, None, out) == pytest.approx(np.linalg.norm(load[system.unknown]), rel=1e-12)
    around = np.concatenate([system.operator.around(slice(row, row + 1)) for row in range(len(z))])
    assert np.allclose(around, corner_sum(system.weight), rtol=1e-15, atol=0)


def test_weights_are_neither_copied_nor_changed():
    weight, beta, held = np.ones((4, 5), np.float32), np.ones((5, 6)), np.zeros((5, 6), bool)
    system = QuadSystem(weight, beta, held)
    assert system.weight is weight
    assert system.beta is beta
    assert system.held is held
    load = np.random.default_rng(0).normal(size=(5, 6))
    kept = [each.copy() for each in (weight, beta, held, load)]
    prepare(system, "amg").solve(load, start=load)
    assert all(np.array_equal(a, b) for a, b in zip((weight, beta, held, load), kept, strict=True))
    whole = QuadSystem(np.ones((4, 5), int), np.ones((6, 5)).T, held)
    assert whole.weight.dtype == np.float64
    assert whole.beta.flags.c_contiguous


def test_a_plane_far_up_has_no_residual():
    """Differences are computed first, so heights of a million px lose nothing."""
    row, col = np.mgrid[0:50, 0:60]
    system = free_system(np.ones((49, 59)))
    assert np.abs(system.apply(1e6 + 0.25 * col - 0.5 * row))[1:-1, 1:-1].max() == 0


def test_float32_and_float64_weights_give_the_same_result():
    rng = np.random.default_rng(1)
    single = random_system(rng, 40, 50, np.float32)
    double = QuadSystem(single.weight.astype(float), single.beta.astype(float), single.held)
    load = rng.normal(size=single.beta.shape)
    for method in ("amg", "multigrid"):
        a, b = (prepare(system, method).solve(load, tolerance=1e-11).z for system in (single, double))
        assert np.abs(a - b).max() < 1e-9 * np.ptp(b)


@pytest.mark.usefixtures("small_bands")
@pytest.mark.parametrize("share", [0.05, 0.3, 0.6])
@pytest.mark.parametrize("seed", range(3))
def test_islands_are_those_of_the_faces_that_share_a_vertex(share, seed):
    rng = np.random.default_rng(seed)
    weight = (rng.random((21, 17)) < share) * rng.random((21, 17))
    held = rng.random((22, 18)) < 0.1
    beta = np.where(rng.random((22, 18)) < 0.3, 1.0, 0)
    system = QuadSystem(weight, beta, held)
    faces, count = ndimage.label(weight > 0, np.ones((3, 3)))
    pads = [((a, 1 - a), (b, 1 - b)) for a in (0, 1) for b in (0, 1)]
    expected = np.max([np.pad(faces, pad) for pad in pads], axis=0)
    islands = Islands(system)
    labels = islands.labels
    assert islands.count == count == system.islands()[1]
    assert len({(a, b) for a, b in zip(labels.flat, expected.flat, strict=True)}) == count + 1
    assert np.array_equal(labels == 0, expected == 0)
    assert np.array_equal(labels, system.islands()[0])
    for island in range(1, count + 1):
        at = labels == island
        assert islands.floating[island] == (not held[at].any() and not beta[at].any())
        anchored = np.flatnonzero(islands.anchors & at)
        assert list(anchored) == ([np.flatnonzero(at)[0]] if islands.floating[island] else [])
    assert not islands.floating[0]
    assert not islands.anchors[labels == 0].any()


@pytest.mark.usefixtures("small_bands")
def test_norms_and_means_are_computed_per_island():
    rng = np.random.default_rng(2)
    weight = np.zeros((20, 30))
    weight[2:8, 2:9], weight[2:8, 12:28], weight[12:18, 3:25] = 1, 2, 3
    beta = np.zeros((21, 31))
    beta[12:19, 3:26] = 0.1
    system = QuadSystem(weight, beta, np.zeros(beta.shape, bool))
    islands = Islands(system)
    load, z = rng.normal(size=(2, *beta.shape)) + 3
    out = np.empty(beta.shape, np.float32)
    constants = islands.constants(load)
    norms = islands.residual(load, z, out, constants)
    level = constants.level[islands.labels]
    assert (beta * level)[islands.labels == 3].sum() == pytest.approx(load[islands.labels == 3].sum())
    left = np.where(system.unknown, load - beta * level - system.apply(z), 0)
    for island in range(1, 4):
        at = islands.labels == island
        here = left[at] - (left[at].mean() if islands.floating[island] else 0)
        assert norms[island] == pytest.approx(np.linalg.norm(here), rel=1e-6)
        assert np.allclose(out[at], here, atol=1e-5)
    plain = islands.residual(load, z, None)
    assert plain[1] == pytest.approx(np.linalg.norm((load - system.apply(z))[islands.labels == 1]), rel=1e-12)
    kept = out.copy()
    islands.keep(np.arange(4) == 2, out)
    assert np.array_equal(out, np.where(islands.labels == 2, kept, 0))


def test_many_tiny_islands_are_each_solved():
    rng = np.random.default_rng(3)
    weight = (rng.random((200, 200)) < 0.08).astype(float)
    load = slope_load(*(weight * rng.normal(size=(2, 200, 200))))
    for method in ("amg", "multigrid"):
        solution = prepare(free_system(weight), method).solve(load)
        assert solution.residual <= 1e-8
        single = ndimage.label(weight, np.ones((3, 3)))[0]
        alone = np.flatnonzero(np.bincount(single.ravel())[single.ravel()] == 1)[0]
        row, col = divmod(int(alone), 200)
        corners = solution.z[row : row + 2, col : col + 2]
        # a single pixel: its slopes determine its heights
        assert np.allclose(corners, load[row : row + 2, col : col + 2], rtol=0, atol=1e-7)


def test_height_weights_outside_all_faces_count_too():
    system = QuadSystem(np.pad(np.ones((2, 2)), 3), np.full((9, 9), 0.5), np.zeros((9, 9), bool))
    load = np.random.default_rng(0).normal(size=(9, 9))
    for method in ("amg", "multigrid"):
        z = prepare(system, method).solve(load, tolerance=1e-10).z
        assert z[0, 0] == pytest.approx(2 * load[0, 0], rel=1e-9)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -1.0])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_one_bad_weight_anywhere_is_found(bad, dtype):
    weight, beta = np.ones((300, 400), dtype), np.ones((301, 401), dtype)
    held = np.zeros(beta.shape, bool)
    for array, name in ((weight, "face"), (beta, "height")):
        array[287, 13] = bad
        with pytest.raises(InputError, match=f"{name} weights must be finite and zero or more"):
            QuadSystem(weight, beta, held)
        array[287, 13] = 1


def test_only_a_uniform_system_is_recognised_as_uniform():
    ones, held = np.ones((6, 8)), np.zeros((7, 9), bool)
    for dtype in (np.float32, np.float64):
        beta = corner_sum(ones).astype(dtype) * 0.3
        assert QuadSystem(ones.astype(dtype), beta, held).is_uniform
        for place in ((3, 3), (0, 0), (0, 4), (4, 0), (6, 8), (6, 3), (3, 8)):
            other = beta.copy()
            other[place] *= 1.001
            assert not QuadSystem(ones, other, held).is_uniform
    for shape in ((1, 1), (1, 5), (5, 1), (2, 2)):
        beta = corner_sum(np.ones(shape)) * 0.3
        assert QuadSystem(np.ones(shape), beta, beta < 0).is_uniform
    assert not QuadSystem(blobs(6), np.zeros((7, 7)), np.zeros((7, 7), bool)).is_uniform
