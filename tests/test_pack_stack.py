"""Recipes packed for an image editor, and composed again from the edited workspace."""

import io
from types import SimpleNamespace

import numpy as np
import pytest
from compose_cases import angles_deg
from stack_cases import BUNNY_ON_PLATE, THROUGH_WIDE, write_maps

import nmaptool as nm

SCENE = f"""{BUNNY_ON_PLATE}at = "30%,50%"
rotate = 90
mask = "half.png"

[[layer]]
name = "pair"
  [[layer.layer]]
  name = "turned"
  file = "leaf.png"
  at = "70%,50%"
  rotate = 20
  [[layer.layer]]
  name = "moved"
  file = "leaf.png"
  at = "80%,60%"

[[layer]]
name = "grain"
file = "leaf.png"
at = "70%,50%"
mode = "pd"
strength = 0.5

[[layer]]
name = "wash"
{THROUGH_WIDE}  [[layer.layer]]
  file = "bunny.exr"
  at = "75%,20%"
  [[layer.layer]]
  file = "leaf.png"
  at = "75%,20%"
  mode = "pd"
"""


@pytest.fixture
def scene(tmp_path, png):
    write_maps(tmp_path, png)
    (tmp_path / "scene.toml").write_text(SCENE, encoding="utf-8")
    return tmp_path


@pytest.mark.parametrize(("ending", "bound_deg"), [("exr", 1e-3), ("psd", 0.02), ("ora", 0.02), ("tif", 0.02)])
def test_pack_unpack_and_stack_give_the_composition(scene, run, ending, bound_deg):
    packed, again = scene / f"work.{ending}", scene / "again.exr"
    assert run("compose", "pack", scene / "scene.toml", "-o", packed).code == 0
    done = run("compose", "unpack", packed, "-o", scene / "parts")
    assert done.code == 0, done.err + done.out
    assert run("compose", "stack", scene / "parts" / "recipe.toml", "-o", again).code == 0
    stack = nm.read_stack(scene / "scene.toml")
    expected = nm.compose(stack.layers, stack.canvas).normal_map
    made = nm.read_normal_map(again)
    assert made.frame == expected.frame
    assert angles_deg(made.normals, expected.normals).max() < bound_deg
    assert np.array_equal(made.coverage, expected.coverage)


def test_the_canvas_of_a_recipe_is_restored(scene, run):
    (scene / "flat.toml").write_text(
        '[canvas]\nsize = "50x45"\nground = "flat"\n[[layer]]\nfile = "bunny.exr"\n', encoding="utf-8"
    )
    run("compose", "pack", scene / "flat.toml", "-o", scene / "work.psd")
    run("compose", "unpack", scene / "work.psd", "-o", scene / "parts")
    assert nm.read_recipe(scene / "parts" / "recipe.toml").canvas == nm.CanvasOptions(
        "50x45", nm.length("25mm"), "flat"
    )


def test_layers_are_packed_where_they_are_composed(scene):
    stack = nm.read_stack(scene / "scene.toml")
    placed, frame = nm.place_layers(stack.layers, stack.canvas)
    assert frame == nm.Frame(60, 80, 0.5)
    assert [(one.name, one.group) for one in placed] == [
        ("", ()),
        ("bunny", ()),
        ("turned", ("pair",)),
        ("moved", ("pair",)),
        ("grain", ()),
        ("wash", ()),
    ]
    plate, bunny, _, _, grain, wash = placed
    assert np.array_equal(plate.normal_map.normals, stack.layers[0].normal_map.normals)
    whole = nm.compose(stack.layers[:2], stack.canvas)
    rows, cols = bunny.normal_map.frame.shape
    window = np.s_[bunny.top : bunny.top + rows, bunny.left : bunny.left + cols]
    assert np.array_equal(whole.placed[window], bunny.normal_map.coverage)
    assert whole.placed.sum() == bunny.normal_map.coverage.sum()
    assert (grain.mode, grain.strength, wash.mode, wash.strength) == ("pd", 0.5, "rnm", 0.5)
    assert wash.normal_map.coverage.max() == pytest.approx(0.8, abs=0.01)  # the group's mask is in its coverage


def test_flags_that_a_recipe_already_sets_are_refused(scene, refused):
    words = ("compose", "pack", scene / "scene.toml", "-o", scene / "work.psd")
    refused(2, "--at: applies to maps only; a recipe sets it for each layer", *words, "--at", "0,0")
    refused(2, r"scene\.toml: a recipe is packed alone", *words[:3], scene / "plate.exr", *words[3:])
    refused(2, r"bunny\.exr: is also an input", *words[:3], "-o", scene / "bunny.exr", "--overwrite")
    with pytest.raises(nm.InputError, match="nothing to pack: give at least one layer"):
        nm.place_layers([])


def test_a_layer_off_the_canvas_is_reported_with_its_line(scene, refused):
    (scene / "off.toml").write_text(
        '[[layer]]\nfile = "plate.exr"\n\n[[layer]]\nfile = "bunny.exr"\nat = "-9cm,0"\n', encoding="utf-8"
    )
    message = r"off.toml, line 4: layer 2 \(bunny.exr\): its area from .* is outside the canvas .*; move it with at$"
    refused(3, message, "compose", "pack", scene / "off.toml", "-o", scene / "work.psd")


def test_modes_given_to_pack_are_restored_in_the_recipe(scene, run, refused):
    words = ("compose", "pack", scene / "plate.exr", scene / "bunny.exr", "-o", scene / "work.psd")
    done = run(
        *words,
        "--mode",
        "over",
        "--mode",
        "pd",
        "--strength",
        "1",
        "--strength",
        "1.5",
        "--at",
        "0,0",
        "--at",
        "25%,5mm",
    )
    assert done.code == 0, done.err
    run("compose", "unpack", scene / "work.psd", "-o", scene / "parts")
    _, bunny = nm.read_recipe(scene / "parts" / "recipe.toml").layers
    assert (bunny.options.mode, bunny.options.strength) == ("pd", 1.5)
    assert bunny.options.at == "20px,10px"
    again = (*words[:-1], scene / "other.psd")
    refused(2, "--mode screen: use one of over, rnm", *again, "--mode", "screen", "--mode", "pd")
    refused(2, "--strength: given 1 times for 2 maps", *again, "--strength", "0.5")


def test_a_map_from_standard_input_is_named_standard_input(scene, run, monkeypatch):
    stream = SimpleNamespace(buffer=io.BytesIO((scene / "plate.exr").read_bytes()))
    monkeypatch.setattr("sys.stdin", stream)
    done = run("compose", "pack", "-", scene / "bunny.exr", "-o", scene / "work.psd")
    assert done.err.startswith("standard input: 80 x 60")
    assert "    standard input: 80 x 60 at 0,0" in done.err
