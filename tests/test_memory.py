"""Memory: sizes as text, available memory, the needs of a solver, and refusals before the work begins."""

import dataclasses
import sys
import tracemalloc

import numpy as np
import pytest
from relief_cases import dome
from solver_cases import blobs, free_system

import nmaptool as nm
from nmaptool.core import memory as machine
from nmaptool.core.errors import LimitError, UsageError
from nmaptool.core.units import memory, memory_text
from nmaptool.solver import memory as planning
from nmaptool.solver import prepare, slope_load


def test_sizes_are_read_from_text():
    expected = {
        "8GB": 8e9,
        "500MB": 5e8,
        "12GiB": 12 * 2**30,
        "1.5 tb": 1.5e12,
        " .5 KiB": 512,
        "100b": 100,
        "3kB": 3000,
    }
    assert {text: memory(text) for text in expected} == expected
    assert [memory_text(size) for size in (999_600, 15_260_000_000, 10**9)] == ["1MB", "15.3GB", "1.0GB"]


@pytest.mark.parametrize("text", ["", "8", "GB", "-8GB", "8 G", "8Gb/s", "eight GB", "nanGB", "8iB", "1e9B", "8GB 1MB"])
def test_invalid_sizes_are_refused(text):
    with pytest.raises(UsageError, match=r"memory .*: expected a number with a unit \(MB, GB, MiB, GiB\), such as 8GB"):
        memory(text)


@pytest.mark.parametrize("text", ["0GB", "0.1B", "9000000000TB"])
def test_sizes_out_of_range_are_refused(text):
    with pytest.raises(UsageError, match="must be at least one byte and less than 8 EiB"):
        memory(text)


def test_the_option_is_checked_where_it_is_given():
    assert nm.ReliefOptions().memory_limit_bytes is None
    assert nm.ReliefOptions(memory_limit="2GiB").memory_limit_bytes == 2**31
    with pytest.raises(UsageError, match=r"`memory_limit='8'`: expected a number with a unit"):
        nm.ReliefOptions(memory_limit="8")


def put(root, **files):
    for name, text in files.items():
        path = root / name.replace("__", "/")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


@pytest.fixture
def linux(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "platform", "linux")
    put(tmp_path, proc__meminfo="MemTotal:  16000 kB\nMemFree:  1000 kB\nMemAvailable:   9000 kB\n")
    return tmp_path


def test_free_memory_is_read_on_linux(linux):
    assert machine.available_bytes(linux) == 9000 * 1024


def test_a_control_group_and_its_parents_limit_the_memory(linux):
    group = linux / "sys/fs/cgroup/outer/inner"
    put(linux, proc__self__cgroup="0::/outer/inner\n")
    put(group, **{"memory.max": "max\n", "memory.current": "4000\n"})
    assert machine.available_bytes(linux) == 9000 * 1024
    put(
        group.parent,
        **{"memory.max": "10000\n", "memory.current": "4000\n", "memory.stat": "anon 5\ninactive_file 700\n"},
    )
    assert machine.available_bytes(linux) == 6700
    put(group, **{"memory.max": "100\n", "memory.current": "300\n"})
    assert machine.available_bytes(linux) == 0


def test_a_container_sees_its_own_group_at_the_top(linux):
    put(linux, proc__self__cgroup="0::/of/the/host\n")
    put(linux / "sys/fs/cgroup", **{"memory.max": "10000\n", "memory.current": "1000\n"})
    assert machine.available_bytes(linux) == 9000


def test_control_groups_of_version_1_limit_the_memory(linux):
    put(linux, proc__self__cgroup="11:cpu,cpuacct:/a\n7:memory:/a\n1:name=systemd:/\n")
    files = {
        "memory.limit_in_bytes": "5000",
        "memory.usage_in_bytes": "2000",
        "memory.stat": "total_inactive_file 500\n",
    }
    put(linux / "sys/fs/cgroup/memory/a", **files)
    put(linux / "sys/fs/cgroup/memory", **{"memory.limit_in_bytes": str(2**63 - 4096), "memory.usage_in_bytes": "0"})
    assert machine.available_bytes(linux) == 3500


