"""Without the compiled loops, a command that would run them says so once, with the way to get them."""

import sys
from pathlib import Path

import pytest

VASE = Path(__file__).parents[1] / "samples" / "vase.ply"
DRAWN = ("--size", "48x48", "--renderer", "numpy")
SAID = (
    "nmap: warning: the compiled loops are missing, so slower NumPy code ran in their place; to get them, install a C "
    "compiler and reinstall nmaptool-relief (in a clone: make setup); NMAPTOOL_KERNELS=numpy hides this warning"
)


@pytest.fixture
def not_built(monkeypatch):
    """The extension cannot be imported, and nothing asks for NumPy."""
    monkeypatch.delenv("NMAPTOOL_KERNELS", raising=False)
    monkeypatch.setitem(sys.modules, "nmaptool._compiled", None)


def words_of(name, clean_map, folder):
    """A command line with quick inputs."""
    return {
        "bake": ("bake", VASE, "-o", folder / "maps", *DRAWN),
        "bake by rings": ("bake", VASE, "-o", folder / "maps", *DRAWN, "--neighborhood", "ring"),
        "smooth": ("smooth", VASE, "-o", folder / "smooth.stl"),
        "split": ("compose", "split", clean_map, "-o", folder / "layers"),
        "relief": ("relief", clean_map, "-o", folder / "relief.npy"),
        "convert": ("compose", "convert", clean_map, "-o", folder / "other.png"),
        "inspect": ("inspect", clean_map),
    }[name]


@pytest.mark.usefixtures("not_built")
@pytest.mark.parametrize("name", ["bake", "smooth", "split", "relief"])
def test_a_command_that_runs_the_loops_warns_once(run, clean_map, tmp_path, name):
    done = run(*words_of(name, clean_map, tmp_path))
    assert done.code == 0, done.err
    warnings = [line for line in done.err.splitlines() if "loops" in line]
    assert warnings == [SAID]


@pytest.mark.usefixtures("not_built")
@pytest.mark.parametrize("name", ["bake by rings", "convert", "inspect"])
def test_other_commands_do_not_warn(run, clean_map, tmp_path, name):
    done = run(*words_of(name, clean_map, tmp_path))
    assert done.code == 0, done.err
    assert SAID not in done.out + done.err


@pytest.mark.usefixtures("not_built")
def test_quiet_and_failed_runs_do_not_warn(run, clean_map, tmp_path):
    assert run(*words_of("relief", clean_map, tmp_path), "-q").err == ""
    failed = run("relief", tmp_path / "none.png", "-o", tmp_path / "z.npy")
    assert failed.code == 3
    assert failed.err.count("\n") == 1
    assert SAID not in failed.err


@pytest.mark.usefixtures("not_built")
def test_the_version_and_the_report_name_numpy(run, clean_map):
    assert run("--version").out.endswith(" (numpy kernels)\n")
    assert '"kernels": "numpy"' in run("relief", clean_map, "--json", "-q").out


@pytest.mark.usefixtures("not_built")
def test_a_user_who_chose_numpy_is_not_warned(run, clean_map, tmp_path, monkeypatch):
    monkeypatch.setenv("NMAPTOOL_KERNELS", "numpy")
    assert SAID not in run(*words_of("relief", clean_map, tmp_path)).err
