"""The loop around the methods: initial heights, tolerances down to rounding, islands of every size, extreme systems."""

import numpy as np
import pytest
from solver_cases import blobs, dense_answer, free_system, random_system

from nmaptool.core.errors import ConvergenceError, InputError
from nmaptool.core.grid import corner_sum, height_slopes
from nmaptool.solver import QuadSystem, Solver, prepare, slope_load
from nmaptool.solver.islands import Islands
from nmaptool.solver.window import window_of

MASKED = ("amg", "multigrid")


def noise_load(rng, weight):
    return slope_load(*(weight * rng.normal(size=(2, *weight.shape))))


@pytest.mark.parametrize("method", MASKED)
@pytest.mark.parametrize("beta", [1.0, 1e-3, 1e-9, 0.0])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-10])
def test_every_tolerance_is_reached(method, beta, tolerance):
    weight = blobs(96)
    system = free_system(weight, beta)
    load = noise_load(np.random.default_rng(0), weight) + 30 * system.beta
    solution = prepare(system, method).solve(load, tolerance=tolerance)
    left = np.empty(load.shape)
    system.residual(load, solution.z, left)
    labels, count = system.islands()
    for island in range(1, count + 1):
        at = labels == island
        assert np.linalg.norm(left[at]) <= 1.1 * tolerance * np.linalg.norm(load[at])
    assert solution.residual <= tolerance
    assert solution.history[-1] == solution.residual
    assert solution.iterations == len(solution.history)


@pytest.mark.parametrize("beta", [1.0, 1e-3, 0.0])
def test_dct_and_amg_reach_1e_12(beta):
    rng = np.random.default_rng(0)
    weight = np.ones((90, 71))
    for method in ("dct", "amg"):
        solution = prepare(free_system(weight, beta), method).solve(noise_load(rng, weight), tolerance=1e-12)
        assert solution.residual <= 1e-12


@pytest.mark.parametrize("method", MASKED)
@pytest.mark.parametrize("beta", [1e-3, 0.0])
def test_starting_from_the_solution_takes_no_iteration(method, beta):
    weight = blobs(64)
    system = free_system(weight, beta)
    load = noise_load(np.random.default_rng(1), weight) + 30 * system.beta
    solver = prepare(system, method)
    first = solver.solve(load, tolerance=1e-9)
    again = solver.solve(load, start=first.z, tolerance=2e-9)
    assert again.iterations == 0
    assert again.history == ()
    assert np.abs(again.z - first.z).max() < 1e-12 * np.ptp(first.z)
    near = solver.solve(load + 1e-4 * np.roll(load, 1), start=first.z)
    far = solver.solve(load + 1e-4 * np.roll(load, 1))
    assert near.iterations < far.iterations
    assert np.abs(near.z - far.z).max() < 1e-6 * np.ptp(far.z)


@pytest.mark.parametrize("method", ["amg", "multigrid", "dct"])
def test_the_start_does_not_change_the_result(method):
    rng = np.random.default_rng(2)
    system = free_system(np.ones((30, 41))) if method == "dct" else random_system(rng, 30, 41)
    load, held_z = rng.normal(size=(2, *system.beta.shape))
    start = 1e3 * rng.normal(size=system.beta.shape) + 1e4
    solver = prepare(system, method)
    a, b = (solver.solve(load, held_z, start=each, tolerance=1e-12, max_iterations=200).z for each in (None, start))
    assert np.abs(a - b).max() < 1e-9 * np.ptp(a)
    assert np.array_equal(b[system.held], held_z[system.held])


@pytest.mark.parametrize("method", MASKED)
def test_an_island_without_a_load_is_flat_for_any_start(method):
    weight = blobs(64)
    system = free_system(weight, 1e-3)
    labels, _ = system.islands()
    load = np.where(labels == 1, noise_load(np.random.default_rng(3), weight), 0)
    solution = prepare(system, method).solve(load, start=np.ones(load.shape))
    assert not solution.z[labels != 1].any()
    assert solution.z[labels == 1].any()
    assert not prepare(system, method).solve(0 * load, start=np.ones(load.shape)).z.any()


