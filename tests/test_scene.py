"""The table [relief] of a recipe: a relief from a recipe equals one made step by step."""

import numpy as np
import pytest
from stack_cases import BUNNY_ON_PLATE, waves, write_maps

import nmaptool as nm
from nmaptool.core.errors import InputError, UsageError

RELIEF = """
[relief]
mu = 0.5
beta = 0.01
height = "2mm"
detail = "fine.exr"
mask = "wide.png"
base = "1mm"
"""


@pytest.fixture
def folder(tmp_path, png):
    write_maps(tmp_path, png)
    nm.write_normal_map(waves(60, 80, 40, 0.5), tmp_path / "fine.exr")
    (tmp_path / "scene.toml").write_text(BUNNY_ON_PLATE + RELIEF, encoding="utf-8")
    return tmp_path


def by_hand(folder, **changes):
    stack = nm.read_stack(folder / "scene.toml")
    original = nm.compose(stack.layers, stack.canvas).normal_map
    values = {"mu": 0.5, "beta": 0.01, "height": nm.length("2mm"), **changes}
    detail, mask = nm.read_normal_map(folder / "fine.exr"), nm.read_grey(folder / "wide.png")
    return nm.relief(original, detail, mask=mask, options=nm.ReliefOptions(**values))


def test_a_scene_gives_the_relief_of_its_steps(folder):
    scene = nm.read_scene(folder / "scene.toml")
    assert np.array_equal(nm.relief(**scene.inputs).z_mm, by_hand(folder).z_mm)
    assert scene.solid == nm.SolidOptions(base=nm.length("1mm"))
    assert [m.frame.shape for m in scene.maps] == [(60, 80), (40, 30), (60, 80)]


def test_the_table_is_restored_from_its_text(folder):
    recipe = nm.read_recipe(folder / "scene.toml")
    text = nm.to_toml(recipe)
    assert (
        '[relief]\ndetail = "fine.exr"\nmask = "wide.png"\nmu = 0.5\nbeta = 0.01\nheight = "2mm"\nbase = "1mm"\n'
        in text
    )
    (folder / "again.toml").write_text(text, encoding="utf-8")
    assert nm.read_recipe(folder / "again.toml") == recipe
    assert nm.read_recipe(folder / "again.toml").relief == recipe.relief
    assert recipe.files == ("plate.exr", "bunny.exr")  # those of the layers


def test_a_recipe_without_the_table_uses_the_defaults(folder):
    (folder / "scene.toml").write_text(BUNNY_ON_PLATE, encoding="utf-8")
    scene = nm.read_scene(folder / "scene.toml")
    assert (scene.options, scene.solid) == (nm.ReliefOptions(), nm.SolidOptions())
    assert scene.detail is scene.surface is None
    assert scene.greys == {}


def test_the_detail_may_be_a_recipe(folder):
    recipe = nm.read_recipe(folder / "scene.toml")
    (folder / "fine.toml").write_text('[[layer]]\nfile = "fine.exr"\n', encoding="utf-8")
    files = nm.ReliefFiles(detail="fine.toml", mask="wide.png")
    composed = nm.Recipe(recipe.layers, recipe.canvas, "mine", recipe.folder, relief=nm.RecipeRelief(files))
    plain = nm.Recipe(
        recipe.layers,
        recipe.canvas,
        folder=recipe.folder,
        relief=nm.RecipeRelief(nm.ReliefFiles(detail="fine.exr", mask="wide.png")),
    )
    found, expected = (nm.relief(**nm.read_scene(each).inputs) for each in (composed, plain))
    assert np.array_equal(found.z_mm, expected.z_mm)
    # it is composed on a canvas of the original's size, wherever its layer lies
    (folder / "fine.toml").write_text('[[layer]]\nfile = "leaf.png"\nat = "20%,20%"\n', encoding="utf-8")
    assert nm.read_scene(composed).detail.frame.shape == (60, 80)


def test_a_curved_background_is_read(folder):
    nm.write_normal_map(waves(60, 80, 3, 0.5), folder / "roll.exr")
    text = BUNNY_ON_PLATE + '[relief]\nbackground = "surface"\nsurface = "roll.exr"\nmask = "wide.png"\n'
    (folder / "scene.toml").write_text(text, encoding="utf-8")
    scene = nm.read_scene(folder / "scene.toml")
    assert scene.maps[-1].name.endswith("roll.exr")
    assert nm.relief(**scene.inputs).report.options.background == "surface"


