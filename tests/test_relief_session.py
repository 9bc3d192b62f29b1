"""A session gives the results of single reliefs, with no more iterations than needed."""

import dataclasses
import itertools
import threading

import numpy as np
import pytest
from relief_cases import dome, normal_map, rolling

import nmaptool as nm
from nmaptool.core.errors import ConvergenceError, InputError, LimitError, UsageError
from nmaptool.core.grid import height_slopes
from nmaptool.solver import Solver

SIDE = 64
START = nm.ReliefOptions(mu=0.4, beta=0.004, delta=12.0, height=nm.length("5mm"))
# a change of each option, and whether it requires a new solve
CHANGES = {
    "mu": ({"mu": 0.9}, True),
    "beta": ({"beta": 0.006}, True),
    "delta": ({"delta": 20.0}, False),
    "background": ({"background": "cut"}, True),
    "slope_cap": ({"slope_cap": 0.4}, True),
    "edge": ({"edge": "wall"}, True),
    "edge_height": ({"edge": "wall", "edge_height": nm.length("4.5mm")}, True),
    "outline_round": ({"background": "cut", "outline_round": nm.length("6mm")}, True),
    "energy": ({"energy": "eq4"}, True),
    "per_pixel": ({"per_pixel": True}, True),
    "height": ({"height": nm.length("7mm")}, False),
    "fit": ({"fit": "slope"}, False),
    "width": ({"width": nm.length("50mm")}, False),
    "solver": ({"solver": "amg"}, False),  # the solution is already known
    "tolerance": ({"tolerance": 1e-7}, False),
    "max_iterations": ({"max_iterations": 50}, False),
    "memory_limit": ({"memory_limit": "1GB"}, False),
}


@pytest.fixture(scope="module")
def maps():
    original, _, detail = dome(SIDE, bumps=1)
    return original, detail


def assert_same(found, fresh, within=1e-6):
    assert np.abs(found.z_mm - fresh.z_mm).max() <= within * np.ptp(fresh.z_mm)
    assert np.array_equal(found.mask, fresh.mask)
    assert np.array_equal(found.foreground, fresh.foreground)
    assert found.height.frame == fresh.height.frame
    seen, expected = (dataclasses.asdict(r.report) for r in (found, fresh))
    for name in ("residual", "iterations", "history", "seconds"):
        seen.pop(name), expected.pop(name)
    assert seen.pop("warnings") == expected.pop("warnings")
    for name, value in expected.items():
        assert seen[name] == (pytest.approx(value, rel=1e-5, abs=1e-8) if isinstance(value, float) else value), name


def warmed(*maps, **given):
    """A session that has already solved both parts of START."""
    session = nm.ReliefSession(*maps, **given)
    session.solve(dataclasses.replace(START, delta=3.0))
    session.solve(START)
    return session


@pytest.mark.parametrize("field", [field.name for field in dataclasses.fields(nm.ReliefOptions)])
def test_every_option_that_changes_gives_what_a_fresh_relief_gives(field, maps):
    change, needs_solver = CHANGES[field]
    options = dataclasses.replace(START, **change)
    assert getattr(options, field) != getattr(START, field)
    session = warmed(*maps)
    found = session.solve(options)
    assert_same(found, nm.relief(*maps, options=options))
    assert (found.report.iterations > 0) == needs_solver
    assert found.report.residual <= options.tolerance
    assert (found.report.history == ()) == (not needs_solver)
    # and back
    assert_same(session.solve(START), nm.relief(*maps, options=START))


def test_the_first_solve_equals_relief(maps):
    for change, _ in CHANGES.values():
        options = dataclasses.replace(START, **change)
        found, fresh = nm.ReliefSession(*maps).solve(options), nm.relief(*maps, options=options)
        assert_same(found, fresh, within=0)
        assert found.report.history == fresh.report.history


@pytest.mark.parametrize("field", ["tolerance", "max_iterations", "memory_limit", "width"])
def test_options_without_effect_on_the_solve_keep_the_heights(field, maps):
    options = dataclasses.replace(START, **CHANGES[field][0])
    session = nm.ReliefSession(*maps)
    session.solve(START)
    found = session.solve(options)
    assert found.report.iterations == 0
    exact = nm.relief(*maps, options=dataclasses.replace(options, tolerance=START.tolerance))
    assert np.array_equal(found.z_mm, exact.z_mm)


def test_a_relief_solves_once_and_a_new_delta_once_more(maps, monkeypatch):
    calls = []
    solve = Solver.solve
    monkeypatch.setattr(Solver, "solve", lambda self, *a, **k: calls.append(1) or solve(self, *a, **k))
    nm.relief(*maps, options=START)
    assert len(calls) == 1
    session = nm.ReliefSession(*maps)
    session.solve(START)
    session.solve(dataclasses.replace(START, height=None))
    assert len(calls) == 2
    for delta in (1.0, 0.0, -8.0, 300.0):
        session.solve(dataclasses.replace(START, delta=delta))
    assert len(calls) <= 4
    session.solve(dataclasses.replace(START, fit="delta"))
    assert len(calls) <= 4


