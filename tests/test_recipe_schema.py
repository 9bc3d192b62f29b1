"""Recipe keys are derived from the options' fields: every field can be written and is checked."""

import dataclasses

import pytest

import nmaptool as nm
from nmaptool.composition.recipe_parsing import GROUP_KEYS, LAYER_KEYS
from nmaptool.core.errors import InputError
from nmaptool.core.mentions import written_name
from nmaptool.options.fields import kind_of
from nmaptool.options.kinds import Choice, Count
from nmaptool.types.recipe import READ_KEYS, RELIEF_KEYS

RELIEF = (nm.ReliefFiles, nm.ReliefOptions, nm.SolidOptions)
# other keys without which a value is refused
NEEDS = {
    "fit": {"height": "3mm"},
    "edge_height": {"edge": "wall"},
    "outline_round": {"background": "cut"},
    "hollow": {"base": "3mm"},
}


def relief_with(key, value):
    needs = NEEDS.get(key.replace("-", "_"), {})
    return {"relief": {key: value, **needs}, "layer": [{"file": "a.png"}]}


HELD = {
    nm.LayerOptions: lambda key, value: {"layer": [{"file": "a.png", key: value}]},
    nm.GroupOptions: lambda key, value: {"layer": [{"layer": [{"file": "a.png"}], key: value}]},
    nm.CanvasOptions: lambda key, value: {"canvas": {key: value}, "layer": [{"file": "a.png"}]},
    nm.ReadOptions: lambda key, value: {"layer": [{"file": "a.png", "read": {key: value}}]},
    **dict.fromkeys(RELIEF, relief_with),
}
FIELDS = [
    pytest.param(options, field, id=f"{options.__name__}.{field.name}")
    for options in HELD
    for field in dataclasses.fields(options)
    if {nm.ReadOptions: READ_KEYS, nm.ReliefOptions: RELIEF_KEYS}.get(options, (field.name,)).count(field.name)
]


def example_of(field):
    """A value of the field as TOML reads it."""
    kind = kind_of(field)
    if kind.toml is bool:
        return True
    if isinstance(kind, Choice):
        assert kind.such_as in kind.names
    if isinstance(kind, Count):
        return int(kind.such_as)
    return float(kind.such_as) if kind.toml is float else kind.such_as


def options_in(recipe, options):
    (layer,) = recipe.layers
    if options is nm.CanvasOptions:
        return recipe.canvas
    if options in RELIEF:
        made = recipe.relief.files, nm.ReliefOptions(**recipe.relief.options), nm.SolidOptions(**recipe.relief.solid)
        return made[RELIEF.index(options)]
    return nm.ReadOptions(**layer.read) if options is nm.ReadOptions else layer.options


@pytest.mark.parametrize(("options", "field"), FIELDS)
def test_every_field_can_be_written_in_a_recipe(options, field):
    value = example_of(field)
    recipe = nm.parse_recipe(HELD[options](written_name(field.name), value))
    found = options_in(recipe, options)
    more = {key: value for key, value in NEEDS.get(field.name, {}).items() if options in RELIEF}
    assert found == options(**{field.name: value, **more})
    assert nm.parse_recipe(HELD[options](written_name(field.name).replace("_", "-"), value)) == recipe


@pytest.mark.parametrize(("options", "field"), FIELDS)
def test_every_field_refuses_a_value_of_another_type_in_one_line(options, field):
    wanted = {bool: "true or false", float: r"a (whole )?number such as \d", str: "text in quotes, such as"}[
        kind_of(field).toml
    ]
    with pytest.raises(InputError, match=rf"{written_name(field.name)}: found a list, expected {wanted}"):
        nm.parse_recipe(HELD[options](written_name(field.name), [1]))


@pytest.mark.parametrize("components", ["xy", "octahedral"])
def test_the_components_of_a_layer_file_are_read(components):
    recipe = nm.parse_recipe({"layer": [{"file": "a.png", "read": {"components": components}}]})
    assert recipe.layers[0].read == {"components": components}


def test_the_keys_match_the_options():
    assert {f.name for f in dataclasses.fields(nm.LayerOptions)} == set(LAYER_KEYS) - {"file", "mask", "hidden", "read"}
    own = {"layer", "recipe", "mask", "hidden"}
    assert {f.name for f in dataclasses.fields(nm.GroupOptions)} == set(GROUP_KEYS) - own
