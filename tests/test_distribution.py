"""The distribution: an sdist, the wheel built from it, and the wheel in an otherwise empty environment."""

import os
import re
import shutil
import subprocess
import sys
import tarfile
import zipfile
from email.parser import Parser
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import nmaptool as nm
from nmaptool._version import __version__

ROOT = Path(__file__).parents[1]
INFO = f"nmaptool_relief-{__version__}.dist-info"
# pip's output if the index does not respond; a package missing from the index counts as a failure
UNREACHABLE = r"connection broken by|Temporary failure in name resolution|Network is unreachable|ConnectTimeout"


def run(*words, folder):
    """Run a program outside the checkout, without environment variables that point into it."""
    env = {
        name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV", "NMAPTOOL"))
    }
    how = {"capture_output": True, "text": True, "encoding": "utf-8", "errors": "replace"}
    return subprocess.run([*map(str, words)], check=False, cwd=folder, env=env, **how)


def needs_index(done):
    """Skip the test if no package index responds; fail it if the program fails otherwise."""
    said = done.stdout + done.stderr
    if done.returncode != 0 and re.search(UNREACHABLE, said):
        pytest.skip("no package index can be reached")
    assert done.returncode == 0, said


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """The sdist and the wheel, built from a copy of the checkout."""
    folder = tmp_path_factory.mktemp("built")
    left = shutil.ignore_patterns(
        ".*", "__pycache__", "*.egg-info", "build", "dist", "gallery", "docs", "*.ply", "*.so", "*.pyd"
    )
    shutil.copytree(ROOT, folder / "checkout", ignore=left)
    needs_index(run(sys.executable, "-m", "build", "--outdir", folder, folder / "checkout", folder=folder))
    (sdist,), (wheel,) = folder.glob("*.tar.gz"), folder.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        has_loops = any("/_compiled." in name for name in archive.namelist())
    return SimpleNamespace(sdist=sdist, wheel=wheel, has_loops=has_loops)


@pytest.fixture(scope="module")
def installed(built, tmp_path_factory):
    """A new environment with the wheel and its dependencies: its folder of commands, and a working folder."""
    folder = tmp_path_factory.mktemp("installed")
    run(sys.executable, "-m", "venv", "--without-pip", folder / "venv", folder=folder)
    scripts = folder / "venv" / ("Scripts" if os.name == "nt" else "bin")
    python = scripts / "python"
    assert run(python, "-c", "import numpy", folder=folder).returncode != 0
    pip = (sys.executable, "-m", "pip", "--python", python, "install", "--quiet", "--no-compile")
    needs_index(run(*pip, built.wheel, folder=folder))
    (folder / "work").mkdir()
    return SimpleNamespace(
        python=lambda code: run(python, "-c", code, folder=folder / "work"),
        nmap=lambda *words: run(scripts / "nmap", *words, folder=folder / "work"),
        nmaptool=lambda *words: run(scripts / "nmaptool", *words, folder=folder / "work"),
        venv=folder / "venv",
        work=folder / "work",
    )


def package_files():
    """Every file of the two packages, under its import path."""
    for folder, package in (("nmaptool", "nmaptool"), ("cli", "nmaptool_cli")):
        for path in (ROOT / folder).rglob("*"):
            if path.is_file() and "__pycache__" not in path.parts and path.suffix not in (".so", ".pyd"):
                yield "/".join((package, *path.relative_to(ROOT / folder).parts))


def test_the_wheel_holds_the_packages_with_their_data_and_nothing_else(built):
    with zipfile.ZipFile(built.wheel) as archive:
        names = archive.namelist()
    assert re.fullmatch(rf"nmaptool_relief-{re.escape(__version__)}-cp311-abi3-\w+\.whl", built.wheel.name)
    held = {name for name in names if not name.startswith(INFO)}
    extension = {name for name in held if name.startswith("nmaptool/_compiled.")}
    assert len(extension) == built.has_loops
    assert held - extension == {name for name in package_files() if not name.endswith((".c", ".h"))}
    data = {name for name in names if not name.startswith(INFO) and not name.endswith(".py")}
    assert {"nmaptool/py.typed", "nmaptool/__init__.pyi", "nmaptool/filters/learned/filter.npz"} < data


def test_the_metadata_state_name_licence_and_commands(built):
    with zipfile.ZipFile(built.wheel) as archive:
        metadata = Parser().parsestr(archive.read(f"{INFO}/METADATA").decode())
        licence = archive.read(f"{INFO}/licenses/LICENSE")
        commands = archive.read(f"{INFO}/entry_points.txt").decode().split("\n")
    assert metadata["Name"] == "nmaptool-relief"
    assert metadata["Version"] == __version__
    assert metadata["License-Expression"] == "MIT"
    assert licence == (ROOT / "LICENSE").read_bytes()
    assert metadata["Requires-Python"] == ">=3.11"
    needed = [line for line in metadata.get_all("Requires-Dist") if "extra ==" not in line]
    assert not [line for line in needed if re.match(r"build|mypy|pytest|ruff|scikit-image", line)]
    start = "nmaptool_cli.start:run"
    assert [line for line in commands if line] == ["[console_scripts]", f"nmap = {start}", f"nmaptool = {start}"]


def test_the_sdist_holds_the_sources_and_no_tests(built):
    with tarfile.open(built.sdist) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    sources = {re.sub("^nmaptool_cli/", "cli/", name) for name in package_files()}
    assert sources | {"pyproject.toml", "README.md", "LICENSE", "CHANGELOG.md"} <= names
    assert not [name for name in names if re.match(r"tests|samples|bench|docs", name)]


def test_the_wheel_alone_runs_the_commands(built, installed):
    where = installed.python("import nmaptool, nmaptool_cli; print(nmaptool.__file__); print(nmaptool_cli.__file__)")
    assert len(where.stdout.splitlines()) == 2, where.stderr
    assert all(Path(line).is_relative_to(installed.venv) for line in where.stdout.splitlines())
    shown = installed.nmap("--help")
    assert shown.returncode == 0, shown.stderr
    assert "bake" in shown.stdout
    built_with = "compiled" if built.has_loops else "numpy"
    assert installed.nmaptool("--version").stdout.startswith(f"{__version__} ({built_with} kernels")
    stages = installed.python("import nmaptool as nm; print(len(nm.shipped_filter().stages))")
    assert stages.stdout.strip() == "3", stages.stderr


def test_the_wheel_alone_bakes_and_makes_reliefs(installed):
    vase = ROOT / "samples" / "vase.ply"
    done = installed.nmap("bake", vase, "-o", "maps", "--size", "160x160")
    if done.returncode == 6:  # no OpenGL on this machine
        done = installed.nmap("bake", vase, "-o", "maps", "--size", "160x160", "--renderer", "numpy")
    assert done.returncode == 0, done.stderr
    words = ("relief", "maps/original.exr", "--detail", "maps/detail.exr", "--height", "4mm", "-o", "vase.npy")
    done = installed.nmap(*words, "-o", "vase.stl")
    assert done.returncode == 0, done.stderr
    corners = nm.read_mesh(installed.work / "vase.stl").vertices
    assert np.ptp(corners[:, 2]) == pytest.approx(4, abs=1e-5)
    assert np.load(installed.work / "vase.npy").shape == (160, 160)