def test_an_invalid_start_is_refused():
    solver = prepare(free_system(np.ones((4, 5))), "amg")
    with pytest.raises(InputError, match=r"the start heights must be of shape \(5, 6\), found \(6, 5\)"):
        solver.solve(np.ones((5, 6)), start=np.zeros((6, 5)))
    for bad in (np.nan, np.inf):
        with pytest.raises(InputError, match=r"the start heights must be finite; found NaN or infinite values"):
            solver.solve(np.ones((5, 6)), start=np.full((5, 6), bad))


@pytest.mark.parametrize("method", MASKED)
def test_a_small_island_beside_a_far_larger_load_is_solved(method):
    weight = blobs(64)
    labels, _ = free_system(weight).islands()
    z = np.random.default_rng(4).normal(size=labels.shape) * np.where(labels == 1, 1e6, 1e-6)
    load = slope_load(*(weight * slope for slope in height_slopes(z)))
    solution = prepare(free_system(weight), method).solve(load, tolerance=1e-9)
    alone = prepare(free_system(weight), method).solve(np.where(labels == 2, load, 0), tolerance=1e-9)
    assert np.abs(solution.z - alone.z)[labels == 2].max() < 1e-7 * np.ptp(alone.z)


@pytest.mark.parametrize("method", MASKED)
def test_a_load_that_free_islands_cannot_match_is_matched_up_to_its_mean(method):
    weight = blobs(64)
    system = free_system(weight)
    labels, count = system.islands()
    load = noise_load(np.random.default_rng(5), weight)
    balanced, lifted = (prepare(system, method).solve(each, tolerance=1e-10).z for each in (load, load + 3))
    assert np.abs(balanced - lifted).max() < 1e-7 * np.ptp(balanced)
    assert all(abs(lifted[labels == island].mean()) < 1e-12 for island in range(1, count + 1))


TINY = {
    "one pixel": np.ones((1, 1)),
    "a row": np.ones((1, 9)),
    "a column": np.ones((9, 1)),
    "single pixels": np.diag([1.0, 0, 1, 0, 1])[:, [0, 3, 2, 1, 4]],
    "a diagonal": np.eye(6),
    "a checkerboard": np.indices((5, 6)).sum(axis=0) % 2.0,
    "zeros around": np.pad(np.ones((1, 2)), 4),
}


@pytest.mark.parametrize("name", TINY)
@pytest.mark.parametrize("beta", [0.5, 0.0])
@pytest.mark.parametrize("method", [*MASKED, "auto"])
def test_tiny_systems_match_a_dense_solve(name, beta, method):
    rng = np.random.default_rng(6)
    system = free_system(TINY[name], beta)
    load = noise_load(rng, TINY[name]) + 2 * system.beta
    z = prepare(system, method).solve(load, tolerance=1e-11).z
    assert np.abs(z - dense_answer(system, load)).max() < 1e-8
    one_held = QuadSystem(system.weight, system.beta, system.beta < -1)
    one_held.held[tuple(np.argwhere(TINY[name])[0])] = True
    held_z = np.full(load.shape, 7.0)
    solver = prepare(one_held, "amg" if method == "auto" else method)
    assert np.abs(solver.solve(load, held_z, tolerance=1e-11).z - dense_answer(one_held, load, held_z)).max() < 1e-8


@pytest.mark.parametrize("method", MASKED)
@pytest.mark.parametrize("seed", range(4))
def test_random_systems_match_a_dense_solve(method, seed):
    rng = np.random.default_rng(seed)
    system = random_system(rng, 9, 14)
    load, held_z = rng.normal(size=(2, *system.beta.shape))
    z = prepare(system, method).solve(load, held_z, tolerance=1e-11).z
    assert np.abs(z - dense_answer(system, load, held_z)).max() < 1e-8


