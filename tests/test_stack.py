"""The maps of a recipe give the result of nm.compose and nm.paste bit for bit."""

import os
from pathlib import Path

import numpy as np
import pytest
from stack_cases import SCENE, waves, write_maps

import nmaptool as nm


@pytest.fixture
def folder(tmp_path, png):
    return write_maps(tmp_path, png)


def composed(folder, text, reading=None):
    (folder / "scene.toml").write_text(text, encoding="utf-8")
    stack = nm.read_stack(folder / "scene.toml", reading)
    return nm.compose(stack.layers, stack.canvas)


def same(one, other):
    return all(
        np.array_equal(getattr(one.normal_map, name), getattr(other.normal_map, name))
        for name in ("normals", "coverage", "foreground")
    ) and np.array_equal(one.placed, other.placed)


def by_hand(folder):
    plate, bunny = (nm.read_normal_map(folder / name) for name in ("plate.exr", "bunny.exr"))
    leaf, turned = (nm.read_normal_map(folder / "leaf.png", nm.ReadOptions(green=g)) for g in ("auto", "down"))
    half, wide = (nm.read_grey(folder / name) for name in ("half.png", "wide.png"))
    options = nm.LayerOptions("bunny", "over", 0.8, "30%,12mm", "bottom", "0.7", 12.0, flip_h=True, feather="3px")
    small = nm.LayerOptions(at="60%,40%", scale="8mm", mode="pd", clip="no")
    group = nm.LayerGroup(
        (nm.Layer(turned, nm.LayerOptions(at="50%,50%")), nm.Layer(leaf, small)),
        nm.GroupOptions("ornaments", "rnm", 0.5),
        wide,
    )
    return plate, (nm.Layer(bunny, options, half), group)


def test_a_recipe_equals_the_same_call_of_compose_and_of_paste(folder):
    by_recipe = composed(folder, SCENE)
    plate, layers = by_hand(folder)
    width = nm.length("40mm")
    assert same(by_recipe, nm.compose((nm.Layer(plate), *layers), nm.CanvasOptions(width=width)))
    assert same(by_recipe, nm.paste(plate, layers, width=width))
    assert not np.array_equal(by_recipe.normal_map.normals, plate.normals)
    assert [layer["name"] for layer in by_recipe.report.layers] == ["bunny", "ornaments"]
    assert by_recipe.normal_map.frame == nm.Frame(60, 80, 0.5)


def test_a_recipe_sets_every_argument_of_compose(folder):
    (folder / "scene.toml").write_text(
        '[canvas]\nsize = "90x70"\nground = "flat"\n[[layer]]\nfile = "bunny.exr"\nat = "40%,50%"\n'
    )
    stack = nm.read_stack(folder / "scene.toml")
    assert stack.canvas == nm.CanvasOptions("90x70", ground="flat")
    assert nm.compose(stack.layers, stack.canvas).normal_map.frame.shape == (70, 90)


PLATE = '[[layer]]\nfile = "plate.exr"\n'
LEAF = '[[layer]]\nfile = "leaf.png"\nat = "50%,50%"\nmode = "rnm"\n'
BUNNY = '[[layer]]\nfile = "bunny.exr"\nat = "50%,50%"\n'


def nested(text):
    return "[[layer]]\n" + text.replace("[[layer", "[[layer.layer")


def test_a_group_of_one_layer_equals_that_layer(folder):
    assert same(composed(folder, PLATE + BUNNY), composed(folder, PLATE + nested(BUNNY)))
    twice = composed(folder, PLATE + nested(BUNNY) + nested(LEAF))
    (folder / "leaf.toml").write_text(LEAF, encoding="utf-8")
    assert same(twice, composed(folder, PLATE + nested(BUNNY) + '[[layer]]\nrecipe = "leaf.toml"\n'))


def test_order_matters_where_layers_overlap(folder):
    one, other = composed(folder, PLATE + BUNNY + LEAF), composed(folder, PLATE + LEAF + BUNNY)
    assert not np.array_equal(one.normal_map.normals, other.normal_map.normals)
    assert same(composed(folder, PLATE + LEAF + BUNNY), composed(folder, PLATE + BUNNY))  # the leaf is under the bunny


