"""One solver for systems that are equal, and the heights of a batch, bit for bit those of single runs."""

import re
from pathlib import Path

import numpy as np
import pytest

import nmaptool as nm
from nmaptool.core.errors import LimitError
from nmaptool.core.parallel import at_most, cores
from nmaptool.solver import QuadSystem, prepare
from nmaptool.solver.kept import SolverKeeper, current_keeper, keeping
from nmaptool.solver.multigrid import method as multigrid
from nmaptool_cli.sets.item import ItemRunner
from nmaptool_cli.sets.items import items_of, job_of_words


@pytest.fixture
def maps(tmp_path, dome, codes, png):
    """Four maps of one size and mask, and one with another mask."""
    folder = tmp_path / "maps"
    folder.mkdir()
    for number, (rise, radius) in enumerate(((0.3, 1), (0.5, 1), (0.7, 1), (0.9, 1), (0.9, 0.7))):
        d = dome(rise=rise)
        y, x = np.mgrid[-1:1:96j, -1:1:96j]
        alpha = (np.hypot(x, y) < 0.8 * radius).astype(np.uint16) * 65535
        png(folder / f"{number}.png", np.dstack([codes(d.normals, 16), alpha]))
    return folder


def system(weight=1.0, beta=0.01, rows=24):
    held = np.zeros((rows + 1, 33), bool)
    held[0] = True
    weights = np.full((rows, 32), weight)
    weights[5:9, 5:9] = 0
    return QuadSystem(weights, np.full((rows + 1, 33), beta), held)


def test_an_equal_system_gets_the_kept_solver_and_any_other_a_new_one():
    keeper = SolverKeeper()
    with keeping(keeper):
        first = prepare(system())
        assert prepare(system()) is first
        for other in (system(weight=2.0), system(beta=0.02), system(rows=25)):
            assert prepare(other) is not first
        assert prepare(system()) is not first
        assert prepare(system(), "amg").method.name == "amg"
        single = QuadSystem(*(np.asarray(a, np.float32) for a in (system().weight, system().beta)), system().held)
        prepare(single)
    assert (keeper.prepared, keeper.reused) == (7, 1)


def test_only_the_context_that_asks_for_it_keeps_a_solver():
    with keeping(SolverKeeper()) as nothing:
        assert nothing is None
        assert current_keeper() is not None
    assert current_keeper() is None
    assert prepare(system()) is not prepare(system())


def test_the_kept_solver_respects_the_limit_of_memory():
    with keeping(SolverKeeper()):
        prepare(system())
        with pytest.raises(LimitError, match="the multigrid solver needs about"):
            prepare(system(), memory_limit_bytes=1000)


def test_cores_can_be_limited_in_a_context():
    before = cores()
    with at_most(1):
        assert cores() == 1
        with at_most(before + 7):
            assert cores() == before
    assert cores() == before


@pytest.mark.parametrize(
    "flags", [[], ["--background", "cut"], ["--solver", "amg"], ["--height", "3mm", "--fit", "slope"]]
)
def test_a_set_has_one_set_up_and_the_bytes_of_single_runs(flags, maps, tmp_path, run, monkeypatch):
    set_ups = []
    build = multigrid.Hierarchy.__init__
    monkeypatch.setattr(multigrid.Hierarchy, "__init__", lambda *a, **k: (set_ups.append(a), build(*a, **k))[1])
    runner = ItemRunner(threads=1)
    job = [
        "relief",
        str(maps / "*.png"),
        "-o",
        str(tmp_path / "set/{stem}.stl"),
        "-o",
        str(tmp_path / "set/{stem}.npy"),
    ]
    results = [runner.run(item) for item in items_of([job_of_words([*job, *flags])])]
    assert [result.status for result in results] == ["done"] * 5, results
    assert (runner.keeper.prepared, runner.keeper.reused) == (2, 3)
    assert len(set_ups) == (0 if "amg" in flags else 2)
    for number in range(5):
        outputs = [tmp_path / f"{number}.stl", tmp_path / f"{number}.npy"]
        done = run("relief", maps / f"{number}.png", "-o", outputs[0], "-o", outputs[1], *flags)
        assert done.code == 0, done.err
        for path in outputs:
            assert path.read_bytes() == (tmp_path / "set" / path.name).read_bytes()
        said = [line for line in done.err.splitlines() if "warning" not in line]
        warnings = [line.partition("warning: ")[2] for line in done.err.splitlines() if "warning" in line]
        notes = [line.replace(str(tmp_path / "set"), str(tmp_path)) for line in results[number].notes]
        assert [timeless(line) for line in notes] == [timeless(line) for line in said]
        assert list(results[number].warnings) == warnings


def timeless(line):
    return re.sub(r"\d\.\d\d s$", "", line)


def test_every_file_of_an_item_is_told(maps, tmp_path):
    """Also those of commands that do not report their outputs, and none of a run that writes nothing."""

    def outputs(*words):
        (item,) = items_of([job_of_words([str(word) for word in words])])
        result = ItemRunner().run(item)
        assert result.status == "done", result
        return {Path(name).relative_to(tmp_path).as_posix() for name in result.outputs}

    one = maps / "0.png"
    assert outputs("compose", "pack", one, "-o", tmp_path / "a.psd") == {"a.psd"}
    assert outputs("relief", one, "-o", tmp_path / "b.stl", "--dry-run") == set()
    assert outputs("relief", one, "--save-recipe", tmp_path / "b.toml") == {"b.toml"}
    layers = outputs("compose", "split", one, "-o", tmp_path / "layers")
    assert layers == {path.relative_to(tmp_path).as_posix() for path in (tmp_path / "layers").iterdir()}
    parts = outputs("relief", one, "-o", tmp_path / "p_{row}_{col}.stl", "--parts", "1x2")
    assert parts == {"p_0_0.stl", "p_1_0.stl"}


def test_a_session_keeps_its_own_solvers(maps):
    normals = nm.read_normal_map(maps / "0.png")
    keeper = SolverKeeper()
    with keeping(keeper):
        one = nm.relief(normals, options=nm.ReliefOptions(mu=0.3))
        session = nm.ReliefSession(normals)
        first = session.solve(nm.ReliefOptions(beta=0.002))
        second = session.solve(nm.ReliefOptions(beta=0.0021))
    assert keeper.reused == 0
    assert not np.array_equal(first.z_mm, second.z_mm)
    assert np.array_equal(one.z_mm, nm.relief(normals, options=nm.ReliefOptions(mu=0.3)).z_mm)
