"""Large maps: what goes wrong is one line, nothing is lost, and a later run goes on."""

from __future__ import annotations

import dataclasses
import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nmaptool as nm
from nmaptool.io.stores.work import WorkFolder
from nmaptool.options import ReadOptions, ReliefFiles, ReliefOptions, TilingOptions
from nmaptool.tiled.inputs import open_sources
from nmaptool.tiled.planning import plan
from tests.tiled_cases import COLS, ROWS, WIDTH, Case, store, waves

pytest.importorskip("zarr")

_OPTIONS = ReliefOptions(width=WIDTH, height=nm.length("3mm"))


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> Case:
    """The stores of the case."""
    return Case(tmp_path_factory.mktemp("case"))


def _relief(case: Case, output: Path, options: ReliefOptions = _OPTIONS, **more: Any) -> Any:
    settings: dict[str, Any] = {"tiling": TilingOptions(tile=128, workers=0), **more}
    return nm.tiled.relief(case.original, str(output), options, settings.pop("files", case.masked), **settings)


def _bytes(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


class _StopError(Exception):
    """Raised by a test to stop a run."""


def _stop_at(stage: str, share: float) -> Any:
    def progress(word: str, done: float) -> None:
        if word == stage and done >= share:
            raise _StopError

    return progress


@pytest.mark.parametrize(
    ("stage", "share"), [("reading maps", 0.3), ("solving", 0.1), ("solving", 0.5), ("writing heights", 0.4)]
)
def test_a_stopped_run_goes_on_to_the_same_bytes(case: Case, tmp_path: Path, stage: str, share: float) -> None:
    _relief(case, tmp_path / "whole.zarr")
    with pytest.raises(_StopError):
        _relief(case, tmp_path / "heights.zarr", progress=_stop_at(stage, share))
    assert not (tmp_path / "heights.zarr").exists()
    found = _relief(case, tmp_path / "heights.zarr")
    assert found.resumed > 0
    assert _bytes(tmp_path / "heights.zarr") == _bytes(tmp_path / "whole.zarr")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["heights.zarr", "whole.zarr"]


def test_other_options_start_afresh(case: Case, tmp_path: Path) -> None:
    with pytest.raises(_StopError):
        _relief(case, tmp_path / "heights.zarr", progress=_stop_at("solving", 0.1))
    found = _relief(case, tmp_path / "heights.zarr", dataclasses.replace(_OPTIONS, delta=10))
    assert found.resumed == 0
    assert found.relief.options.delta == 10


def test_a_damaged_record_is_done_again(case: Case, tmp_path: Path) -> None:
    _relief(case, tmp_path / "whole.zarr")
    with pytest.raises(_StopError):
        _relief(case, tmp_path / "heights.zarr", progress=_stop_at("solving", 0.1))
    records = sorted((tmp_path / "heights.zarr.work" / "assembled").iterdir())
    records[3].write_bytes(records[3].read_bytes()[:-9])
    _relief(case, tmp_path / "heights.zarr")
    assert _bytes(tmp_path / "heights.zarr") == _bytes(tmp_path / "whole.zarr")


def test_a_damaged_chunk_of_the_work_folder_is_named(case: Case, tmp_path: Path) -> None:
    with pytest.raises(_StopError):
        _relief(case, tmp_path / "heights.zarr", progress=_stop_at("solving", 0.1))
    chunk = tmp_path / "heights.zarr.work" / "weight" / "c" / "1" / "2"
    chunk.write_bytes(b"no chunk")
    with pytest.raises(nm.InputError, match=r"work: a chunk of weight is missing or damaged .*; remove the folder"):
        _relief(case, tmp_path / "heights.zarr")


def test_a_missing_chunk_of_the_map_is_named(tmp_path: Path) -> None:
    name = store(tmp_path / "map.zarr", waves(256, 256), ("R", "G", "B"))
    next((tmp_path / "map.zarr" / "c" / "1").rglob("*/0")).unlink()
    with pytest.raises(nm.InputError, match=r"map\.zarr: .*chunk"):
        nm.tiled.relief(name, str(tmp_path / "heights.zarr"), tiling=TilingOptions(tile=64, workers=0))
    assert not (tmp_path / "heights.zarr").exists()


def test_a_map_that_changes_meanwhile_is_refused(tmp_path: Path) -> None:
    name = store(tmp_path / "map.zarr", waves(128, 128), ("R", "G", "B"))
    sources = open_sources(name, ReliefFiles(), ReadOptions())
    sources.check_unchanged()
    os.utime(next(path for path in (tmp_path / "map.zarr" / "c").rglob("*") if path.is_file()), (1, 1))
    with pytest.raises(nm.InputError, match=r"map\.zarr: changed while it was read; wait until it is complete"):
        sources.check_unchanged()


def test_two_runs_on_one_output_are_refused(case: Case, tmp_path: Path) -> None:
    folder = WorkFolder(str(tmp_path / "heights.zarr.work"))
    with (
        folder.locked(),
        pytest.raises(nm.OutputError, match=rf"another run uses it \(process {os.getpid()} on .*\); wait for it"),
    ):
        _relief(case, tmp_path / "heights.zarr")
    _relief(case, tmp_path / "heights.zarr")


def test_the_lock_of_a_dead_process_does_not_count(tmp_path: Path) -> None:
    ended = subprocess.run([sys.executable, "-c", "import os; print(os.getpid())"], capture_output=True, check=True)
    folder = WorkFolder(str(tmp_path / "work"))
    with folder.locked() as mine:
        lock = tmp_path / "work" / "lock"
        host = lock.read_text().split()[0]
        lock.write_text(f"{host} {int(ended.stdout)} 0")
        with pytest.raises(nm.OutputError, match="another run has taken over; what is finished is kept"):
            mine.put("step/0_0", {"a": np.zeros(2)})
        with folder.locked() as other:
            other.put("step/0_0", {"a": np.ones(2)})
    assert folder.known("step", type("Place", (), {"row": 0, "col": 0}))["a"].tolist() == [1, 1]


@pytest.mark.parametrize(
    ("error", "match", "change"),
    [
        (nm.OutputError, r"heights\.zarr: already exists", {"exists": True}),
        (
            nm.UsageError,
            r"is written to a Zarr store, such as -o map\.zarr",
            {"name": "h.tif"},
        ),
        (nm.OutputError, r"the folder .* does not exist; create it first", {"name": "no/h.zarr"}),
        (nm.UsageError, r"`edge='wall'`: walls are not available", {"options": {"edge": "wall"}}),
        (nm.UsageError, r"`background='surface'` and `surface` go together", {"options": {"background": "surface"}}),
        (nm.UsageError, r"`solver='dct'`: needs the whole picture", {"options": {"solver": "dct"}}),
        (nm.UsageError, r"`tile=100`: must be a multiple of 64", {"tiling": {"tile": 100}}),
        (nm.UsageError, r"`workers=2`: is for this machine", {"tiling": {"workers": 2, "scheduler": "tcp://x:1"}}),
        (
            nm.NmaptoolError,
            r"`scheduler=.*`: cannot be reached",
            {"tiling": {"scheduler": "tcp://127.0.0.1:9"}},
        ),
        (
            nm.LimitError,
            r"by tiles: needs about .* `memory_limit` allows 100MB",
            {"options": {"memory_limit": "100MB"}},
        ),
    ],
)
def test_what_cannot_be_done_is_one_line(
    case: Case, tmp_path: Path, error: type[Exception], match: str, change: dict[str, Any]
) -> None:
    output = tmp_path / change.get("name", "heights.zarr")
    if "exists" in change:
        output.mkdir()
    settings = {"tile": 64, "workers": 0, **change.get("tiling", {})}
    if "scheduler" in settings and change["tiling"].get("workers") is None:
        del settings["workers"]
    with pytest.raises(error, match=match) as caught:
        options = dataclasses.replace(_OPTIONS, **change.get("options", {}))
        _relief(case, output, options, tiling=TilingOptions(**settings))
    assert "\n" not in str(caught.value)
    assert not output.is_file()


def test_a_motif_that_is_empty_is_named(case: Case, tmp_path: Path) -> None:
    mask = store(tmp_path / "mask.zarr", np.zeros((ROWS, COLS), np.uint8), ("Y",))
    with pytest.raises(nm.InputError, match="the mask selects nothing"):
        _relief(case, tmp_path / "heights.zarr", files=ReliefFiles(mask=mask))


def test_a_flat_relief_has_no_factor(tmp_path: Path) -> None:
    flat = np.zeros((128, 192, 3), np.float32)
    flat[..., 2] = 1
    name = store(tmp_path / "flat.zarr", flat, ("R", "G", "B"))
    options = ReliefOptions(height=nm.length("3mm"), background="free", width=WIDTH)
    with pytest.raises(nm.InputError, match=r"`height='3mm'`: the relief is flat, so no factor gives it a height"):
        nm.tiled.relief(name, str(tmp_path / "h.zarr"), options, tiling=TilingOptions(tile=64, workers=0))


def test_other_sizes_are_refused(case: Case, tmp_path: Path) -> None:
    mask = store(tmp_path / "mask.zarr", np.zeros((ROWS, COLS - 1), np.uint8), ("Y",))
    with pytest.raises(nm.InputError, match=rf"the mask .* {COLS - 1} x {ROWS}"):
        _relief(case, tmp_path / "heights.zarr", files=ReliefFiles(mask=mask))


def test_a_solve_that_does_not_converge_says_how_far_it_came(case: Case, tmp_path: Path) -> None:
    options = dataclasses.replace(_OPTIONS, max_iterations=1)
    with pytest.raises(nm.ConvergenceError, match=r"residual of .*e-.* after 1 sweep, but the tolerance is 1e-08"):
        _relief(case, tmp_path / "heights.zarr", options)


def test_the_plan_keeps_to_the_memory_whatever_the_height() -> None:
    peaks = [plan(rows, 16384, 2, 4_000_000_000).total_bytes for rows in (16384, 65536, 1_000_000)]
    assert max(peaks) <= 4_000_000_000
    assert plan(16384, 16384, 2, 4_000_000_000).workers == 2
    small = plan(16384, 16384, 2, 1_500_000_000)
    assert small.total_bytes <= 1_500_000_000
    assert small.grid.factor > 4


def _command(case: Case, output: Path) -> list[str]:
    flags = ["--mask", str(case.masked.mask), "--height", "3mm", "--width", "54mm", "--tile", "128", "--workers", "2"]
    start = [sys.executable, "-c", "from nmaptool_cli.start import run; run()"]
    return [*start, "relief", case.original, "-o", str(output), *flags, "-q"]


@pytest.mark.skipif(sys.platform == "win32", reason="SIGKILL")
def test_kills_at_random_moments_do_not_change_the_bytes(
    case: Case, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    """kill -9 of the run and of its workers; with --long 20 times."""
    times = 20 if request.config.getoption("--long") else 2
    started = time.monotonic()
    subprocess.run(_command(case, tmp_path / "whole.zarr"), check=True)
    usual = time.monotonic() - started
    moments = random.Random(5)
    for number in range(times):
        output = tmp_path / "heights.zarr"
        with subprocess.Popen(_command(case, output), start_new_session=True, stderr=subprocess.PIPE) as run:
            time.sleep(moments.uniform(0.2, 1) * usual)
            workers = _children(run.pid)
            if number % 2 and workers:
                os.kill(moments.choice(workers), signal.SIGKILL)
            else:
                run.kill()
            run.wait(300)
        if not output.exists():
            subprocess.run(_command(case, output), check=True)
        assert _bytes(output) == _bytes(tmp_path / "whole.zarr")
        for path in sorted(output.rglob("*"), reverse=True):
            path.rmdir() if path.is_dir() else path.unlink()
        output.rmdir()


def _children(parent: int) -> list[int]:
    """The processes that a process started."""
    try:
        found = Path(f"/proc/{parent}/task/{parent}/children").read_text(encoding="ascii")
    except OSError:
        return []
    return [int(number) for number in found.split()]


def test_the_report_tells_what_was_done(case: Case, tmp_path: Path) -> None:
    output = tmp_path / "heights.zarr"
    told = subprocess.run([*_command(case, output), "--json"], capture_output=True, check=True, text=True)
    report = json.loads(told.stdout)
    assert (report["tile"], report["tiles"], report["workers"]) == (128, 20, 2)
    assert report["relief"]["residual"] <= 1e-8
    assert report["outputs"] == [str(output)]


@pytest.mark.skipif(sys.platform == "win32", reason="limits of the size of a file")
def test_a_full_disk_is_one_line_and_the_run_goes_on(case: Case, tmp_path: Path) -> None:
    """A limit on the size of files stands in for a full disk."""
    limit = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, resource.RLIM_INFINITY))"
    command = _command(case, tmp_path / "heights.zarr")
    command[2] = f"{limit}; {command[2]}"
    failed = subprocess.run(command, capture_output=True, text=True, check=False)
    assert failed.returncode == 5
    assert failed.stderr.startswith("nmap: error: ")
    assert failed.stderr.count("\n") == 1
    assert "run again" in failed.stderr
    subprocess.run(_command(case, tmp_path / "heights.zarr"), check=True)
    subprocess.run(_command(case, tmp_path / "whole.zarr"), check=True)
    assert _bytes(tmp_path / "heights.zarr") == _bytes(tmp_path / "whole.zarr")