@pytest.mark.parametrize("background", ["plane", "cut", "free"])
@pytest.mark.parametrize("solver", ["auto", "amg"])
def test_any_sequence_of_deltas_gives_the_relief_of_each(background, solver):
    original = dome(SIDE, bumps=1, kind="masked" if solver == "amg" else "full")[0]
    session = nm.ReliefSession(original)
    for delta in (10.0, 0.0, -25.0, 1e3, 1e-3, 10.0):
        options = nm.ReliefOptions(delta=delta, background=background, solver=solver, tolerance=1e-9)
        found = session.solve(options)
        assert_same(found, nm.relief(original, options=options))
        assert found.report.residual <= 1e-9


def test_a_tighter_tolerance_is_respected(maps):
    session = nm.ReliefSession(*maps)
    for delta in (3.0, 12.0):
        session.solve(dataclasses.replace(START, tolerance=1e-3, delta=delta))
    for tolerance in (1e-6, 1e-12):
        options = dataclasses.replace(START, tolerance=tolerance)
        found = session.solve(options)
        assert found.report.iterations > 0
        assert found.report.residual <= tolerance
        again = session.solve(dataclasses.replace(options, delta=5.0))
        assert again.report.residual <= tolerance
    exact = nm.relief(*maps, options=dataclasses.replace(options, solver="amg"))
    assert_same(dataclasses.replace(found, report=exact.report), exact, within=1e-9)


def test_a_delta_whose_load_nearly_cancels_that_of_the_slopes_is_solved():
    """The slopes of a parabola give a constant load, which one delta cancels except at the edges."""
    row, col = np.mgrid[0 : SIDE + 1, 0 : SIDE + 1] - SIDE / 2
    inside = np.zeros((SIDE, SIDE), bool)
    inside[8:-8, 8:-8] = True
    bowl = normal_map(*height_slopes(0.004 * (row**2 + col**2)), inside)
    session = nm.ReliefSession(bowl)
    beta = 0.01
    gone = 4 * 0.004 / beta
    for delta in (gone / 3, gone * 0.9, gone, gone * (1 + 1e-7), 2 * gone):
        options = nm.ReliefOptions(beta=beta, delta=delta, per_pixel=True)
        found = session.solve(options)
        fresh = nm.relief(bowl, options=options)
        assert found.report.residual <= options.tolerance
        assert np.abs(found.z_mm - fresh.z_mm).max() < 1e-6 * max(np.ptp(fresh.z_mm), 1e-3)


def test_a_flat_map_and_zero_beta_are_solved():
    flat = normal_map(*np.zeros((2, 20, 20)))
    session = nm.ReliefSession(flat)
    for delta in (5.0, 10.0, 0.0):
        assert np.allclose(session.solve(nm.ReliefOptions(delta=delta)).z_mm, delta * 0.02 * 5, atol=1e-9)
    original = dome(SIDE)[0]
    session = nm.ReliefSession(original)
    heights = [session.solve(nm.ReliefOptions(beta=0.0, delta=d)).z_mm for d in (5.0, 10.0, 30.0)]
    assert np.array_equal(heights[1], heights[2])
    assert np.abs(heights[0] - heights[1]).max() < 1e-6 * np.ptp(heights[0])


def test_weight_maps_and_a_mask_are_respected(maps):
    rng = np.random.default_rng(3)
    given = {f"{name}_map": rng.random((SIDE, SIDE), np.float32) for name in ("mu", "beta", "delta")}
    given["mask"] = dome(SIDE)[0].foreground
    session = nm.ReliefSession(*maps, **given)
    for change in ({}, {"delta": 20.0}, {"mu": 0.9}, {"beta": 0.006, "delta": 3.0}, {"fit": "delta"}):
        options = dataclasses.replace(START, **change)
        assert_same(session.solve(options), nm.relief(*maps, **given, options=options))


@pytest.mark.parametrize("as_height", [True, False])
def test_a_curved_background_is_respected(as_height):
    roll, motif = rolling(SIDE), dome(SIDE)[0].foreground
    background = normal_map(*height_slopes(roll))
    if as_height:
        background = nm.Height(roll * 100 / SIDE, np.ones((SIDE, SIDE), bool), nm.Frame(SIDE, SIDE, 100 / SIDE))
    original = dome(SIDE, bumps=1, kind="full")[0]
    session = nm.ReliefSession(original, mask=motif, surface=background)
    start = nm.ReliefOptions(background="surface", beta=0.002)
    for change in ({}, {"delta": 10.0}, {"delta": -3.0}, {"height": "3mm"}, {"height": "3mm", "fit": "slope"},
                   {"slope_cap": 0.5}, {"tolerance": 1e-11}, {"beta": 0.02}):  # fmt: skip
        options = dataclasses.replace(start, **change)
        fresh = nm.relief(original, mask=motif, surface=background, options=options)
        assert_same(session.solve(options), fresh)
    with pytest.raises(UsageError, match="`surface`: needs `background='surface'`, found plane"):
        session.solve(nm.ReliefOptions())


