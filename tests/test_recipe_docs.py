"""docs/recipes.md: every key with its default, and an example that runs."""

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest
from stack_cases import waves

import nmaptool as nm
from nmaptool.composition.recipe_parsing import GROUP_KEYS, LAYER_KEYS
from nmaptool.core.mentions import written_name
from nmaptool.core.units import Length, Offset
from nmaptool.options.fields import kind_of
from nmaptool.options.kinds import Choice, NameOrFile
from nmaptool.types.recipe import READ_KEYS
from nmaptool.types.recipe_plate import PLATE_TABLES

TEXT = (Path(__file__).parents[1] / "docs" / "recipes.md").read_text(encoding="utf-8")
BESIDE = {"hidden": "`false`"}  # keys that are not options of a layer


def table(title):
    """Key and default of each table row under a heading."""
    part = TEXT.split(f"\n## {title}\n")[1].split("\n## ")[0]
    rows = re.findall(r"^\| `(\w+)` \| (.*?) ?\| (.+) \|$", part, re.MULTILINE)
    return {key: (default, words) for key, default, words in rows}


def written(key, value):
    if value is None:
        return ""
    if isinstance(value, bool):
        return "`true`" if value else "`false`"
    return f'`"{value}"`' if isinstance(value, str) and key != "scale" else f"`{value:g}`" if key != "scale" else "`1`"


@pytest.mark.parametrize(
    ("title", "options", "keys"),
    [
        ("[canvas]", nm.CanvasOptions, ("size", "width", "ground")),
        ("[[layer]] with a file", nm.LayerOptions, LAYER_KEYS),
        ("[[layer]] as a group", nm.GroupOptions, GROUP_KEYS),
        ("[layer.read]", nm.ReadOptions, READ_KEYS),
        ("[relief]", nm.ReliefFiles, tuple(f.name for f in dataclasses.fields(nm.ReliefFiles))),
    ],
)
def test_every_key_is_documented_with_its_default(title, options, keys):
    rows = table(title)
    assert sorted(rows) == sorted(map(written_name, keys))
    fields = dataclasses.fields(options)
    defaults = {written_name(field.name): written(field.name, field.default) for field in fields} | BESIDE
    for key, (default, words) in rows.items():
        assert default == defaults.get(key, ""), key
        assert words.endswith("."), key


@pytest.mark.parametrize(
    ("title", "name"), [("[plate]", "plate"), ("[frame]", "frame"), ("[[text]]", "text"), ("[machine]", "machine")]
)
def test_every_key_of_a_plate_is_documented_with_its_default(title, name):
    rows, known = table(title), PLATE_TABLES[name]
    fields = {known.key(field.name): field for field in dataclasses.fields(known.options)}
    assert list(rows) == list(fields)
    for key, (default, words) in rows.items():
        assert default == written(key, fields[key].default), key
        assert words.endswith("."), key
        kind = kind_of(fields[key])
        names = kind.names if isinstance(kind, Choice | NameOrFile) else ()
        assert set(re.findall(r'`"([\w.-]+)"`', words)) >= set(names), key


def test_the_example_of_a_coin_runs(tmp_path, run):
    example = re.findall(r"```toml\n(.*?)```", TEXT, re.DOTALL)[-1]
    (tmp_path / "coin.toml").write_text(example.replace("resin-0.05", "fdm-0.4"), encoding="utf-8")  # fewer pixels
    nm.write_layers(nm.split(waves(64, 64, 9, disc=True)), tmp_path / "portrait.exr")
    done = run("relief", tmp_path / "coin.toml", "-o", tmp_path / "coin.3mf")
    assert done.code == 0, done.err
    for line in (
        "round plate 38 x 38 mm",
        "frame bead, 1.5 mm wide and 0.9 mm high",
        "text 'LIBERTAS': capitals 2.4 mm",
        "text 'MMXXVI': capitals 2 mm",
        "hole of 2 mm",
        "sets pitch 0.1mm, max error 0.02mm, finest 0.4mm; given: base 1.6mm",
    ):
        assert line in done.err
    assert nm.read_recipe(tmp_path / "coin.toml").plate.texts[1]["text_side"] == "bottom"


def test_every_value_of_a_key_is_documented():
    rows = table("[[layer]] with a file")
    for key, words in (
        ("mode", ("over", "rnm", "pd", "whiteout", "udn", "linear", "overlay")),
        (
            "anchor",
            ("center", "top-left", "top", "top-right", "left", "right", "bottom-left", "bottom", "bottom-right"),
        ),
        ("clip", ("yes", "no", "auto")),
    ):
        assert set(re.findall(r'`"([a-z-]+)"`', rows[key][1])) >= set(words)
        for word in words:
            nm.LayerOptions(**{key: word})


def test_the_example_runs(tmp_path, png, run):
    example, relief, _ = re.findall(r"```toml\n(.*?)```", TEXT, re.DOTALL)
    (tmp_path / "scene.toml").write_text(f"{example}\n{relief}", encoding="utf-8")
    (tmp_path / "detail.toml").write_text('[[layer]]\nfile = "leaf.png"\n', encoding="utf-8")
    nm.write_normal_map(waves(90, 120, 3), tmp_path / "plate.exr")
    nm.write_normal_map(waves(40, 50, 6, disc=True), tmp_path / "leaf.png")
    bunny = waves(64, 64, 9, disc=True)
    nm.write_layers(nm.split(bunny), tmp_path / "bunny.exr")
    png(tmp_path / "bunny_mask.png", np.full((64, 64), 255, np.uint8))
    (tmp_path / "border.toml").write_text(
        '[[layer]]\nfile = "leaf.png"\nat = "8%,10%"\nscale = 0.2\n', encoding="utf-8"
    )
    done = run("compose", "stack", tmp_path / "scene.toml", "-o", tmp_path / "scene.exr")
    assert done.code == 0, done.err
    for line in (
        "layer 5 (idea): hidden, left out",
        "  bunny: over at",
        "  ornaments: rnm, strength 0.5",
        "  border.toml",
    ):
        assert line in done.err
    done = run("relief", tmp_path / "scene.toml", "-o", tmp_path / "scene.stl", "--triangles", "5k")
    assert done.code == 0, done.err
    assert "= 3.000 mm" in done.err
    recipe = nm.read_recipe(tmp_path / "scene.toml")
    used = {key for layer in recipe.layers for key in re.findall(r"(\w+) =", nm.to_toml(nm.Recipe((layer,))))}
    assert used >= {"file", "at", "anchor", "scale", "rotate", "feather", "mask", "strength", "mode", "green", "hidden"}


def test_lengths_in_a_recipe_are_exact_bit_for_bit():
    canvas = nm.CanvasOptions(width=Length(1e-5 / 3, "in"))
    layer = nm.RecipeLayer("a.png", nm.LayerOptions(feather=Offset(1 / 3, "%")))
    text = nm.to_toml(nm.Recipe((layer,), canvas))
    assert f'width = "{1e-5 / 3!r}in"' in text
    assert f'feather = "{1 / 3!r}%"' in text
