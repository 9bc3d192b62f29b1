"""One solver on one system in its own process, to separate its memory and limit its time.

The parent calls `measure`. Run as a program, this module is the child: it reads jobs as JSON and prints result lines.
"""

from __future__ import annotations

import dataclasses
import json
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench import peak
from bench.systems import Case, Problem, relative_residual, state, unknowns

_MOST_RUNS = 12


@dataclass(frozen=True)
class Job:
    """A solver, by its name in `bench.rivals.SOLVERS`, on a case: one setup, one solve from zero per tolerance."""

    case: Case
    solver: str
    tolerances: tuple[float, ...]


@dataclass(frozen=True)
class Answer:
    """One solve: seconds, and CPU seconds. ``peak`` is the peak in bytes beyond the inputs, including set-up."""

    solve: float
    iterations: int
    residual: float
    peak: int
    cpu: float = 0.0


@dataclass(frozen=True)
class Outcome:
    """Result of a job: seconds and answers, None for a tolerance that was not reached; or the failure."""

    setup: float = 0.0
    answers: tuple[Answer | None, ...] = ()
    unknowns: int = 0
    failure: str = ""
    setup_cpu: float = 0.0

    def total(self, which: int) -> float | None:
        """Seconds of setup and one solve, if known."""
        answer = None if self.failure else self.answers[which]
        return None if answer is None else self.setup + answer.solve

    def cpu(self, which: int) -> float | None:
        """CPU seconds of setup and one solve, if known."""
        answer = None if self.failure else self.answers[which]
        return None if answer is None else self.setup_cpu + answer.cpu

    @property
    def seconds(self) -> float:
        """Of everything."""
        return self.setup + sum(each.solve for each in self.answers if each is not None)


def child(module: str, limit: float, asked: str = "") -> subprocess.CompletedProcess[str]:
    """Run a module in a new process with text as its standard input; TimeoutExpired after ``limit`` seconds."""
    return subprocess.run(
        [sys.executable, "-m", module],
        check=False,
        input=asked,
        capture_output=True,
        text=True,
        timeout=limit,
        cwd=Path(__file__).parents[1],
    )


def measure(jobs: Sequence[Job], limit: float, spend: float) -> list[Outcome]:
    """Run jobs one after the other in one new process.

    Parameters
    ----------
    jobs : sequence of Job
    limit : float
        Time limit of the process in seconds; jobs not done by then report this as their failure.
    spend : float
        Seconds to spend on repeats of each job; the shortest times count.
    """
    asked = json.dumps({"spend": spend, "jobs": [dataclasses.asdict(job) for job in jobs]})
    late = f"over {limit:.0f} s"
    try:
        done = child("bench.runs", limit, asked)
        stated, left = done.stdout, "out of memory" if done.returncode in (-9, 137) else f"failed: {_last(done.stderr)}"
    except subprocess.TimeoutExpired as stopped:
        printed = stopped.stdout or b""
        stated, left = printed.decode() if isinstance(printed, bytes) else printed, late
    outcomes = [_read(line) for line in stated.splitlines() if line.startswith("{")]
    return outcomes + [Outcome(failure=left)] * (len(jobs) - len(outcomes))


def _last(text: str) -> str:
    return text.strip().rpartition("\n")[2][:80]


def _read(line: str) -> Outcome:
    stated = json.loads(line)
    answers = tuple(None if each is None else Answer(**each) for each in stated["answers"])
    return Outcome(**stated | {"answers": answers})


def _carry_out(job: Job, problem: Problem, spend: float) -> Outcome:
    from bench.rivals import maker
    from nmaptool.core.errors import LimitError, UsageError

    try:
        # a small run first, so that no measured set-up includes one-time loading
        small = state(dataclasses.replace(job.case, rows=48, cols=48))
        maker(job.solver)(small.system)(small.load, 1e-3)
        best = _once(job, problem)
        runs, spent = 1, best.seconds
        while spent < spend and runs < _MOST_RUNS:
            again = _once(job, problem)
            spent += again.seconds
            runs += 1
            best = _better(best, again)
        return best
    except UsageError as error:
        return Outcome(failure="cannot" if job.solver == "dct" and "needs" in str(error) else "not there")
    except ImportError:
        return Outcome(failure="not installed")
    except (MemoryError, LimitError):
        return Outcome(failure="out of memory")


def _better(one: Outcome, other: Outcome) -> Outcome:
    """The shorter time of each part; memory and the rest come from the first run, in the clean process."""
    pairs = zip(one.answers, other.answers, strict=True)
    answers = tuple(
        a and b and dataclasses.replace(a, solve=min(a.solve, b.solve), cpu=min(a.cpu, b.cpu)) for a, b in pairs
    )
    setup, cpu = min(one.setup, other.setup), min(one.setup_cpu, other.setup_cpu)
    return dataclasses.replace(one, setup=setup, setup_cpu=cpu, answers=answers)


def _once(job: Job, problem: Problem) -> Outcome:
    from bench.rivals import maker
    from nmaptool.core.errors import ConvergenceError

    system = dataclasses.replace(problem.system)  # a new one has no caches from an earlier solver
    answers: list[Answer | None] = []
    before = peak.begin()
    started, used = time.perf_counter(), time.process_time()
    solve = maker(job.solver)(system)
    setup, setup_cpu = time.perf_counter() - started, time.process_time() - used
    most = peak.peak() - before
    for tolerance in job.tolerances:
        peak.begin()
        started, used = time.perf_counter(), time.process_time()
        try:
            z, iterations = solve(problem.load, tolerance)
        except ConvergenceError:
            answers.append(None)
            continue
        seconds, cpu = time.perf_counter() - started, time.process_time() - used
        most = max(most, peak.peak() - before)
        answers.append(Answer(seconds, iterations, relative_residual(problem, z), most, cpu))
        del z
    return Outcome(setup, tuple(answers), int(unknowns(system).sum()), setup_cpu=setup_cpu)


def main() -> None:
    """The child process."""
    asked: dict[str, Any] = json.load(sys.stdin)
    stated: tuple[Case, Problem] | None = None
    for entry in asked["jobs"]:
        job = Job(Case(**entry["case"]), entry["solver"], tuple(entry["tolerances"]))
        if stated is None or stated[0] != job.case:
            stated = None  # free the old one before making the new one
            stated = job.case, state(job.case)
        outcome = _carry_out(job, stated[1], asked["spend"])
        print(json.dumps(dataclasses.asdict(outcome)), flush=True)


if __name__ == "__main__":
    main()