def test_later_solves_do_not_change_earlier_results(maps):
    before = [m.normals.copy() for m in maps]
    session = nm.ReliefSession(*maps)
    options = [dataclasses.replace(START, **change) for change, _ in CHANGES.values()]
    results = [session.solve(o) for o in options for _ in range(2)]
    kept = [r.z_mm.copy() for r in results]
    for o in reversed(options):
        session.solve(o)
    for result, copy in zip(results, kept, strict=True):
        assert np.array_equal(result.z_mm, copy)
        for array in (result.z_mm, result.mask, result.foreground):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 0
    for first, second in itertools.pairwise(results):
        assert not np.shares_memory(first.z_mm, second.z_mm)
    for each, copy in zip(maps, before, strict=True):
        assert np.array_equal(each.normals, copy)


def test_the_latest_settings_are_cached(maps):
    one, two, three = (dataclasses.replace(START, beta=beta) for beta in (0.003, 0.004, 0.005))

    def iterations(session, *options):
        return [session.solve(o).report.iterations > 0 for o in options]

    assert iterations(nm.ReliefSession(*maps), one, two, one, two) == [True, True, False, False]
    assert iterations(nm.ReliefSession(*maps), one, two, three, one) == [True] * 4
    assert iterations(nm.ReliefSession(*maps, keep=3), one, two, three, one) == [True, True, True, False]
    assert iterations(nm.ReliefSession(*maps, keep=1), one, two, one, one) == [True, True, True, False]
    assert iterations(nm.ReliefSession(*maps, keep=0), one, one) == [True, True]
    with pytest.raises(UsageError, match="`keep=-1`: must be zero or more"):
        nm.ReliefSession(*maps, keep=-1)


class StoppedError(Exception):
    pass


@pytest.mark.parametrize("after", [0, 1, 2])
def test_an_interrupted_solve_does_no_harm(after, maps):
    def progress(word, share):
        nonlocal left
        left -= 1
        if left < 0:
            raise StoppedError

    session = warmed(*maps)
    for options in (dataclasses.replace(START, beta=0.01), dataclasses.replace(START, tolerance=1e-11)):
        left = after
        with pytest.raises(StoppedError):
            session.solve(options, progress=progress)
        assert_same(session.solve(options), nm.relief(*maps, options=options))
    assert_same(session.solve(START), nm.relief(*maps, options=START))


def test_a_solve_that_fails_does_no_harm(maps):
    session = nm.ReliefSession(*maps)
    short = dataclasses.replace(START, max_iterations=1, tolerance=1e-12)
    with pytest.raises(ConvergenceError, match="raise `max_iterations`"):
        session.solve(short)
    for tight in (dataclasses.replace(START, memory_limit="100kB"), dataclasses.replace(short, memory_limit="100kB")):
        for each in (session, nm.ReliefSession(*maps)):
            with pytest.raises(LimitError, match="`memory_limit` allows 0MB"):
                each.solve(tight)
    too_low = dataclasses.replace(START, height=nm.length("0.01mm"), fit="delta")
    with pytest.raises(InputError, match=r"`height='0.01mm'`: changing delta alone gives at least"):
        session.solve(too_low)
    found = session.solve(dataclasses.replace(START, delta=1.0))
    assert_same(found, nm.relief(*maps, options=dataclasses.replace(START, delta=1.0)))
    assert found.report.iterations == 0  # the parts of the failed solve are kept


def test_several_threads_may_solve(maps):
    session = nm.ReliefSession(*maps)
    wanted = [dataclasses.replace(START, beta=beta, delta=delta) for beta in (0.003, 0.006) for delta in (4.0, 9.0)]
    found = {}
    threads = [threading.Thread(target=lambda o=o: found.update({o: session.solve(o)})) for o in wanted * 2]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for options in wanted:
        assert_same(found[options], nm.relief(*maps, options=options))


def test_solving_from_the_progress_callback_is_refused(maps):
    session = nm.ReliefSession(*maps)

    def ask(word, share):
        session.solve()

    with pytest.raises(nm.UsageError, match="a session cannot solve inside its own progress callback"):
        session.solve(START, progress=ask)
    assert session.solve(START).report.residual <= START.tolerance