@pytest.mark.parametrize("method", MASKED)
def test_everything_may_be_held(method):
    held_z = np.random.default_rng(7).normal(size=(5, 6))
    for weight in (np.ones((4, 5)), np.pad(np.ones((2, 3)), 1)):
        system = QuadSystem(weight, np.ones((5, 6)), np.ones((5, 6), bool))
        solution = prepare(system, method).solve(held_z, held_z, start=np.zeros((5, 6)))
        assert np.array_equal(solution.z, held_z)
        assert solution.iterations == 0


@pytest.mark.parametrize("method", MASKED)
@pytest.mark.parametrize("kind", ["halves", "noise"])
def test_weights_over_twelve_decades_are_solved_exactly_or_refused(method, kind):
    rng = np.random.default_rng(8)
    weight = 10.0 ** rng.uniform(-6, 6, (24, 30)) if kind == "noise" else np.repeat([[1e-6], [1e6]], 12, axis=0)
    weight = weight * np.ones((24, 30))
    z = rng.normal(size=(25, 31)).cumsum(axis=0).cumsum(axis=1)
    system = free_system(weight)
    load = slope_load(*(weight * slope for slope in height_slopes(z)))
    try:
        solution = prepare(system, method).solve(load, tolerance=1e-8)
    except ConvergenceError as error:
        assert "stopped at a relative residual of" in str(error)
    else:
        left = np.empty(load.shape)
        assert system.residual(load, solution.z, left) <= 2e-8 * np.linalg.norm(load)


@pytest.mark.parametrize("size", [1e-200, 1e-25, 1e25, 1e200])
@pytest.mark.parametrize("method", ["amg", "multigrid", "dct"])
def test_the_size_of_a_load_does_not_matter(size, method):
    rng = np.random.default_rng(9)
    system = free_system(np.ones((20, 25)), 0.1) if method == "dct" else random_system(rng, 20, 25)
    load, held_z = rng.normal(size=(2, *system.beta.shape))
    solver = prepare(system, method)
    expected = solver.solve(load, held_z, tolerance=1e-9).z
    z = solver.solve(size * load, size * held_z, tolerance=1e-9, start=size * expected).z
    assert np.abs(z / size - expected).max() < 1e-7 * np.ptp(expected)


class Lazy:
    """A method that stops early: each call removes only a share of the error."""

    name, precision = "lazy", np.float64

    def __init__(self, system, share):
        self.exact = prepare(system, "amg").method
        self.share = share
        self.calls = []

    def improve(self, z, residual, reduction, max_iterations, report):
        step = np.zeros(z.shape)
        self.exact.improve(step, residual.copy(), 1e-13, 100, None)
        z += self.share * step
        self.calls.append((reduction, max_iterations))
        if report is not None:
            report(1 - self.share)
        return 1.0, 1 - self.share


def test_the_loop_continues_to_the_tolerance_and_records_the_residuals():
    weight = blobs(48)
    system = free_system(weight, 1e-3)
    lazy = Lazy(system, 0.99)
    seen = []
    solution = Solver(window_of(system), system, lazy, Islands(system)).solve(
        noise_load(np.random.default_rng(0), weight),
        tolerance=1e-7,
        progress=lambda word, share: seen.append((word, share)),
    )
    assert [limit for _, limit in lazy.calls] == [100, 98, 96, 94]
    assert [reduction for reduction, _ in lazy.calls] == pytest.approx([8e-8, 8e-6, 8e-4, 8e-2], rel=1e-3)
    assert solution.history == pytest.approx([1, 1e-2, 1e-2, 1e-4, 1e-4, 1e-6, 1e-6, 1e-8], rel=1e-3)
    assert {word for word, _ in seen} == {"solving"}
    assert [share for _, share in seen] == pytest.approx([2 / 7, 4 / 7, 6 / 7, 1, 1], rel=1e-3)


