"""The operator against its definition, the solvers against analytic surfaces, a dense solve and each other."""

import numpy as np
import pytest
from solver_cases import blobs, dense, free_system, random_system

from nmaptool.core.errors import ConvergenceError, InputError, UsageError
from nmaptool.core.grid import corner_mean, corner_sum, height_slopes
from nmaptool.solver import QuadSystem, choose, energy, prepare, slope_load
from nmaptool.solver.amg import assemble


def vertices(rows, cols):
    row, col = np.mgrid[0 : rows + 1, 0 : cols + 1]
    return col.astype(float), (rows - row).astype(float)


# surfaces without twist, f(x) + g(y), are fully determined by their slopes
SURFACES = {
    "plane": lambda x, y: 0.3 * x - 0.7 * y,
    "paraboloid": lambda x, y: 0.01 * (x - 20) ** 2 - 0.02 * (y - 9) ** 2,
    "sinusoid": lambda x, y: 3 * np.sin(x / 4) + 2 * np.cos(y / 3),
}


@pytest.mark.parametrize("method", ["dct", "amg"])
@pytest.mark.parametrize("name", SURFACES)
@pytest.mark.parametrize("shape", [(48, 64), (37, 51), (1, 30), (30, 1), (1, 1)])
def test_analytic_surfaces_are_exact_up_to_a_constant(name, method, shape):
    z = SURFACES[name](*vertices(*shape))
    system = free_system(np.ones(shape))
    solved = prepare(system, method).solve(slope_load(*height_slopes(z)))
    assert np.abs(solved.z - (z - z.mean())).max() < 1e-7 * np.ptp(z)
    assert solved.residual < 1e-8


def test_a_ridge_on_a_plate_is_exact():
    x, _ = vertices(40, 60)
    z = np.maximum(0, 100 - (x - 30) ** 2) / 10  # starts and ends on whole pixels
    held = z == 0
    weight = np.zeros((40, 60))
    weight[:, 20:40] = 1
    solved = prepare(QuadSystem(weight, np.zeros_like(z), held)).solve(
        slope_load(*(s * weight for s in height_slopes(z)))
    )
    assert np.abs(solved.z - z).max() < 1e-7 * np.ptp(z)


def test_a_round_cap_converges_with_the_square_of_the_pixel_size():
    errors = []
    for side in (32, 64, 128):
        x, y = vertices(side, side)
        r = np.hypot(x - side / 2, y - side / 2) / (0.4 * side)
        z = side * np.where(r < 1, (1 + np.cos(np.pi * np.minimum(r, 1))) / 2, 0) / 8
        solved = prepare(free_system(np.ones((side, side)))).solve(slope_load(*height_slopes(z)))
        errors.append(np.abs(solved.z - (z - z.mean())).max() / np.ptp(z))
    assert errors[0] < 0.02
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.15)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.15)


@pytest.mark.parametrize("beta", [1.0, 1e-2, 1e-5, 0.0])
def test_dct_and_amg_agree(beta):
    rng = np.random.default_rng(3)
    p, q = rng.normal(size=(2, 90, 71))
    system = free_system(np.full((90, 71), 1.3), beta)
    load = slope_load(p, q) + 4 * system.beta
    by_dct, by_amg = (prepare(system, method).solve(load).z for method in ("dct", "amg"))
    assert np.abs(by_dct - by_amg).max() < 1e-7 * np.ptp(by_dct)


def test_the_operator_equals_the_assembled_matrix_and_has_the_stated_stencil():
    system = random_system(np.random.default_rng(0))
    everything = np.ones(system.beta.shape, bool)
    assert np.allclose(dense(system), assemble(system, everything).toarray(), atol=1e-15)
    row = dense(free_system(np.ones((4, 4))))[12].reshape(5, 5)
    expected = np.zeros((5, 5))
    expected[1:4, 1:4] = [[-0.25, -0.5, -0.25], [-0.5, 3, -0.5], [-0.25, -0.5, -0.25]]
    assert np.allclose(row, expected, atol=1e-15)


