"""Examples in docstrings and the README run in a folder of their own, with ``nm`` and ``np`` imported."""

from pathlib import Path

import pytest
from _pytest.doctest import DoctestItem

ROOT = Path(__file__).parent


@pytest.fixture(autouse=True)
def _examples(request: pytest.FixtureRequest) -> None:
    """For doctests alone: a temporary working directory that holds the samples."""
    if not isinstance(request.node, DoctestItem):
        return
    import numpy as np

    import nmaptool as nm

    folder = request.getfixturevalue("tmp_path")
    (folder / "samples").symlink_to(ROOT / "samples")
    request.getfixturevalue("monkeypatch").chdir(folder)
    request.getfixturevalue("doctest_namespace").update(nm=nm, np=np)
