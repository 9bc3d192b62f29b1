"""Modules, functions and files named in docstrings, comments and documents exist."""

import ast
import importlib
import re
from functools import cache
from pathlib import Path

import pytest

pytestmark = pytest.mark.house

ROOT = Path(__file__).parents[1]
FOLDERS = ("nmaptool", "cli", "bench", "samples", "tests", "docs")
SOURCES = [path for folder in FOLDERS for path in sorted((ROOT / folder).rglob("*.py"))]
PROGRAMS = [path for path in SOURCES if path.relative_to(ROOT).parts[0] in ("bench", "samples", "docs")]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")), *sorted((ROOT / "bench").glob("*.md"))]

DOTTED = re.compile(r"(?<![\w./-])(?:nmaptool|nmaptool_cli)(?:\.[A-Za-z]\w*)+")
OURS = re.compile(r"(?:nmaptool|nmaptool_cli)(?:\.|$)")
SHORT = re.compile(r"(?<![\w./-])nm(?:\.[A-Za-z]\w*)+")
PATH = re.compile(rf"`((?:{'|'.join(FOLDERS)})/[\w./*-]+)`")
A_FILE = "nmaptool.json"  # within a workspace


@cache
def resolves(name):
    """Whether a dotted name is a module or an object in one."""
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
    """(file, named object), each once."""
    return sorted(
        {
            (str(path.relative_to(ROOT)), name)
            for path in paths
            for name in pattern.findall(path.read_text(encoding="utf-8"))
        }
    )


def test_dotted_names_resolve():
    names = [(path, name) for path, name in named(DOTTED, [*SOURCES, *PAGES]) if name != A_FILE]
    names += [(path, name.replace("nm.", "nmaptool.", 1)) for path, name in named(SHORT, [*PROGRAMS, *PAGES])]
    assert len(names) > 500
    assert [f"{path}: {name}" for path, name in names if not resolves(name)] == []


def imported(path):
    """Dotted names of nmaptool that a file imports, also inside functions."""
    nodes = [
        node
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and node.module
    ]
    return {f"{n.module}.{alias.name}" for n in nodes if OURS.match(n.module) for alias in n.names}


def test_programs_outside_the_library_import_existing_names():
    names = {(path.name, name) for path in PROGRAMS for name in imported(path)}
    assert len(names) > 50
    assert sorted(f"{file}: {name}" for file, name in names if not resolves(name)) == []


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
def test_existing_names_resolve_and_missing_names_do_not(name, there):
    assert resolves(f"nmaptool.{name}") is there
