"""The systems on which the benchmark measures solvers, and its checks of their results."""

import dataclasses

import numpy as np
import pytest

from bench.patience import Patience
from bench.reach import checks
from bench.rivals import SOLVERS
from bench.runs import Job, Outcome, measure
from bench.systems import Case, relative_residual, state, unknowns
from bench.table import line

CASES = (
    Case(30, 40, "statue"),
    Case(40, 40, "hair", "plane"),
    Case(40, 40, "islands", "cut", 0.0),
    Case(40, 40, "tree", "free", weights="span 1e4"),
    Case(300, 20, "full", weights="mu map"),
)


@pytest.mark.parametrize("case", CASES, ids=str)
def test_the_residual_matches_that_of_the_operator(case):
    problem = state(case)
    system = problem.system
    np.testing.assert_array_equal(unknowns(system), system.unknown)
    z = np.where(system.held, 0, np.random.default_rng(0).standard_normal(problem.load.shape))
    left = np.where(system.unknown, problem.load - system.apply(z), 0)
    expected = np.linalg.norm(left) / np.linalg.norm(problem.load[system.unknown])
    assert relative_residual(problem, z) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("name", ["amg", "dct + CG", "aggregation", "superlu", "Jacobi-CG"])
def test_every_rival_solves_the_systems(name):
    for case in CASES:
        problem = state(case)
        z, iterations = SOLVERS[name](dataclasses.replace(problem.system))(problem.load, 1e-9)
        assert relative_residual(problem, z) < 2e-8, case
        assert iterations > 0


def test_a_job_in_its_own_process_reports_time_and_memory():
    case = Case(64, 64)
    (outcome,) = measure([Job(case, "amg", (1e-6, 1e-10))], 60, 0)
    assert not outcome.failure
    assert outcome.unknowns == int(state(case).system.unknown.sum())
    assert [answer.residual <= most for answer, most in zip(outcome.answers, (1e-6, 1e-10), strict=True)] == [True] * 2
    assert outcome.total(0) > outcome.setup > 0
    assert outcome.answers[1].peak >= outcome.answers[0].peak


def test_failed_jobs_state_their_reason():
    found = measure([Job(Case(48, 48), "dct", (1e-6,)), Job(Case(48, 48, "full"), "dct", (1e-6,))], 60, 0)
    assert [outcome.failure for outcome in found] == ["cannot", ""]
    assert measure([Job(Case(48, 48), "amg", (1e-6,))], 0.01, 0)[0].failure == "over 0 s"


def test_jobs_that_would_take_too_long_are_left_out():
    patience = Patience(limit=10)
    case = Case(100, 100)
    assert not patience.lacks(case, "amg")
    patience.learn(case, "amg", Outcome(setup=1.0, answers=(None,)))
    assert not patience.lacks(Case(300, 300), "amg")
    assert patience.lacks(Case(400, 400), "amg")
    assert patience.lacks(Case(400, 400, "tree"), "amg")
    assert not patience.lacks(Case(400, 400), "dct")


def test_goals_are_checked_against_their_limits():
    assert line("this", 1.5, 2, "s") == "check: this: 1.5 s, at most 2: ok"
    assert line("this", 2.5, 2, "s").endswith("MISSED")
    assert all(stated.endswith("not measured") for stated in checks({}))
