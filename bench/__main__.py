"""Every benchmark, and all figures with their goals in one table at the end: ``python -m bench [--quick] [--write]``.

With --write, each benchmark stores its section of results.md, and README.md gets the table of ratios.
"""

from __future__ import annotations

import argparse
import dataclasses
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from bench.bandwidth import Bandwidth, bandwidth
from bench.checks import HEADER, MEANING, Check, checks_in, rows_of
from bench.page import write_section
from bench.suite import MODULES, QUICK
from bench.table import Neighborhood, table

_ROOT = Path(__file__).parents[1]
# more than this kept busy by other processes, or a slower copy at one end of the run than this share of the other
_MOST_BUSY, _LEAST_STEADY = 0.1, 0.85


def conditions(first: Bandwidth, last: Bandwidth, busy: float | None) -> str:
    """Whether the machine was unloaded or loaded during the run, and the figures that tell it."""
    steady = min(first.copy, last.copy) >= _LEAST_STEADY * max(first.copy, last.copy)
    copies = f"memory was copied at {first.copy / 1e9:.1f} GB/s before the run and {last.copy / 1e9:.1f} GB/s after it"
    others = "the load by other processes is unknown" if busy is None else f"others kept {busy:.2f} cores busy"
    if steady and (busy is None or busy <= _MOST_BUSY):
        return f"unloaded machine: {others}; {copies}"
    return f"loaded machine: {others}; {copies}. Times are longer than on a free machine; compare ratios"


def run(name: str, more: Sequence[str]) -> tuple[str, int]:
    """Run a benchmark and print what it prints; return it with the exit code."""
    command = [sys.executable, "-u", "-m", f"bench.{name}", *more]
    print(f"== {name}", flush=True)
    said = []
    with subprocess.Popen(command, cwd=_ROOT, stdout=subprocess.PIPE, text=True, encoding="utf-8") as process:
        assert process.stdout is not None
        for printed in process.stdout:
            print(printed, end="", flush=True)
            said.append(printed)
    return "".join(said), process.returncode


def failed(name: str, code: int) -> Check:
    """The row of a benchmark that failed."""
    return Check(name, f"exit code {code}", "", "FAILED", "", "", "", "")


def main() -> int:
    """Run the benchmarks, print all rows; 1 if a benchmark failed. A missed goal is no failure."""
    parser = argparse.ArgumentParser(prog="python -m bench", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="only the figures that matter most, in two minutes")
    parser.add_argument("--only", nargs="+", choices=MODULES, help="only these benchmarks")
    parser.add_argument("--write", action="store_true", help="store the results in results.md and README.md")
    options = parser.parse_args()
    names = QUICK if options.quick else options.only or MODULES
    surroundings, first = Neighborhood("bench"), bandwidth()
    rows: list[Check] = []
    codes = []
    for name in names:
        said, code = run(name, [*MODULES[name], *(["--write"] if options.write else [])])
        codes.append(code)
        rows += [dataclasses.replace(check, what=f"{name}: {check.what}") for check in checks_in(said)]
        if code:
            rows.append(failed(name, code))
    verdict = conditions(first, bandwidth(), surroundings.busy())
    print(f"\n{table(HEADER, rows_of(rows))}\n\n{MEANING}\n\n{surroundings.describe()}\n- {verdict}")
    if options.write:
        from docs.readme_tables import update

        write_section("conditions", f"{surroundings.describe()}\n- {verdict}")
        update()
    return int(any(codes))


if __name__ == "__main__":
    sys.exit(main())
