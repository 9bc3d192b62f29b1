"""A solve works on the box around its unknown vertices only, and gives the heights of the whole picture."""

from __future__ import annotations

import numpy as np
import pytest

from nmaptool.core.errors import InputError, LimitError
from nmaptool.core.grid import touching_vertices
from nmaptool.solver import QuadSystem, prepare, slope_load
from nmaptool.solver.islands import Islands
from nmaptool.solver.multigrid.method import MultigridMethod
from nmaptool.solver.solve import Solver
from nmaptool.solver.window import Window, window_of

SHAPE = (500, 700)


def motif():
    """A disc of 60 px radius with a hole, far from the edges of the picture."""
    rows, cols = np.ogrid[: SHAPE[0], : SHAPE[1]]
    away = np.hypot(rows - 250, cols - 430)
    return (away < 60) & (np.hypot(rows - 240, cols - 420) > 9)


def problem(background):
    random = np.random.default_rng(5)
    inside = motif()
    weight = inside.astype(np.float32)
    held = touching_vertices(~inside) if background == "plane" else np.zeros((SHAPE[0] + 1, SHAPE[1] + 1), bool)
    beta = np.zeros(held.shape, np.float32)
    beta[touching_vertices(inside)] = 1e-3
    load = slope_load(*(weight * random.normal(size=SHAPE) for _ in range(2))) + 20.0 * beta
    return QuadSystem(weight, beta, held), load


def without_window(system):
    whole = Window(slice(0, SHAPE[0] + 1), slice(0, SHAPE[1] + 1), system.held)
    return Solver(whole, system, MultigridMethod(system), Islands(system))


@pytest.mark.parametrize("background", ["plane", "cut"])
def test_the_heights_and_iterations_are_those_of_the_whole_picture(background):
    system, load = problem(background)
    held_z = np.random.default_rng(6).normal(size=load.shape) if background == "plane" else None
    solver = prepare(system, "multigrid")
    found = solver.solve(load, held_z)
    expected = without_window(system).solve(load, held_z)
    assert np.abs(found.z - expected.z).max() < 1e-6 * np.ptp(expected.z)
    assert found.iterations == expected.iterations
    assert np.array_equal(found.z[~system.unknown], expected.z[~system.unknown])
    again = solver.solve(load, held_z, start=found.z)
    assert again.iterations == 0


def test_the_box_holds_all_unknown_vertices_and_little_else():
    system, _ = problem("cut")
    window = window_of(system)
    outside = system.unknown.copy()
    outside[window.rows, window.cols] = False
    assert system.unknown.any()
    assert not outside.any()
    # 120 px across, and up to 64 more at the upper left
    assert (window.rows.start, window.cols.start) == (128, 320)
    assert (window.rows.stop, window.cols.stop) == (312, 492)
    assert prepare(system, "multigrid").system.weight.shape == (183, 171)


def test_a_motif_that_fills_its_picture_is_not_copied():
    weight = np.ones((200, 200), np.float32)
    weight[:3] = 0
    system = QuadSystem(weight, np.full((201, 201), 1e-3, np.float32), np.zeros((201, 201), bool))
    window = window_of(system)
    assert window.is_whole
    assert window.system(system) is system


@pytest.mark.parametrize("which", ["load", "held_z", "start"])
def test_values_outside_the_box_must_be_finite_too(which):
    system, load = problem("plane")
    given = {"load": load, "held_z": np.zeros(load.shape), "start": np.zeros(load.shape)}
    given[which][3, 5] = np.nan
    said = "the start heights must be finite" if which == "start" else "the right-hand side holds NaN"
    with pytest.raises(InputError, match=said):
        prepare(system, "multigrid").solve(**given)


def test_the_planned_memory_is_that_of_the_box():
    system, _ = problem("cut")
    solver = prepare(system, "multigrid")
    assert solver.planned_bytes == prepare(window_of(system).system(system), "multigrid").planned_bytes
    with pytest.raises(LimitError, match="memory"):
        solver.check_memory(solver.planned_bytes - 1)
    solver.check_memory(solver.planned_bytes)
