"""Recipes as values: they are restored from their text, and match the options."""

import tomllib

import pytest
from stack_cases import SCENE

import nmaptool as nm
from nmaptool.core.units import Offset

NASTY = (
    "ä漢😀",
    'say "no"',
    "back\\slash",
    "tab\tand\nbreak\r",
    "\x00\x1f\x7f\x85\u2028\ufeff",
    "'''",
    '"""',
    "# [a]",
    " ",
)


def parsed(text, **more):
    return nm.parse_recipe(tomllib.loads(text), **more)


def test_a_recipe_matches_the_options():
    recipe = parsed(SCENE, name="scene.toml")
    plate, bunny, ornaments = recipe.layers
    assert recipe.canvas == nm.CanvasOptions(width=nm.length("40mm"))
    assert plate == nm.RecipeLayer("plate.exr")
    assert bunny == nm.RecipeLayer(
        "bunny.exr",
        nm.LayerOptions(
            name="bunny",
            at="30%,12mm",
            anchor="bottom",
            scale="0.7",
            rotate=12.0,
            flip_h=True,
            feather=Offset(3, "px"),
            strength=0.8,
        ),
        mask="half.png",
    )
    assert ornaments.options == nm.GroupOptions("ornaments", "rnm", 0.5)
    assert ornaments.mask == "wide.png"
    assert [layer.read for layer in ornaments.layers] == [{"green": "down"}, {}]
    assert [layer.origin for layer in (*recipe.layers, *ornaments.layers)] == [
        "scene.toml: layer 1 (plate.exr)",
        "scene.toml: layer 2 (bunny)",
        "scene.toml: layer 3 (ornaments)",
        "scene.toml: layer 3.1 (leaf.png)",
        "scene.toml: layer 3.2 (leaf.png)",
    ]
    assert recipe.files == ("plate.exr", "bunny.exr", "half.png", "wide.png", "leaf.png")


def test_a_recipe_written_and_read_is_the_same_recipe():
    recipe = parsed(SCENE)
    text = nm.to_toml(recipe)
    assert parsed(text) == recipe
    assert nm.to_toml(parsed(text)) == text
    assert 'anchor = "bottom"\nscale = 0.7\nrotate = 12\n' in text
    assert "clip" not in text.replace('clip = "no"', "")  # defaults are not written


@pytest.mark.parametrize("name", NASTY)
def test_names_of_any_kind_are_restored(name):
    layer = nm.RecipeLayer(name, nm.LayerOptions(name=name), mask=name, read={"layer": name})
    group = nm.RecipeGroup((layer, nm.RecipeLink(name, nm.GroupOptions(name="x"))), nm.GroupOptions(name=name), name)
    recipe = nm.Recipe((layer, nm.RecipeLink(name, nm.GroupOptions(name=name)), group))
    text = nm.to_toml(recipe)
    assert parsed(text) == recipe
    assert all(c.isprintable() or c == "\n" for c in text)
    assert "\n" not in parsed(text, name="a.toml").layers[0].origin


def test_a_name_that_text_cannot_hold_is_refused():
    recipe = nm.Recipe((nm.RecipeLayer("b\udcffd.png"),))
    with pytest.raises(nm.InputError, match=r"b\?d.png: the file name is not valid UTF-8; rename the file"):
        nm.to_toml(recipe)


@pytest.mark.parametrize(
    "options",
    [
        nm.LayerOptions(strength=0.1 + 0.2, rotate=1e-7, height_factor=-1 / 3),
        nm.LayerOptions(feather=Offset(10 / 3, "mm"), scale="0.50", mode="linear", clip="yes"),
        nm.LayerOptions(scale="0.5,0.7", at=" 1px , -2.5cm", flip_v=True, strength=0),
        nm.LayerOptions(scale="30mm", feather="0"),
    ],
)
def test_numbers_are_restored_bit_for_bit(options):
    recipe = nm.Recipe(
        (nm.RecipeLayer("a.png", options),), nm.CanvasOptions("10x20", nm.length("33.3333333333mm"), "flat")
    )
    assert parsed(nm.to_toml(recipe)) == recipe


def test_hidden_layers_and_links_are_kept_and_listed():
    text = """
    [[layer]]
    file = "a.png"
    hidden = true
    [[layer]]
    recipe = "b.toml"
    strength = 0.5
    [[layer]]
      [[layer.layer]]
      recipe = "c.toml"
      name = "c"
      hidden = true
      [[layer.layer]]
      file = "d.png"
    """
    recipe = parsed(text)
    assert recipe.hidden == ("recipe: layer 1 (a.png)", "recipe: layer 3.1 (c)")
    assert recipe.files == ("d.png",)
    assert recipe.layers[1] == nm.RecipeLink("b.toml", nm.GroupOptions("b.toml", strength=0.5))
    assert recipe.layers[2].options.name == "group"
    assert parsed(nm.to_toml(recipe)) == recipe


def test_invalid_layer_values_are_refused_in_python_too():
    for make, message in (
        (lambda: nm.RecipeLayer(""), "file: found nothing"),
        (lambda: nm.RecipeLayer("a.png", read={"greeen": "up"}), "a.png: read: unknown key 'greeen'; use one of layer"),
        (lambda: nm.RecipeLayer("a.png", read={"max_megapixels": 1e9}), "unknown key 'max_megapixels'"),
        (lambda: nm.RecipeGroup(()), "group: a group needs at least one layer"),
        (lambda: nm.RecipeLink(""), "recipe: found nothing"),
        (lambda: nm.Recipe(()), r"recipe: has no layers; start one with \[\[layer\]\]"),
    ):
        with pytest.raises(nm.InputError, match=message):
            make()
    with pytest.raises(nm.UsageError, match="`green='left'`"):
        nm.RecipeLayer("a.png", read={"green": "left"})
