"""What every test run needs: the option ``--long``, few threads per process, and a folder for the examples.

``make test`` runs one process per core. Each test with random trials asks ``trials(count)`` how many to make: all of
them with ``--long`` (``make test-long``), else a fifth. Tests marked ``house`` look at the project's own files and run
in ``make check``. Plain ``pytest`` runs everything in one process.
"""

import contextlib
import importlib.util
import os
import shutil
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from _pytest.doctest import DoctestItem

ROOT = Path(__file__).parent
# before NumPy is imported: OpenBLAS would start a thread per core in each process
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# where the compiled loops were not built, commands would warn in every test
if importlib.util.find_spec("nmaptool._compiled") is None:
    os.environ.setdefault("NMAPTOOL_KERNELS", "numpy")
pytest_plugins = ("browser_cases",)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add ``--long``."""
    parser.addoption("--long", action="store_true", help="make all random trials, not a fifth of them")


def pytest_configure(config: pytest.Config) -> None:
    """Share the cores among the processes of pytest-xdist; two threads are left to each, so that threads are tested."""
    if hasattr(config, "workerinput"):
        from nmaptool.core import parallel

        threads = min(parallel.cores(), max(2, parallel.cores() // config.workerinput["workercount"]))
        parallel.cores_of_process = lambda: threads


@contextlib.contextmanager
def _opengl() -> Iterator[None]:
    """Skip what needs OpenGL on systems other than Linux, where setup.sh cannot install it."""
    from nmaptool.core.errors import RendererError

    try:
        yield
    except RendererError as error:
        if sys.platform == "linux":
            raise
        pytest.skip(f"needs OpenGL: {error}")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup() -> Iterator[None]:
    """Fixtures that draw."""
    with _opengl():
        yield


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call() -> Iterator[None]:
    """Tests that draw."""
    with _opengl():
        yield


@pytest.fixture(scope="session")
def trials(request: pytest.FixtureRequest) -> Callable[[int], int]:
    """``trials(150)``: how many random trials to make of 150."""
    return lambda count: count if request.config.getoption("--long") else max(count // 5, 1)


@pytest.fixture(autouse=True)
def _examples(request: pytest.FixtureRequest) -> None:
    """For doctests alone: a temporary working directory that holds the samples."""
    if not isinstance(request.node, DoctestItem):
        return
    import numpy as np

    import nmaptool as nm

    folder = request.getfixturevalue("tmp_path")
    try:
        (folder / "samples").symlink_to(ROOT / "samples")
    except OSError:  # Windows allows links to developers only
        shutil.copytree(ROOT / "samples", folder / "samples")
    request.getfixturevalue("monkeypatch").chdir(folder)
    request.getfixturevalue("doctest_namespace").update(nm=nm, np=np)
