"""No module imports, directly or through others, a module that imports it."""

import ast
import graphlib
from pathlib import Path

import pytest

pytestmark = pytest.mark.house

ROOT = Path(__file__).parents[1]
# a folder, and the package name of its modules
TREES = {
    "nmaptool": "nmaptool",
    "cli": "nmaptool_cli",
    "bench": "bench",
    "samples/training": "",
    "tests": "",
}


def module_name(path, folder, prefix):
    parts = [*([prefix] if prefix else []), *path.relative_to(folder).with_suffix("").parts]
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imported(node):
    """The dotted names that an import statement may load."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    return [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]


def import_graph(folder, prefix):
    """Each module with the modules of the same tree that it imports, also inside functions."""
    files = {module_name(path, folder, prefix): path for path in sorted(folder.rglob("*.py"))}
    graph = {}
    for name, path in files.items():
        statements = [
            n
            for n in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
            if isinstance(n, ast.Import | ast.ImportFrom)
        ]
        graph[name] = {target for node in statements for target in imported(node) if target in files}
    return graph


@pytest.mark.parametrize("tree", TREES)
def test_there_are_no_import_cycles(tree):
    graph = import_graph(ROOT / tree, TREES[tree])
    assert sum(map(len, graph.values())) > 10
    try:
        graphlib.TopologicalSorter(graph).prepare()
    except graphlib.CycleError as error:
        pytest.fail(f"import cycle: {' -> '.join(error.args[1])}")


def test_a_cycle_through_a_function_is_found(tmp_path):
    (tmp_path / "a.py").write_text("from b import one\n", encoding="utf-8")
    (tmp_path / "b.py").write_text("def one():\n    import a\n", encoding="utf-8")
    with pytest.raises(graphlib.CycleError):
        graphlib.TopologicalSorter(import_graph(tmp_path, "")).prepare()
