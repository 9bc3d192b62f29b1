"""The same wrong option, reported in terms of Python, of the command line and of a recipe."""

from __future__ import annotations

import ast
import dataclasses
import math
import pathlib
import re
import shlex
import tomllib
from collections.abc import Iterator
from typing import Any

import pytest

import nmaptool as nm
from nmaptool.core.errors import UsageError
from nmaptool.core.mentions import options_in, written_name
from nmaptool.options.fields import Options, kind_of
from nmaptool.options.kinds import Choice, Count, Number, Positive, Switch, Weight
from nmaptool.types.recipe_plate import PLATE_TABLES
from nmaptool_cli.guard import run_guarded
from nmaptool_cli.mentions import flag_of, in_flags

CLASSES = [v for name in nm.__all__ if isinstance(v := getattr(nm, name), type) and issubclass(v, Options)]
ROOT = pathlib.Path(nm.__file__).parent
# a recipe for each options class, with one of its keys in line 5
RECIPES = {
    nm.LayerOptions: '[[layer]]\nfile = "a.png"\n\n# a comment\n{}\nmask = "m.png"\n',
    nm.GroupOptions: '[[layer]]\nfile = "a.png"\n\n[[layer]]\n{}\n  [[layer.layer]]\n  file = "a.png"\n',
    nm.CanvasOptions: '[[layer]]\nfile = "a.png"\n\n[canvas]\n{}\n',
    nm.ReadOptions: '[[layer]]\nfile = "a.png"\n\n[layer.read]\n{}\n',
    nm.ReliefOptions: '[[layer]]\nfile = "a.png"\n\n[relief]\n{}\n',
    nm.SolidOptions: '[[layer]]\nfile = "a.png"\n\n[relief]\n{}\n',
    nm.PlateOptions: '[[layer]]\nfile = "a.png"\n\n[plate]\n{}\n',
    nm.FrameOptions: '[[layer]]\nfile = "a.png"\n\n[frame]\n{}\n',
    nm.TextOptions: '[[layer]]\nfile = "a.png"\n\n[[text]]\n{}\ntext = "ANNO"\n',
    nm.MachineOptions: '[[layer]]\nfile = "a.png"\n\n[machine]\n{}\n',
}
# the keys of plates differ from the names of their options
TABLES = {table.options: table for table in PLATE_TABLES.values()}
# options of these classes that a recipe does not have
ONLY_ELSEWHERE = {(nm.ReadOptions, "max_megapixels"), (nm.ReliefOptions, "memory_limit")}


def wrong_value(field: dataclasses.Field[Any]) -> Any:
    """A value of the right type that the field refuses; None if it accepts any value."""
    match kind_of(field):
        case Choice():
            return "rubbish"
        case Weight() | Positive():
            return -2.5
        case Count(low=low):
            return low - 7
        case Number(low=low):
            return math.floor(low) - 7.5 if low > -math.inf else math.inf
        case None | Switch():
            return None
        case kind:
            try:
                kind.read(field.name, "rub bish")
            except UsageError:
                return "rub bish"
    return None


REFUSED = [
    pytest.param(options, field.name, value, id=f"{options.__name__}.{field.name}")
    for options in CLASSES
    for field in dataclasses.fields(options)
    if (value := wrong_value(field)) is not None
]
REFUSED.append(pytest.param(nm.PackOptions, "bits", 12, id="PackOptions.bits"))
IN_RECIPES = [case for case in REFUSED if case.values[0] in RECIPES and case.values[:2] not in ONLY_ELSEWHERE]
# parameters of public functions that messages name, besides the fields of options
PARAMETERS = {"overwrite", "max_faces", "unit", "model", "mu_map", "surface", "state", "wall_mask"}
PARAMETERS |= {"detail", "depth", "faces", "format", "host", "port", "tile_px", "pitch_mm", "pyramid"}
# of TilingOptions
PARAMETERS |= {"tile", "workers", "scheduler", "work_folder"}


