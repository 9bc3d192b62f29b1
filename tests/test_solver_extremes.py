"""Ragged masks, weights over many decades, and height terms lost in rounding."""

import numpy as np
import pytest
from solver_cases import blobs, free_system

from nmaptool.solver import prepare, slope_load


@pytest.mark.parametrize("kind", ["noise", "lines", "weights"])
@pytest.mark.parametrize("beta", [1e-3, 0.0])
def test_amg_iterations_stay_few_on_ragged_masks_and_weights(kind, beta):
    rng = np.random.default_rng(1)
    weight = np.zeros((128, 128))
    if kind == "noise":
        weight[rng.random(weight.shape) < 0.6] = 1
    elif kind == "lines":
        for row, col in rng.integers(0, 120, (30, 2)):
            weight[row : row + 2, col:] = 1
            weight[row:, col : col + 1] = 1
    else:
        weight[:] = 10.0 ** rng.uniform(-3, 3, weight.shape)
    solution = prepare(free_system(weight, beta), "amg").solve(slope_load(*(weight * rng.normal(size=(2, 128, 128)))))
    assert solution.iterations <= 12
    assert solution.residual <= 1e-8


def test_a_height_term_lost_in_rounding_still_sets_the_level():
    rng = np.random.default_rng(8)
    weight = blobs(64)
    load = slope_load(*(weight * rng.normal(size=(2, 64, 64))))
    shape = prepare(free_system(weight)).solve(load, tolerance=1e-11).z
    system = free_system(weight, 2e-12)
    solver = prepare(system)
    assert solver.islands.floating.sum() == solver.islands.count > 1
    z = solver.solve(load + 30 * system.beta, tolerance=1e-11).z
    labels, count = system.islands()
    for island in range(1, count + 1):
        at = labels == island
        assert np.average(z[at], weights=system.beta[at]) == pytest.approx(30, abs=0.05)
        assert np.ptp((z - shape)[at]) < 1e-8 * np.ptp(shape)
