"""docs/architecture.md matches the code: its layers are the import contract, its files exist, functions are small."""

import ast
import re
import statistics
import tomllib
from pathlib import Path

import pytest

pytestmark = pytest.mark.house

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
ROOMS = sorted(path.parent.name for path in (ROOT / "nmaptool").glob("*/__init__.py"))


def section(title):
    """The text below a title."""
    return PAGE.split(f"## {title}\n")[1].split("\n## ")[0]


def layers():
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"][
        "contracts"
    ]
    (house,) = (contract for contract in contracts if contract.get("containers") == ["nmaptool"])
    assert house["exhaustive"] is True
    return [[room.strip() for room in floor.split("|")] for floor in house["layers"]]


def test_the_drawing_shows_the_import_contract():
    drawn = re.findall(r"^    (\w+(?: \| \w+)*)  ?", PAGE.split("-----\n")[1].split("\n\n")[0], re.MULTILINE)
    assert [[room.strip() for room in floor.split("|")] for floor in drawn] == layers()
    assert sorted(room for floor in layers() for room in floor) == ROOMS


def test_every_package_is_built():
    built = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]["packages"]
    found = [".".join(path.parent.relative_to(ROOT).parts) for path in (ROOT / "nmaptool").rglob("__init__.py")]
    found += [
        ".".join(("nmaptool_cli", *p.parent.relative_to(ROOT / "cli").parts))
        for p in (ROOT / "cli").rglob("__init__.py")
    ]
    assert sorted(built) == sorted(found)


def test_no_module_lies_outside_the_packages():
    built = (".so", ".pyd")  # the extension, in an editable installation
    loose = sorted(p.name for p in (ROOT / "nmaptool").iterdir() if p.is_file() and p.suffix not in built)
    assert loose == ["__init__.py", "__init__.pyi", "_version.py", "py.typed"]


def test_the_path_from_a_mesh_to_an_stl_names_existing_files_and_functions():
    path = section("From a mesh to an STL")
    steps = re.findall(r"^ {6,}([\w/]+\.py) +([\w., ]+?)? +->|^ {6,}([\w/]+\.py) +([\w.]+)$", path, re.MULTILINE)
    assert len(steps) >= 12
    for file, names, other_file, other in steps:
        text = (ROOT / "nmaptool" / (file or other_file)).read_text(encoding="utf-8")
        for name in (names or other).replace("rolling guidance", "rolling_guidance").split(", "):
            assert re.search(rf"\b{name.split('.')[-1]}\b", text), (file or other_file, name)


def test_the_path_through_the_studio_names_existing_files():
    named = re.findall(r"\b([\w/]+(?:\.py|\.js|/))(?=[ ,`])", section("The studio"))
    assert len(named) > 10
    assert [name for name in named if not (ROOT / "nmaptool" / "studio" / name).exists()] == []


KINDS = ("map format", "blend mode", "background kind", "solver", "relief format")
MORE = ("relief option", "filter", "command", "figure", "error")


@pytest.mark.parametrize("kind", [*KINDS, *MORE])
def test_the_table_names_existing_files_to_change(kind):
    row = re.search(rf"^\| {kind}(?: \(\w+\))? \| ([^|]*) \|", PAGE, re.MULTILINE)
    assert row is not None
    files = [name for name in re.findall(r"`((?:nmaptool|cli)/[\w/.]+|README\.md)`", row[1]) if "NAME" not in name]
    assert files
    assert all((ROOT / name).exists() for name in files), files


def bodies(path):
    """The number of lines in each function's body, without its docstring."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef):
            body = node.body[1:] if ast.get_docstring(node) is not None else node.body
            yield body[-1].end_lineno - body[0].lineno + 1 if body else 0


def test_most_files_and_functions_are_small():
    files = [path for room in ("nmaptool", "cli") for path in (ROOT / room).rglob("*.py")]
    assert statistics.median(len(path.read_text(encoding="utf-8").splitlines()) for path in files) <= 150
    sizes = sorted(size for path in files for size in bodies(path))
    assert sizes[len(sizes) * 9 // 10] <= 20
