"""Time, memory and disk space of large maps, calculated from bench/results.md: ``python -m docs.large_map_table``.

Replaces the table between the marks in docs/large_maps.md; with ``--check`` only tells whether it is up to date.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

from nmaptool.tiled.planning import Plan, plan

ROOT = Path(__file__).resolve().parent.parent
_PAGE = ROOT / "docs" / "large_maps.md"
_MARKS = "<!-- table of sizes -->\n", "<!-- end of the table -->\n"
# the run that times are calculated from: its side in px, and the memory that it was given
_SIDE, _MEMORY = 16384, 4_000_000_000
# side in px, and the memory of the machine that runs the command with two workers
_SIZES = ((32768, 8e9), (100_000, 32e9), (316_000, 64e9), (1_000_000, 128e9))
_WORKERS = 64


def _minutes_per_gigapixel() -> float:
    """Minutes per gigapixel of the measured run, on two workers."""
    row = re.search(rf"^\| {_SIDE} px, .*$", (ROOT / "bench" / "results.md").read_text(encoding="utf-8"), re.M)
    if row is None:
        raise SystemExit("bench/results.md has no such run: python -m bench.tiled --write")
    return float(row[0].split("|")[4])


def _hours(side: int, how: Plan, workers: int) -> float:
    measured = plan(_SIDE, _SIDE, 2, _MEMORY)
    share = how.work * max(1, how.workers) / (measured.work * measured.workers)
    return _minutes_per_gigapixel() * 2 * share * side * side / 1e9 / workers / 60


def _time(hours: float) -> str:
    if hours < 2:
        return f"{60 * hours:.0f} min"
    return f"{hours:.0f} h" if hours < 72 else f"{hours / 24:.0f} days"


def _size(count: int) -> str:
    return f"{count / 1e9:.3g} GB" if count < 1e12 else f"{count / 1e12:.3g} TB"


def table() -> str:
    """The table as Markdown."""
    head = ("map", "2 workers", f"{_WORKERS} workers", "tile px", "overlap px", "coarse face px")
    memory_head = ("memory of a worker", "memory of the coarse grid", "work folder")
    rows: list[tuple[str, ...]] = [(*head, *memory_head), ("---",) * (len(head) + len(memory_head))]
    for side, memory in _SIZES:
        how = plan(side, side, 2, int(memory))
        grid = how.grid
        times = (_time(_hours(side, how, workers)) for workers in (2, _WORKERS))
        sizes = (_size(size) for size in (how.worker_bytes, how.coarse_bytes, how.disk_bytes))
        cut = (f"{length}" for length in (grid.tile, grid.overlap, grid.factor))
        rows.append((f"{side * side / 1e9:.0f} Gpx", *times, *cut, *sizes))
    lines = [f"| {' | '.join(row)} |" for row in rows]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Update the table."""
    page = _PAGE.read_text(encoding="utf-8")
    before, rest = page.split(_MARKS[0])
    _, after = rest.split(_MARKS[1])
    made = f"{before}{_MARKS[0]}\n{table()}\n{_MARKS[1]}{after}"
    if "--check" in sys.argv:
        raise SystemExit(0 if made == page else f"{_PAGE.name}: out of date; run python -m docs.large_map_table")
    _PAGE.write_text(made, encoding="utf-8")


if __name__ == "__main__":
    main()