def test_hidden_layers_are_left_out_and_not_read(folder):
    shown = composed(folder, PLATE + BUNNY)
    gone = '[[layer]]\nfile = "gone.png"\nhidden = true\n'
    assert same(shown, composed(folder, gone + PLATE + BUNNY + nested(gone) + gone))
    assert same(shown, composed(folder, PLATE + BUNNY + '[[layer]]\nrecipe = "gone.toml"\nhidden = true\n'))
    with pytest.raises(nm.InputError, match=r"scene.toml: every layer is hidden; there is nothing to compose"):
        composed(folder, gone + nested(gone))


def test_a_mask_hides_what_is_black(folder):
    masked = composed(folder, PLATE + BUNNY + 'mask = "half.png"\n')
    plain, plate = composed(folder, PLATE + BUNNY), nm.read_normal_map(folder / "plate.exr")
    normals = masked.normal_map.normals
    assert np.array_equal(normals[:, :40], plain.normal_map.normals[:, :40])
    assert np.array_equal(normals[:, 40:], plate.normals[:, 40:])
    outside = composed(folder, PLATE + '[[layer]]\nmask = "wide.png"\n' + nested(BUNNY).removeprefix("[[layer]]\n"))
    assert np.array_equal(outside.normal_map.normals[:10], plate.normals[:10])


def test_a_layers_reading_options_override_the_general_ones(folder):
    down, up = nm.ReadOptions(green="down"), 'read.green = "up"\n'
    one = composed(folder, PLATE + up + BUNNY, down)
    other = composed(folder, PLATE + BUNNY + 'read.green = "down"\n')
    assert same(one, other)
    assert not same(one, composed(folder, PLATE + BUNNY))
    (folder / "scene.toml").write_text(PLATE + up + BUNNY, encoding="utf-8")
    recipe = nm.read_stack(folder / "scene.toml", down).recipe  # the recipe alone reproduces the result
    assert [layer.read for layer in recipe.layers] == [{"green": "up"}, {"green": "down"}]
    again = nm.read_stack(recipe)
    assert same(one, nm.compose(again.layers, again.canvas))


def test_a_file_is_read_once(folder, symlink):
    symlink(folder / "again.png", "leaf.png")
    again = LEAF.replace("leaf", "again")
    (folder / "scene.toml").write_text(PLATE + LEAF + LEAF + again + LEAF + 'read.green = "down"\n', encoding="utf-8")
    stack = nm.read_stack(folder / "scene.toml")
    maps = [layer.normal_map for layer in stack.layers]
    assert maps[1] is maps[2] is maps[3]
    assert maps[4] is not maps[1]
    assert [each.frame.cols for each in stack.maps] == [80, 24, 24]


def test_files_outside_the_folder_are_reported(folder, symlink, tmp_path_factory):
    far = tmp_path_factory.mktemp("far")
    for name in ("one.exr", "two.exr", "three.exr"):
        nm.write_normal_map(waves(10, 12, 2), far / name)
    scenes = folder / "scenes"
    scenes.mkdir()
    symlink(scenes / "link.exr", far / "two.exr")
    symlink(folder / "inner.exr", "plate.exr")
    nm.write_normal_map(waves(60, 80, 2), scenes / "near.exr")
    up = Path(os.path.relpath(far / "three.exr", scenes)).as_posix()
    here, away = scenes.as_posix(), far.as_posix()
    names = ("near.exr", "../scenes/near.exr", f"{here}/near.exr", f"{away}/one.exr", "link.exr", up, "../bunny.exr")
    text = "".join(f'[[layer]]\nfile = "{name}"\n' for name in names)
    (scenes / "scene.toml").write_text(text + 'mask = "../half.png"\n', encoding="utf-8")
    assert nm.read_stack(scenes / "scene.toml").outside == (*names[3:], "../half.png")
    (folder / "top.toml").write_text(
        '[[layer]]\nrecipe = "scenes/scene.toml"\n[[layer]]\nfile = "inner.exr"\n', encoding="utf-8"
    )
    assert nm.read_stack(folder / "top.toml").outside == (f"{away}/one.exr", "scenes/link.exr", f"scenes/{up}")