def test_free_memory_is_estimated_on_other_systems(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "platform", "darwin")
    monkeypatch.setattr(machine, "_built_in", lambda: 1000)
    assert machine.available_bytes(tmp_path) == 750
    monkeypatch.setattr(machine, "_built_in", lambda: None)
    assert machine.available_bytes(tmp_path) is None
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(machine, "_free_on_windows", lambda: 123)
    assert machine.available_bytes(tmp_path) == 123


def test_this_machine_has_some_memory():
    assert machine.available_bytes() > 10_000_000


CASES = {
    "dct": (np.ones((500, 600)), "dct", 1e-3),
    "dct floating": (np.ones((500, 600)), "dct", 0),
    "multigrid": (blobs(600), "multigrid", 1e-3),
    "multigrid full": (np.ones((500, 600)), "multigrid", 1e-3),
    "amg": (blobs(500), "amg", 1e-3),
    "amg full": (np.ones((300, 400)), "amg", 0),
}


@pytest.mark.parametrize("case", CASES)
def test_the_planned_memory_matches_the_memory_used(case):
    weight, method, beta = CASES[case]
    system = free_system(weight.astype(np.float32), beta)
    load = slope_load(*(weight * np.random.default_rng(0).normal(size=(2, *weight.shape))))
    prepare(free_system(weight[:20, :20] + 1), method)  # lets libraries allocate what they keep
    tracemalloc.start()
    try:
        solver = prepare(system, method)
        solver.solve(load)
        taken = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert taken < 1.1 * solver.planned_bytes
    assert taken > 0.6 * (solver.planned_bytes - planning._BESIDE)


def test_a_limit_is_respected_and_the_message_gives_a_remedy():
    system = free_system(blobs(64))
    needed = planning.estimate((64, 64), int(system.unknown.sum()), "amg")
    assert prepare(system, "amg", needed).planned_bytes == needed
    with pytest.raises(
        LimitError,
        match=r"^64 x 64 px to solve: the amg solver needs about 17MB of memory, `memory_limit` allows 5MB; "
        r"make the picture smaller, use `solver='auto'`, or raise it to 18MB$",
    ) as caught:
        prepare(system, "amg", 5_000_000)
    assert caught.value.exit_code == 4
    prepare(system, "amg", memory("18MB"))


def test_the_command_line_refuses_before_it_writes(refused, maps, tmp_path):
    options = "--memory-limit", "1MB", "-o", tmp_path / "out.stl"
    refused(4, "solver needs about .* of memory, --memory-limit allows 1MB; ", "relief", maps["clean"], *options)
    refused(2, "--memory-limit 1: expected", "relief", maps["clean"], "--memory-limit", "1")


def test_an_image_too_large_for_the_machine_is_refused(monkeypatch):
    monkeypatch.setattr(planning, "available_bytes", lambda: 12_300_000)
    with pytest.raises(
        LimitError,
        match=r"^7 x 5 px to solve: the dct solver needs about 16MB of memory, 12MB are free; .* or "
        r"close other programs$",
    ):
        prepare(free_system(np.ones((5, 7))))
    # a given limit takes precedence
    assert prepare(free_system(np.ones((5, 7))), memory_limit_bytes=10**9).planned_bytes > 12_300_000
    monkeypatch.setattr(planning, "available_bytes", lambda: None)
    prepare(free_system(np.ones((5, 7))))


def test_the_memory_limit_applies_to_weights_that_need_float64():
    original, _, detail = dome(64, bumps=1)
    mu_map = np.where(np.arange(64) < 9, 0, 1)[None] * np.ones((64, 1), np.float32)
    session = nm.ReliefSession(original, detail, mu_map=mu_map)
    wide = nm.ReliefOptions(mu=1e5, beta=0.004, delta=12.0, background="cut", tolerance=1e-6)
    planned = session.solve(wide).report.planned_bytes
    with pytest.raises(nm.LimitError, match="the float64 multigrid solver needs about"):
        session.solve(dataclasses.replace(wide, memory_limit=f"{planned - 1}B"))
