"""What docstrings, comments and documents name is there: modules, functions, files."""

import importlib
import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FOLDERS = ("nmaptool", "cli", "bench", "samples", "tests", "docs")
SOURCES = [path for folder in FOLDERS for path in sorted((ROOT / folder).rglob("*.py"))]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")), *sorted((ROOT / "bench").glob("*.md"))]

DOTTED = re.compile(r"(?<![\w./-])(?:nmaptool|nmaptool_cli)(?:\.[A-Za-z]\w*)+")
SHORT = re.compile(r"(?<![\w./-])nm(?:\.[A-Za-z]\w*)+")
PATH = re.compile(rf"`((?:{'|'.join(FOLDERS)})/[\w./*-]+)`")
A_FILE = "nmaptool.json"  # within a workspace


@cache
def resolves(name):
    """Whether a dotted name is a module, or something in one."""
    module, _, rest = name.rpartition(".")
    try:
        importlib.import_module(name)
        return True
    except ImportError:
        if not module or not resolves(module):
            return False
    owner = value(module)
    return hasattr(owner, rest) or rest in getattr(owner, "__dataclass_fields__", {})


def value(name):
    try:
        return importlib.import_module(name)
    except ImportError:
        owner, _, last = name.rpartition(".")
        return getattr(value(owner), last)


def named(pattern, paths):
    """(file, what it names), each once."""
    return sorted({(str(path.relative_to(ROOT)), name) for path in paths for name in pattern.findall(path.read_text())})


def test_dotted_names_resolve():
    names = [(path, name) for path, name in named(DOTTED, [*SOURCES, *PAGES]) if name != A_FILE]
    names += [(path, name.replace("nm.", "nmaptool.", 1)) for path, name in named(SHORT, PAGES)]
    assert len(names) > 500
    assert [f"{path}: {name}" for path, name in names if not resolves(name)] == []


def test_paths_exist():
    paths = named(PATH, [*SOURCES, *PAGES])
    assert len(paths) > 15
    assert [f"{path}: {name}" for path, name in paths if not list(ROOT.glob(name))] == []


@pytest.mark.parametrize(
    ("name", "there"),
    [
        ("read_recipe", True),
        ("types.recipe", True),
        ("ReadOptions.max_megapixels", True),
        ("RecipeLayer.file", True),
        ("recipes", False),
        ("types.recipe.reads", False),
        ("nothing.at_all", False),
    ],
)
def test_names_that_are_there_and_names_that_are_not(name, there):
    assert resolves(f"nmaptool.{name}") is there