def test_a_method_that_stalls_is_stopped_with_the_history():
    weight = blobs(48)
    system = free_system(weight, 1e-3)
    lazy = Lazy(system, 0.3)
    with pytest.raises(ConvergenceError, match=r"lazy solver stopped at a relative residual of 7.0e-01") as caught:
        Solver(window_of(system), system, lazy, Islands(system)).solve(noise_load(np.random.default_rng(0), weight))
    assert len(lazy.calls) == 1
    assert caught.value.history == pytest.approx((1, 0.7), rel=1e-6)
    with pytest.raises(ConvergenceError, match="after 2 iterations"):
        Solver(window_of(system), system, Lazy(system, 0.9), Islands(system)).solve(
            noise_load(np.random.default_rng(0), weight), max_iterations=2
        )


def test_a_height_term_on_one_vertex_sets_the_level():
    weight = blobs(40)
    labels, _ = free_system(weight).islands()
    beta = np.zeros(labels.shape)
    beta[tuple(np.argwhere(labels == 1)[50])] = 1e-7
    system = QuadSystem(weight, beta, np.zeros(labels.shape, bool))
    load = noise_load(np.random.default_rng(1), weight)
    shape = prepare(free_system(weight), "amg").solve(load, tolerance=1e-11).z
    for method in MASKED:
        z = prepare(system, method).solve(load + 12 * beta, tolerance=1e-10).z
        assert z[beta > 0] == pytest.approx(12, abs=1e-6)
        assert np.ptp((z - shape)[labels == 1]) < 1e-7 * np.ptp(shape)


def test_dct_solves_sizes_of_every_kind():
    rng = np.random.default_rng(2)
    for shape in ((1, 1), (2, 1), (1, 31), (7, 13), (64, 37), (101, 97)):
        for dtype in (np.float32, np.float64):
            weight = np.full(shape, 1.5, dtype)
            beta = (corner_sum(weight) * 0.01).astype(dtype)
            system = QuadSystem(weight, beta, np.zeros(beta.shape, bool))
            load = rng.normal(size=beta.shape) + 40 * beta
            z = prepare(system, "dct").solve(load, tolerance=1e-10).z
            assert np.linalg.norm(load - system.apply(z)) <= 1e-10 * np.linalg.norm(load)


@pytest.mark.parametrize("method", ["multigrid", "amg"])
@pytest.mark.parametrize("level", [1e3, 1e6])
@pytest.mark.parametrize("beta", [1e-3, 1.0])
def test_a_large_offset_does_not_hide_the_shape(method, level, beta):
    weight = blobs(64)
    system, load = free_system(weight, beta), noise_load(np.random.default_rng(3), weight)
    solver = prepare(system, method)
    near = solver.solve(load, tolerance=1e-10).z
    far = solver.solve(load + system.beta * level).z - level * (system.unknown & (system.beta > 0))
    assert np.abs(far - near).max() <= 1e-6 * np.ptp(near) + 1e-15 * level * 64


def test_arrays_of_wrong_shapes_are_named():
    solver = prepare(free_system(np.ones((5, 6)), 0.1))
    with pytest.raises(InputError, match=r"the right-hand side must be of shape \(6, 7\), found \(1, 6, 7\)"):
        solver.solve(np.zeros((1, 6, 7)))
    with pytest.raises(InputError, match=r"the held heights must be of shape \(6, 7\), found \(3, 3\)"):
        solver.solve(np.zeros((6, 7)), np.zeros((3, 3)))


def test_auto_uses_amg_for_a_few_lines_in_a_large_image():
    weight = np.zeros((300, 300))
    weight[50], weight[[0, -1], [0, -1]] = 1, 1  # the box around it is the whole
    assert prepare(free_system(weight, 0.1)).method.name == "amg"
    weight[20:22] = 1
    assert prepare(free_system(weight, 0.1)).method.name == "multigrid"
