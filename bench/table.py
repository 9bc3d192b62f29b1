"""Layout of results: tables, and the description of the machine."""

from __future__ import annotations

import os
import platform
import re
import shlex
import sys
import time
from collections.abc import Sequence
from datetime import date
from importlib.metadata import version
from pathlib import Path

from bench.checks import line as line

_PACKAGES = ("numpy", "scipy", "pyamg")


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table with aligned columns; the first column is text, the others are right-aligned."""
    widths = [max(len(cell) for cell in column) for column in zip(header, *rows, strict=True)]
    rule = ["-" * widths[0], *("-" * (width - 1) + ":" for width in widths[1:])]

    def line(cells: Sequence[str]) -> str:
        padded = [cells[0].ljust(widths[0]), *(c.rjust(w) for c, w in zip(cells[1:], widths[1:], strict=True))]
        return f"| {' | '.join(padded)} |"

    return "\n".join([line(header), line(rule), *(line(row) for row in rows)])


class Neighborhood:
    """The conditions of a run, from its start to `describe`: machine, versions, and load by other processes.

    Parameters
    ----------
    module : str
        The benchmark, such as "bench.solver".
    """

    def __init__(self, module: str) -> None:
        self._command = shlex.join(["python", "-m", module, *sys.argv[1:]])
        self._started = time.perf_counter()
        self._others = _seconds_of_others()

    def describe(self) -> str:
        """Markdown lines that describe the run."""
        packages = ", ".join(f"{name} {version(name)}" for name in _PACKAGES)
        return "\n".join(
            [
                f"- {date.today().isoformat()}: `{self._command}`",
                f"- Python {platform.python_version()}, {packages}",
                f"- {cpu_model()}, {os.cpu_count()} cores; {self._others_now()}",
            ]
        )

    def busy(self) -> float | None:
        """Cores that other processes kept busy on average; None if the system does not tell."""
        now = _seconds_of_others()
        if now is None or self._others is None:
            return None
        return max(now - self._others, 0.0) / (time.perf_counter() - self._started)

    def _others_now(self) -> str:
        busy, wall = self.busy(), time.perf_counter() - self._started
        if busy is None:
            return "this system does not report the load by other processes"
        return f"other processes kept {busy:.2f} cores busy on average during the {wall:.0f} s of the run"


def _seconds_of_others() -> float | None:
    """CPU seconds so far of all processes except this one and its finished children; None if unknown."""
    stat = Path("/proc/stat")
    if not stat.exists():
        return None
    user, nice, system, _idle, _iowait, irq, softirq, steal = map(int, stat.read_text(encoding="utf-8").split()[1:9])
    busy = (user + nice + system + irq + softirq + steal) / os.sysconf("SC_CLK_TCK")
    own = os.times()
    return busy - (own.user + own.system + own.children_user + own.children_system)


def cpu_model() -> str:
    """Name of the processor."""
    info = Path("/proc/cpuinfo")
    named = re.search(r"^model name\s*:\s*(.+)$", info.read_text(encoding="utf-8"), re.M) if info.exists() else None
    return named[1] if named else platform.machine()