def strings() -> Iterator[tuple[str, str]]:
    """Every string of the library except docstrings, with its location."""
    for path in sorted(ROOT.rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        docs = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
        for node in ast.walk(tree):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docs:
                yield f"{path.relative_to(ROOT)}:{node.lineno}", node.value


def test_every_options_class_is_tested_with_a_wrong_value() -> None:
    # files may have any name
    assert {case.values[0] for case in REFUSED} >= set(CLASSES) - {nm.WriteOptions, nm.ReliefFiles}
    assert set(RECIPES) == {case.values[0] for case in IN_RECIPES}


@pytest.mark.parametrize(("options", "name", "value"), REFUSED)
def test_python_names_the_keyword(options: type[Options], name: str, value: Any) -> None:
    with pytest.raises(UsageError, match=rf"^`{name}=.*?`: \w") as told:
        options(**{name: value})
    text = str(told.value)
    assert told.value.options[0] == name
    assert told.value.found == value
    assert told.value.accepted
    found = text.removeprefix(f"`{name}=").partition("`")[0]
    assert found == repr(value) if isinstance(value, str) else float(found) == value
    assert "--" not in text


@pytest.mark.parametrize(
    ("text", "found", "accepted", "remedy"),
    [
        (
            "`fov=4`: must be 0 (orthographic) or at least 5, such as 35",
            4,
            "must be 0 (orthographic) or at least 5",
            "35",
        ),
        ("`mode='x'`: use one of over, rnm", "x", "use one of over, rnm", ""),
        ("a.png: found 3 channels, expected 4; export it again", None, "expected 4", "export it again"),
        ("`base` and `shell` are two kinds of back; give one of them", None, "", "give one of them"),
        ("a.png: is empty", None, "", ""),
        ("`fit='slope'`: needs `height`, such as `height='3mm'`", "slope", "needs `height`", "`height='3mm'`"),
    ],
)
def test_an_error_gives_its_parts(text: str, found: Any, accepted: str, remedy: str) -> None:
    error = UsageError(text)
    assert (error.found, error.accepted, error.remedy) == (found, accepted, remedy)


@pytest.mark.parametrize(("options", "name", "value"), REFUSED)
def test_the_command_line_names_the_flag(options: type[Options], name: str, value: Any, capsys: Any) -> None:
    assert run_guarded(lambda: options(**{name: value})) == 2
    (line,) = capsys.readouterr().err.splitlines()
    word = shlex.quote(value) if isinstance(value, str) else f"{value:g}"
    joined = "=" if word.startswith("-") else " "
    assert line.startswith(f"nmap: error: {flag_of(name)}{joined}{word}: ")
    assert "`" not in line


@pytest.mark.parametrize("written", ["_", "-"])
@pytest.mark.parametrize(("options", "name", "value"), IN_RECIPES)
def test_a_recipe_names_the_line_and_the_key(
    options: type[Options], name: str, value: Any, written: str, tmp_path: pathlib.Path
) -> None:
    word = f'"{value}"' if isinstance(value, str) else f"{value:g}"
    table = TABLES.get(options)
    key = written_name(name) if table is None else table.key(name)
    text = RECIPES[options].format(f"{key.replace('_', written)} = {word}")
    places = {nm.CanvasOptions: "canvas: ", nm.ReliefOptions: "relief: ", nm.SolidOptions: "relief: "}
    places |= {table.options: f"{title}: " for title, table in PLATE_TABLES.items()} | {nm.TextOptions: "text 1: "}
    place = places.get(options, "layer ")
    with pytest.raises(nm.InputError, match=rf"^scene\.toml: {place}") as told:
        nm.parse_recipe(tomllib.loads(text), name="scene.toml")
    (tmp_path / "scene.toml").write_text(text, encoding="utf-8")
    with pytest.raises(nm.InputError, match=rf"^scene\.toml, line 5: {place}") as located:
        nm.read_recipe(tmp_path / "scene.toml", name="scene.toml")
    assert str(located.value).replace(", line 5", "") == str(told.value)
    assert f": {key} = {word}: " in str(told.value)
    assert "--" not in str(told.value)
    assert "`" not in str(told.value)


def test_the_library_names_no_flag() -> None:
    assert [f"{place}: {text}" for place, text in strings() if re.search(r"--[a-z]", text)] == []


def test_options_that_are_mentioned_exist() -> None:
    """Every name in backticks in a message is a field of options or a parameter of a function."""
    known = PARAMETERS | {field.name for options in CLASSES for field in dataclasses.fields(options)}
    named = {(place, name) for place, text in strings() for name in options_in(text)}
    assert {(place, name) for place, name in named if name not in known} == set()
    assert len(named) > 60


def test_values_are_shown_in_shell_syntax() -> None:
    assert in_flags("`scale='a b'` and `swizzle='-g,r,b'`") == "--scale 'a b' and --swizzle=-g,r,b"
    assert in_flags("`overwrite=True`, `beta=0.25`") == "--overwrite, --beta 0.25"
    assert in_flags("`max_faces=20000000`") == "--max-faces 20000000"
    assert in_flags("file `a b`.exr stays") == "file `a b`.exr stays"