@pytest.mark.parametrize(
    ("text", "kind", "message"),
    [
        (PLATE + '[[layer]]\nfile = "no.exr"', nm.InputError, r"line 3: layer 2 \(no.exr\): .*no.exr: no such file"),
        (PLATE + 'mask = "no.png"', nm.InputError, r"line 1: layer 1 \(plate.exr\): .*no.png: no such file"),
        (
            PLATE + 'mask = "half.png"',
            nm.InputError,
            r"line 1: layer 1 \(plate.exr\): the mask of .* is 30 x 40, expected 80",
        ),
        ('[[layer]]\nfile = "scene.toml"', nm.InputError, r"line 1: layer 1 \(scene.toml\): .*is not a picture"),
        ('[[layer]]\nfile = "plate.exr:detail"', nm.InputError, r"line 1: layer 1 .*has no layer 'detail'"),
        (nested(PLATE) + 'mask = "no.png"', nm.InputError, r"line 2: layer 1.1 \(plate.exr\): .*no.png: no such file"),
        (PLATE + 'read.swizzle = "q"', nm.UsageError, r'line 1: layer 1 \(plate.exr\): swizzle = "q"'),
        ('[[layer]]\nfile = "a\\u0000b"', nm.InputError, r"line 1: layer 1 \(a b\): .*is not a valid file name"),
        (f'[[layer]]\nfile = "{"x" * 300}"', nm.InputError, r"line 1: layer 1 \(xxx.*cannot be read"),
    ],
)
def test_a_wrong_file_is_named_with_its_layer(folder, text, kind, message):
    with pytest.raises(kind, match=rf"scene.toml, {message}"):
        composed(folder, text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            BUNNY.replace("50%,50%", "900%,0"),
            r"line 3: layer 2 \(bunny.exr\): its area from .* is outside the canvas of 80 x 60",
        ),
        (BUNNY + "scale = 0.001\n", r"line 3: layer 2 \(bunny.exr\): covers no pixel of the canvas; check its mask"),
        (nested(BUNNY) + 'at = "-9cm,0"\n', r"line 4: layer 2.1 \(bunny.exr\): its area from .* is outside the canvas"),
        (nested(BUNNY).replace("[[layer]]", '[[layer]]\nmask="half.png"'), r"line 3: layer 2: the mask of group is 30"),
    ],
)
def test_a_layer_that_does_not_fit_is_reported_with_its_line(folder, text, message):
    (folder / "scene.toml").write_text(PLATE + text.replace('at = "50%,50%"\nat', "at"), encoding="utf-8")
    (folder / "outer.toml").write_text('# a recipe in a recipe\n[[layer]]\nrecipe = "scene.toml"\n', encoding="utf-8")
    for name in ("scene.toml", "outer.toml"):
        stack = nm.read_stack(folder / name)
        for compose in (nm.compose, nm.place_layers):
            with pytest.raises(nm.InputError, match=rf"scene.toml, {message}"):
                compose(stack.layers, stack.canvas)


def test_the_size_limit_applies_to_all_images_together(folder):
    reading = nm.ReadOptions(max_megapixels=0.0055)  # the plate has 4800 px, the leaf 480, the bunny 1200
    composed(folder, PLATE + LEAF + LEAF, reading)
    spent = r"other files of the recipe take 0.0048 of 0.0055 megapixels"
    with pytest.raises(nm.LimitError, match=rf"layer 2 \(bunny.exr\): .*bunny.exr: 30 x 40 .* \({spent}\)"):
        composed(folder, PLATE + BUNNY, reading)
    with pytest.raises(nm.LimitError, match=r"layer 2 .*half.png: 30 x 40 .*other files of the recipe take 0.006 of"):
        composed(folder, PLATE + BUNNY + 'mask = "half.png"\n', nm.ReadOptions(max_megapixels=0.0065))
    with pytest.raises(nm.LimitError, match=r"layer 1 .*plate.exr: 80 x 60 is .*more than the limit of 0.004; make it"):
        composed(folder, PLATE, nm.ReadOptions(max_megapixels=0.004))


def test_a_recipe_may_be_made_in_python(folder):
    layers = (nm.RecipeLayer("plate.exr"), nm.RecipeLayer("bunny.exr", nm.LayerOptions(at="50%,50%")))
    stack = nm.read_stack(nm.Recipe(layers), folder=folder)
    assert same(composed(folder, PLATE + BUNNY), nm.compose(stack.layers, stack.canvas))
    with pytest.raises(nm.InputError, match=r"a.toml: the recipe a.toml has not been read; use nmaptool.read_recipe"):
        nm.read_stack(nm.Recipe((nm.RecipeLink("a.toml", nm.GroupOptions("a.toml")),)), folder=folder)