def test_the_table_of_an_included_recipe_is_ignored_and_said(folder):
    (folder / "top.toml").write_text('[[layer]]\nrecipe = "scene.toml"\n', encoding="utf-8")
    recipe = nm.read_recipe(folder / "top.toml")
    assert recipe.relief is None
    assert any(note.endswith("its [relief] is ignored; only its layers are used") for note in recipe.notes)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("mu = -1", r"scene.toml, line 12: relief: mu = -1: "),
        ("beta = 'small'", r"line 12: relief: beta: found the text 'small', expected a number such as 0.001"),
        ("heigth = '3mm'", r"line 12: relief: unknown key 'heigth'; did you mean 'height'\?"),
        ("memory_limit = '8GB'", r"relief: unknown key 'memory_limit'"),
        ("max_iterations = 2.5", r"line 12: relief: max_iterations: found the number 2.5, expected a whole number"),
        ("mask = ''", r"line 12: relief: mask: found nothing, expected the name of a file"),
        ("hollow = '1mm'", r"line 12: relief: hollow = \"1mm\": needs base"),
        ("fit = 'slope'", r"line 12: relief: fit = \"slope\": needs height"),
    ],
)
def test_faults_name_the_line_and_the_key(folder, table, message):
    (folder / "scene.toml").write_text(f"{BUNNY_ON_PLATE}[relief]\n{table}\n", encoding="utf-8")
    with pytest.raises(InputError, match=message):
        nm.read_scene(folder / "scene.toml")


def test_other_faults_of_the_table(folder):
    (folder / "scene.toml").write_text(f"relief = 3\n{BUNNY_ON_PLATE}", encoding="utf-8")
    with pytest.raises(InputError, match=r"relief: found the number 3, expected a table \[relief\]"):
        nm.read_scene(folder / "scene.toml")
    (folder / "scene.toml").write_text(f'{BUNNY_ON_PLATE}[relief]\nmask = "none.png"\n', encoding="utf-8")
    with pytest.raises(InputError, match=r"scene.toml: relief: .*none.png: no such file"):
        nm.read_scene(folder / "scene.toml")
    with pytest.raises(UsageError, match=r"`mu=-1"):
        nm.RecipeRelief(options={"mu": -1})


def test_the_command_writes_the_bytes_of_its_steps(folder, run):
    done = run("relief", folder / "scene.toml", "-o", folder / "scene.stl", "--report", folder / "scene.json")
    assert done.code == 0, done.err
    relief = by_hand(folder)
    nm.write_relief(relief, folder / "steps.stl", solid=nm.solid(relief, nm.SolidOptions(base=nm.length("1mm"))))
    assert (folder / "scene.stl").read_bytes() == (folder / "steps.stl").read_bytes()
    assert "1 closed body" in done.err
    report = (folder / "scene.json").read_text(encoding="utf-8")
    assert '"recipe": ' in report
    assert "bunny.exr" in report


def test_flags_replace_keys(folder, run, monkeypatch):
    monkeypatch.chdir(folder.parent)
    name = f"{folder.name}/scene.toml"
    # the default value, given as a flag, replaces the recipe's, too
    # paths of flags are relative to the current folder
    flags = ["--height", "3mm", "--mu", "0.1", "--detail", f"{folder.name}/fine.exr"]
    done = run("relief", name, *flags, "-o", folder / "out.npy", "--at", "corners")
    assert done.code == 0, done.err
    assert np.array_equal(np.load(folder / "out.npy")["z_mm"], by_hand(folder, height=nm.length("3mm"), mu=0.1).z_mm)
    done = run("relief", name, "--base", "1mm", "-o", folder / "out.exr")
    assert done.code == 2
    assert "--base: is for meshes" in done.err


def test_no_file_of_the_recipe_is_overwritten(folder, run):
    for name in ("bunny.exr", "fine.exr"):
        done = run("relief", folder / "scene.toml", "-o", folder / name, "--overwrite")
        assert done.code == 2
        assert "is also an input" in done.err
