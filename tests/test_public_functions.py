"""Every public function is fully documented, has an example that runs, and takes its options in the same way."""

import dataclasses
import doctest
import inspect
import re
from pathlib import Path

import numpy as np
import pytest

import nmaptool as nm
from nmaptool.options.fields import Options

FUNCTIONS = {name: getattr(nm, name) for name in nm.__all__ if inspect.isroutine(inspect.unwrap(getattr(nm, name)))}
METHODS = {
    "NormalMap.from_array": nm.NormalMap.from_array,
    "Mesh.from_arrays": nm.Mesh.from_arrays,
    "Mesh.from_trimesh": nm.Mesh.from_trimesh,
    "Mesh.to_trimesh": nm.Mesh.to_trimesh,
    "ReliefSession.solve": nm.ReliefSession.solve,
}
DOCUMENTED = FUNCTIONS | METHODS
# options are checked against the command line; the last three describe all their fields in one sentence
VALUES = [
    name
    for name in nm.__all__
    if dataclasses.is_dataclass(kind := getattr(nm, name))
    if not (issubclass(kind, Options) or name.endswith("Options"))
    if name not in ("Decoding", "Finding", "CurvePoint")
]


def sections(docstring):
    """Titles and texts of the underlined sections."""
    parts = re.split(r"^(\w+)\n-+$", inspect.cleandoc(docstring), flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def named(section):
    """The names that a section of parameters or attributes describes: its lines that are not indented."""
    heads = re.findall(r"^(\S.*?)(?: : .*)?$", section, flags=re.MULTILINE)
    return [name.lstrip("*") for head in heads for name in head.split(", ")]


@pytest.mark.parametrize("name", DOCUMENTED)
def test_docstrings_name_every_parameter_and_have_every_section(name):
    function = DOCUMENTED[name]
    found = sections(function.__doc__)
    parameters = [p for p in inspect.signature(function).parameters if p != "self"]
    assert named(found.get("Parameters", "")) == parameters
    assert ("Returns" in found) == (inspect.signature(function).return_annotation != "None")
    assert found["Raises"].strip()
    assert ">>> " in found["Examples"]
    assert "nm." in found["Examples"] or name == "length"
    titles = [title for title in ("Parameters", "Returns", "Raises", "Examples") if title in found]
    assert [title for title in found if title in titles] == titles


@pytest.mark.parametrize("name", DOCUMENTED)
def test_values_come_first_then_options_and_the_rest_is_keyword_only(name):
    parameters = list(inspect.signature(DOCUMENTED[name]).parameters.values())
    positional = [p for p in parameters if p.kind is p.POSITIONAL_OR_KEYWORD]
    are_options = ["Options" in str(p.annotation) for p in positional]
    assert are_options == sorted(are_options)  # no value comes after the options
    assert not any("Options" in str(p.annotation) for p in parameters if p.kind is p.KEYWORD_ONLY and name != "train")
    for parameter in positional:
        if parameter.default is not parameter.empty and "from_" not in name:
            annotation = str(parameter.annotation)
            assert "Path" in annotation or not re.match(r"(str|int|float|bool|Progress)\b", annotation), parameter


@pytest.mark.parametrize("name", VALUES)
def test_docstrings_of_values_name_every_field(name):
    kind = getattr(nm, name)
    found = sections(kind.__doc__)
    documented = set(named(found.get("Parameters", "") + found.get("Attributes", "")))
    fields = {field.name for field in dataclasses.fields(kind)}
    inherited = {field for base in kind.__mro__[1:] for field in getattr(base, "__dataclass_fields__", {})}
    assert fields - inherited <= documented <= fields


def test_the_readmes_example_runs():
    y, x = np.mgrid[1:-1:32j, -1:1:32j]
    with np.errstate(invalid="ignore"):
        sphere = np.dstack([x, y, np.sqrt(1 - x * x - y * y)]).astype(np.float16)
    names = {"sphere_normals": lambda: (sphere, x * x + y * y < 0.5)}
    readme = Path(__file__).parents[1] / "README.md"
    (example,) = re.findall(r"^```python\n(>>> .*?)^```", readme.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    test = doctest.DocTestParser().get_doctest(example, names, "README.md", str(readme), 0)
    assert doctest.DocTestRunner().run(test, clear_globs=False) == (0, 3)
    y, x = np.mgrid[1:-1:33j, -1:1:33j] * 32 / 31  # the corners of the pixels
    surface = test.globs["heights"] > 0
    off = test.globs["heights"][surface] - 15.5 * np.sqrt(1 - x[surface] ** 2 - y[surface] ** 2)
    assert np.ptp(off) < 0.05