def test_the_operator_follows_from_the_energy():
    """z^T A z - 2 z^T g + const equals the energy summed face by face."""
    rng = np.random.default_rng(1)
    system = random_system(rng)
    p, q = rng.normal(size=(2, *system.weight.shape))
    load = slope_load(system.weight * p, system.weight * q)
    for z in rng.normal(size=(3, *system.beta.shape)):
        shape = (
            (z * (system.apply(z) - system.beta * z)).sum()
            - 2 * (z * load).sum()
            + (system.weight * (p**2 + q**2)).sum()
        )
        assert energy(z, system.weight, p, q) == pytest.approx(shape, rel=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_random_weights_masks_and_held_vertices_match_a_dense_solve(seed):
    rng = np.random.default_rng(seed)
    system = random_system(rng)
    held_z = rng.normal(size=system.beta.shape)
    load = slope_load(*(system.weight * rng.normal(size=(2, *system.weight.shape)))) + system.beta
    solved = prepare(system, "amg").solve(load, held_z, tolerance=1e-12).z
    unknown = system.unknown.ravel()
    matrix, fixed = dense(system), np.where(system.held, held_z, 0).ravel()
    expected = fixed.copy()
    expected[unknown] = np.linalg.solve(matrix[np.ix_(unknown, unknown)], (load.ravel() - matrix @ fixed)[unknown])
    assert np.allclose(solved.ravel(), expected, atol=1e-9)


def test_islands_are_solved_separately_each_with_mean_zero():
    rows, cols = 30, 80
    x, y = vertices(rows, cols)
    weight = np.zeros((rows, cols))
    weight[3:20, 4:30] = 1
    weight[5:28, 40:75] = 1
    weight[25:28, 2:5] = 1
    z = np.where(x < 35, 1e6 * np.sin(x / 5), 1e-3 * np.cos(x / 6)) + np.where(y < 10, 1e-4 * y, 0) * (x < 10)
    system = free_system(weight)
    labels, count = system.islands()
    assert count == 3
    solution = prepare(system).solve(slope_load(*(weight * s for s in height_slopes(z))))
    for island in range(1, count + 1):
        inside = labels == island
        assert solution.z[inside].mean() == pytest.approx(0, abs=1e-9 * np.ptp(z[inside]))
        error = solution.z[inside] - (z[inside] - z[inside].mean())
        # the small islands lie next to one a billion times higher
        assert np.abs(error).max() < 1e-7 * np.ptp(z[inside])
    assert not solution.z[labels == 0].any()


def test_a_hole_keeps_the_surface_around_it_exact():
    x, y = vertices(50, 50)
    z = 0.02 * (x - 10) ** 2 + 3 * np.sin(y / 7)
    weight = np.ones((50, 50))
    weight[20:30, 15:35] = 0
    solved = prepare(free_system(weight)).solve(slope_load(*(weight * s for s in height_slopes(z)))).z
    on = corner_sum(weight) > 0
    assert np.abs((solved - z)[on] - (solved - z)[on].mean()).max() < 1e-7 * np.ptp(z)


def test_a_free_surface_with_a_hole_converges_for_every_load():
    """Rounding must not let the free constant grow until the tolerance is out of reach, as it did for a load in ten."""
    weight = np.ones((50, 50))
    weight[20:30, 15:35] = 0
    solver = prepare(free_system(weight), "multigrid")
    x, y = vertices(50, 50)
    surface = 0.02 * (x - 10) ** 2 + 3 * np.sin(y / 7)
    load = slope_load(*(weight * slope for slope in height_slopes(surface)))
    solutions = [solver.solve(load * factor) for factor in np.linspace(1, 1.001, 40)]
    assert max(each.residual for each in solutions) <= 1e-8
    assert max(each.iterations for each in solutions) <= 8


@pytest.mark.parametrize("side", [64, 128, 256, 512])
@pytest.mark.parametrize("beta", [1.0, 1e-3, 0.0])
def test_amg_iterations_do_not_grow_with_size(side, beta):
    rng = np.random.default_rng(7)
    weight = blobs(side)
    load = slope_load(*(weight * rng.normal(size=(2, side, side))))
    solution = prepare(free_system(weight, beta), "amg").solve(load)
    assert solution.iterations <= 9
    assert solution.residual <= 1e-8


def test_one_setup_serves_many_right_hand_sides_and_runs_agree_bit_for_bit():
    weight = blobs(96)
    rng = np.random.default_rng(5)
    first, second = (slope_load(*(weight * rng.normal(size=(2, 96, 96)))) for _ in range(2))
    solver = prepare(free_system(weight, 1e-3))
    a, b, both = (solver.solve(load, tolerance=1e-11).z for load in (first, second, first - 2 * second))
    assert np.abs(both - (a - 2 * b)).max() < 1e-9 * np.ptp(both)
    again = prepare(free_system(weight, 1e-3)).solve(first, tolerance=1e-11).z
    assert np.array_equal(a, again)


def test_auto_uses_the_dct_only_where_it_is_exact():
    uniform = free_system(np.full((9, 7), 2.0), 0.3)
    assert choose(uniform, "auto") == "dct"
    masked = np.ones((9, 7))
    masked[4, 4] = 0
    held = np.zeros((10, 8), bool)
    held[0, 0] = True
    beta = corner_sum(np.ones((9, 7)))
    beta[5, 5] *= 2
    for system in (
        free_system(masked, 0.3),
        QuadSystem(np.ones((9, 7)), uniform.beta, held),
        QuadSystem(np.ones((9, 7)), beta, np.zeros_like(held)),
    ):
        assert choose(system, "auto") == "multigrid"
        with pytest.raises(UsageError, match="`solver='dct'`: needs a map without background"):
            prepare(system, "dct")
    with pytest.raises(UsageError, match="use one of auto, dct, multigrid, amg"):
        choose(uniform, "lu")


def test_fully_held_heights_are_returned():
    held_z = np.random.default_rng(2).normal(size=(5, 6))
    system = QuadSystem(np.ones((4, 5)), np.zeros((5, 6)), np.ones((5, 6), bool))
    assert np.array_equal(prepare(system).solve(np.zeros((5, 6)), held_z).z, held_z)


def test_a_flat_load_gives_exactly_flat_heights():
    assert not prepare(free_system(blobs(64), 1e-3)).solve(np.zeros((65, 65))).z.any()


def test_corner_mean_is_the_adjoint_of_corner_sum():
    rng = np.random.default_rng(4)
    faces, corners = rng.normal(size=(5, 8)), rng.normal(size=(6, 9))
    assert (corner_sum(faces) * corners).sum() / 4 == pytest.approx((faces * corner_mean(corners)).sum(), rel=1e-12)


def test_bad_systems_are_named():
    ones, held = np.ones((4, 5)), np.zeros((5, 6), bool)
    with pytest.raises(InputError, match="face weights must be finite and zero or more"):
        QuadSystem(-ones, np.zeros((5, 6)), held)
    with pytest.raises(InputError, match="height weights must be finite and zero or more"):
        QuadSystem(ones, np.full((5, 6), np.nan), held)
    with pytest.raises(InputError, match="every face has weight zero"):
        QuadSystem(0 * ones, np.zeros((5, 6)), held)
    with pytest.raises(InputError, match=r"need height weights and held vertices of shape \(5, 6\)"):
        QuadSystem(ones, np.zeros((4, 5)), held)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_nan_never_reaches_a_solver(bad):
    system = free_system(blobs(64), 1e-3)
    load = np.zeros((65, 65))
    load[30, 30] = bad
    with pytest.raises(InputError, match="right-hand side holds NaN or infinite values"):
        prepare(system).solve(load)
    held_z = np.zeros((65, 65))
    held_z[0, 0] = bad
    with pytest.raises(InputError, match="right-hand side holds NaN"):
        prepare(QuadSystem(blobs(64), system.beta, held_z != 0)).solve(np.zeros((65, 65)), held_z)


def test_not_converging_is_an_error_with_the_history():
    weight = blobs(128)
    load = slope_load(*(weight * np.random.default_rng(0).normal(size=(2, 128, 128))))
    with pytest.raises(
        ConvergenceError, match=r"amg solver stopped at a relative residual of .* after 2 iterations"
    ) as caught:
        prepare(free_system(weight, 1e-3), "amg").solve(load, max_iterations=2)
    assert len(caught.value.history) == 2
    assert caught.value.history[0] > caught.value.history[1] > 1e-8


def test_progress_only_increases():
    seen = []
    weight = blobs(128)
    load = slope_load(*(weight * np.random.default_rng(0).normal(size=(2, 128, 128))))
    prepare(free_system(weight, 1e-3)).solve(load, progress=lambda word, share: seen.append(share))
    assert len(seen) > 2
    assert seen == sorted(seen)
    assert 0 <= seen[0] < seen[-1] <= 1
