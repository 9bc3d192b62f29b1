"""``python -m bench``: lines with goals, the table of all of them, results.md and the table of ratios in README.md."""

import re
from pathlib import Path

import pytest

from bench import __main__ as bench
from bench import page, tasks
from bench.bandwidth import Bandwidth
from bench.checks import HEADER, Check, checks_in, line
from bench.suite import MODULES, QUICK
from docs import readme_tables

ROOT = Path(__file__).parents[1]
STORED = page.RESULTS.read_text(encoding="utf-8")

LINES = {
    line("a solve, to 1e-6", 0.2, 0.12, "s", rival=("pyamg", 2.0), peak=7e7): (
        "check: a solve, to 1e-6: 0.2 s, at most 0.12: MISSED; pyamg 2, x 0.1; peak 0.07 GB",
        Check("a solve, to 1e-6", "0.2 s", "0.12", "MISSED", "pyamg", "2", "0.1", "0.07"),
    ),
    line("a filter: CPU", 1.5, 2, ""): (
        "check: a filter: CPU: 1.5, at most 2: ok",
        Check("a filter: CPU", "1.5", "2", "ok", "", "", "", ""),
    ),
    line("reading", 0.003, None, "s", rival=("SciPy's own", 3e-5)): (
        "check: reading: 0.003 s; SciPy's own 3e-05, x 100",
        Check("reading", "0.003 s", "", "", "SciPy's own", "3e-05", "100", ""),
    ),
    line("its memory", 60.1, 60, "bytes per pixel", rival=("pardiso", None)): (
        "check: its memory: 60.1 bytes per pixel, at most 60: MISSED",
        Check("its memory", "60.1 bytes per pixel", "60", "MISSED", "", "", "", ""),
    ),
    line("another", None, 3, "s"): (
        "check: another: not measured",
        Check("another", "not measured", "", "", "", "", "", ""),
    ),
}


@pytest.mark.parametrize("stated", LINES)
def test_a_line_is_read_back_as_it_was_written(stated):
    text, check = LINES[stated]
    assert stated == text
    assert checks_in(f"before\n{stated}\nafter") == [check]
    assert len(check.cells) == len(HEADER)


def test_every_line_of_the_results_is_understood():
    sections = "\n".join(page.sections_of(STORED).values())
    lines = re.findall(r"^check: .*$", sections, re.MULTILINE)
    assert len(lines) > 20
    assert len(checks_in(sections)) == len(lines)


def test_every_benchmark_is_run():
    reports = {path.stem for path in (ROOT / "bench").glob("*.py") if re.search(r"Report\(\"", path.read_text("utf-8"))}
    assert sorted(MODULES) == sorted(reports)
    assert set(QUICK) <= set(MODULES)


def test_the_page_begins_with_the_lines_of_all_its_sections():
    assert page.page_of(page.sections_of(STORED)) == STORED


def test_a_section_replaces_only_itself(monkeypatch, tmp_path):
    monkeypatch.setattr(page, "RESULTS", tmp_path / "results.md")
    page.write_section("solver", line("a solve", 1, 2, "s"))
    page.write_section("bake", "words\n\n" + line("a filter", 3, 2, "s"))
    page.write_section("solver", line("a solve", 1.5, 2, "s"))
    text = page.RESULTS.read_text(encoding="utf-8")
    assert page.sections_of(text) == {
        "bake": "words\n\ncheck: a filter: 3 s, at most 2: MISSED",
        "solver": "check: a solve: 1.5 s, at most 2: ok",
    }
    rows = [[cell.strip() for cell in row.split("|")[1:5]] for row in re.findall(r"^\| .*$", text, re.MULTILINE)]
    assert rows[2:] == [["bake: a filter", "3 s", "2", "MISSED"], ["solver: a solve", "1.5 s", "2", "ok"]]


def test_the_ratios_in_the_readme_are_those_of_the_results():
    shown = readme_tables.README.read_text(encoding="utf-8").split("<!-- list: speed -->\n")[1].split("<!-- end")[0]
    rows = [tuple(cell.strip() for cell in row.strip("|").split("|")) for row in shown.splitlines()[2:]]
    found = [check for check in checks_in(page.sections_of(STORED)["quick"]) if check.rival]
    assert len(rows) >= 10
    for (task, ours, rival, its, ratio), one in zip(rows, found, strict=True):
        assert (task, rival, ratio) == (one.what, one.rival, one.ratio)
        for shown_ms, seconds in ((ours, one.found.split()[0]), (its, one.its)):
            # as they are rounded
            assert float(shown_ms.removesuffix(" ms")) / 1000 == pytest.approx(float(seconds), rel=0.05, abs=5e-7)
        assert float(ratio) == pytest.approx(float(one.found.split()[0]) / float(one.its), rel=0.06)


@pytest.mark.parametrize(
    ("last", "busy", "said"),
    [
        (
            19e9,
            0.02,
            "unloaded machine: others kept 0.02 cores busy; memory was copied at 20.0 GB/s before the run and 19",
        ),
        (20e9, 0.3, "loaded machine: others kept 0.30 cores busy; "),
        (
            12e9,
            0.0,
            "loaded machine: others kept 0.00 cores busy; memory was copied at 20.0 GB/s before the run and 12.0",
        ),
        (20e9, None, "unloaded machine: the load by other processes is unknown; "),
    ],
)
def test_a_loaded_machine_is_told_from_a_free_one(last, busy, said):
    assert bench.conditions(Bandwidth(20e9, 1), Bandwidth(last, 1), busy).startswith(said)


def test_one_table_ends_a_run_and_a_failed_benchmark_is_in_it(monkeypatch, capsys):
    said = {"relief": (line("a start", 0.2, 0.25, "s"), 0), "bake": (line("a filter", 3, 2, "s"), 1)}
    monkeypatch.setattr(bench, "run", lambda name, more: said[name])
    monkeypatch.setattr(bench, "bandwidth", lambda: Bandwidth(1e10, 1e10))
    monkeypatch.setattr("sys.argv", ["bench", "--only", "relief", "bake"])
    assert bench.main() == 1
    rows = [
        [cell.strip() for cell in row.split("|")[1:5]] for row in capsys.readouterr().out.splitlines() if "|" in row
    ]
    assert rows[0] == list(HEADER[:4])
    assert rows[2:] == [
        ["relief: a start", "0.2 s", "0.25", "ok"],
        ["bake: a filter", "3 s", "2", "MISSED"],
        ["bake", "exit code 1", "", "FAILED"],
    ]


def test_both_clocks_are_read_in_the_same_runs():
    runs = []
    wall, cpu = tasks.best_of_both(lambda: runs.append(sum(range(200_000))), 3)
    assert len(runs) == 3
    assert wall > 0
    assert cpu > 0
    assert tasks.transforms(30, 40, 2) > 0


def test_a_rival_that_is_not_installed_has_no_figure(monkeypatch):
    monkeypatch.setattr(tasks.importlib.util, "find_spec", lambda name: None)
    assert tasks.meshlab_smooth(None, 1) is None
