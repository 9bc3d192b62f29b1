"""Wheels built from a copy of the checkout without a network, with a compiler and without; how they are distributed."""

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import zipfile
from pathlib import Path

import pytest

from nmaptool._version import __version__

ROOT = Path(__file__).parents[1]
SETTINGS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
WORKFLOW = (ROOT / ".github" / "workflows" / "test.yml").read_text(encoding="utf-8")
LEFT = ("nmaptool", "cli", "pyproject.toml", "README.md", "LICENSE", "CHANGELOG.md", "MANIFEST.in")
BUILD = "import sys; from setuptools.build_meta import build_wheel; build_wheel(sys.argv[1])"
# Microsoft's compiler is then looked for on the PATH alone
NO_COMPILER = {"CC": shutil.which("false") or "no-such-compiler", "DISTUTILS_USE_SDK": "1"}
TRIAL = (ROOT / "tests" / "wheel_trial.py").read_text(encoding="utf-8")
VERSION = "import sys; sys.argv[0] = 'nmap'; from nmaptool_cli.start import run; run()"


def call(*words, folder, **more):
    """Run Python in a folder without the variables that lead into the checkout."""
    environment = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("PYTHON", "NMAPTOOL")) and name not in ("CC", "CFLAGS")
    }
    done = subprocess.run(
        [sys.executable, *map(str, words)],
        capture_output=True,
        check=False,
        text=True,
        cwd=folder,
        env=environment | {name: str(value) for name, value in more.items()},
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout


def build(folder, **environment):
    """The name of the wheel that is built in a folder, its files, and the folder with them unpacked."""
    copied = shutil.ignore_patterns("__pycache__", "*.so", "*.pyd")
    (folder / "checkout").mkdir()
    for name in LEFT:
        path, target = ROOT / name, folder / "checkout" / name
        shutil.copytree(path, target, ignore=copied) if path.is_dir() else shutil.copy(path, target)
    call("-c", BUILD, folder, folder=folder / "checkout", **environment)
    (wheel,) = folder.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "unpacked")
        return wheel.name, archive.namelist(), folder / "unpacked"


def run_with(unpacked, code, *words):
    """Run code with the unpacked files and the packages they need, but without the editable installation (-S)."""
    path = os.pathsep.join(map(str, (unpacked, sysconfig.get_path("purelib"), sysconfig.get_path("platlib"))))
    return call("-S", "-c", code, *words, folder=unpacked.parent, PYTHONPATH=path)


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """A wheel built where every call of the compiler fails."""
    return build(tmp_path_factory.mktemp("plain"), **NO_COMPILER)


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """A wheel built as this machine can."""
    return build(tmp_path_factory.mktemp("compiled"))


def test_a_build_without_a_compiler_gives_a_package_that_runs_on_numpy(plain):
    _, files, unpacked = plain
    assert not [name for name in files if "_compiled." in name]
    assert "nmaptool/kernels/pair_twins.py" in files
    stated = run_with(unpacked, TRIAL, "numpy").splitlines()
    assert Path(stated[0]).is_relative_to(unpacked)
    assert stated[1].startswith("numpy kernels; the heights are right to ")
    assert run_with(unpacked, VERSION, "--version") == f"{__version__} (numpy kernels)\n"


def test_a_build_with_a_compiler_gives_one_wheel_for_every_python(compiled):
    name, files, unpacked = compiled
    assert re.fullmatch(rf"nmaptool_relief-{re.escape(__version__)}-cp311-abi3-\w+\.whl", name)
    extension = {name for name in files if "_compiled." in name}
    if not extension:  # there is no compiler
        assert importlib.util.find_spec("nmaptool._compiled") is None
        return
    assert extension in ({"nmaptool/_compiled.abi3.so"}, {"nmaptool/_compiled.pyd"})
    assert Path(run_with(unpacked, TRIAL, "compiled").splitlines()[0]).is_relative_to(unpacked)
    assert run_with(unpacked, VERSION, "--version") == f"{__version__} (compiled kernels)\n"


def test_wheels_are_built_by_the_oldest_python_and_tested_on_all():
    settings = SETTINGS["tool"]["cibuildwheel"]
    tried = re.search(r"^ +python: \[(.*)\]$", WORKFLOW, re.MULTILINE)[1]
    versions = sorted(re.findall(r"3\.(\d+)", tried), key=int)
    assert settings["build"] == [f"cp3{minor}-*" for minor in versions]
    assert SETTINGS["project"]["requires-python"] == f">=3.{versions[0]}"
    assert SETTINGS["tool"]["distutils"]["bdist_wheel"]["py-limited-api"] == f"cp3{versions[0]}"
    source = (ROOT / "nmaptool" / "kernels" / "arrays.h").read_text(encoding="utf-8")
    (limited,) = re.findall(r"#define Py_LIMITED_API 0x03(\w\w)0000", source)
    assert int(limited, 16) == int(versions[0])
    script = settings["test-command"].split()[1].removeprefix("{project}/")
    assert (ROOT / script).is_file()
    assert settings["test-command"].endswith(" compiled")


def test_wheels_are_built_for_every_system():
    settings = SETTINGS["tool"]["cibuildwheel"]
    assert {system: settings[system]["archs"] for system in ("linux", "macos", "windows")} == {
        "linux": ["x86_64", "aarch64"],
        "macos": ["x86_64", "arm64"],
        "windows": ["AMD64"],
    }
