"""The tables of a recipe that describe a plate: what they mean, and how they are written."""

import dataclasses
import random
import tomllib

import pytest
from stack_cases import write_maps

import nmaptool as nm
from nmaptool.composition.recipe_toml import to_toml
from nmaptool.core.units import Length, Offset

LAYER = '[[layer]]\nfile = "bunny.exr"\n'
FULL = """[plate]
shape = "oval"
aspect = "3:4"
margin = "1.5mm"
fill = "inside"
hole = "3mm@50%,4mm; 2mm@-5mm,50%"
hole_rim = "0mm"
loop = "4mm"
engrave = true
draft = 5

[frame]
width = "3mm"
height = "0.3333333333333333mm"
profile = "rope"

[machine]
for = "cnc-3mm"
pitch = "0.1mm"
finest = "2mm"

[[text]]
text = "ANNO\\nMMXXVI"
size = "2mm"
height = "0.4mm"
sunk = true
at = "50%,-3mm"
spacing = 1.1
rotate = -30
font = "fonts/title.otf"

[[text]]
text = "\u05e9\u05dc\u05d5\u05dd \\"x\\""
path = "arc"
side = "bottom"
inset = "1mm"
"""


@pytest.fixture
def folder(tmp_path, png):
    return write_maps(tmp_path, png)


def parsed(text):
    return nm.parse_recipe(tomllib.loads(f"{LAYER}{text}"), name="coin.toml")


def test_every_key_sets_its_option():
    plate = parsed(FULL).plate
    assert nm.PlateOptions(**plate.plate) == nm.PlateOptions(
        shape="oval",
        aspect="3:4",
        margin="1.5mm",
        fill="inside",
        hole="3mm@50%,4mm; 2mm@-5mm,50%",
        hole_rim="0mm",
        loop="4mm",
        engrave=True,
        draft=5.0,
    )
    assert nm.FrameOptions(**plate.frame) == nm.FrameOptions(
        frame="3mm", frame_height=Length(1 / 3, "mm"), frame_profile="rope"
    )
    assert nm.MachineOptions(**plate.machine) == nm.MachineOptions(for_="cnc-3mm", pitch="0.1mm", finest="2mm")
    first, second = (nm.TextOptions(**text) for text in plate.texts)
    assert first == nm.TextOptions(
        text="ANNO\nMMXXVI",
        text_size="2mm",
        text_height="0.4mm",
        text_sunk=True,
        text_at="50%,-3mm",
        text_spacing=1.1,
        text_rotate=-30.0,
        font="fonts/title.otf",
    )
    assert second == nm.TextOptions(
        text='\u05e9\u05dc\u05d5\u05dd "x"', text_path="arc", text_side="bottom", text_inset="1mm"
    )
    given = {**plate.plate, **plate.frame, **plate.machine, **first.__dict__, **second.__dict__}
    options = (nm.PlateOptions, nm.FrameOptions, nm.MachineOptions, nm.TextOptions)
    every = {field.name for each in options for field in dataclasses.fields(each)}
    assert every - set(given) == {"corner", "emboss"}  # for other plates than this one


def test_a_recipe_with_a_plate_is_written_and_read_unchanged():
    recipe = parsed(FULL)
    text = to_toml(recipe)
    assert text.startswith(FULL)
    again = nm.parse_recipe(tomllib.loads(text), name="coin.toml")
    assert again == recipe
    assert to_toml(again) == text
    assert recipe.plate.frame["frame_height"] == Length(1 / 3, "mm")
    assert recipe.plate.plate["hole_rim"] == Offset(0.0, "mm")


def test_a_recipe_without_these_tables_has_no_plate():
    assert parsed("").plate is None
    assert "plate" not in to_toml(parsed(""))


def test_keys_may_have_hyphens_and_numbers_may_be_whole():
    plate = parsed('[plate]\nshape = "round"\nhole-rim = "1mm"\nhole = "3mm@50%,9%"\ndraft = 20\n').plate
    assert plate.plate["hole_rim"] == Offset(1.0, "mm")
    assert plate.plate["draft"] == 20.0


def test_a_plate_from_python_is_checked():
    with pytest.raises(nm.UsageError, match=r"`frame_height='2mm'`: needs `frame`"):
        nm.RecipePlate(frame={"frame_height": "2mm"})
    with pytest.raises(nm.UsageError, match=r"`shape='star'`: use rect, round"):
        nm.RecipePlate({"shape": "star"})
    with pytest.raises(nm.UsageError, match=r"`for_='lathe'`: use one of fdm-0\.4"):
        nm.RecipePlate(machine={"for_": "lathe"})
    with pytest.raises(nm.UsageError, match=r"`text_at='x'`: expected 2 distances"):
        nm.RecipePlate(texts=({"text": "A"}, {"text": "A", "text_at": "x"}))
    line = "<RecipePlate shape round, frame 1mm, for fdm-0.4, text 'ANNO'>"
    made = nm.RecipePlate({"shape": "round"}, {"frame": "1mm"}, ({"text": "ANNO"},), {"for_": "fdm-0.4"})
    assert repr(made) == line
    assert repr(nm.RecipePlate()) == "<RecipePlate no plate>"


def test_files_are_renamed_and_names_are_not():
    plate = nm.RecipePlate(
        {"shape": "shield.svg"},
        {"frame": "1mm", "frame_profile": "Ogee.SVG"},
        ({"text": "A", "font": "title.ttf"}, {"text": "B", "font": "DejaVu Sans"}, {"text": "C"}),
    )
    seen = []
    moved = plate.renamed(lambda name: seen.append(name) or f"new/{name}")
    assert seen == ["shield.svg", "Ogee.SVG", "title.ttf"]
    assert (moved.plate["shape"], moved.frame["frame_profile"]) == ("new/shield.svg", "new/Ogee.SVG")
    assert [text.get("font") for text in moved.texts] == ["new/title.ttf", "DejaVu Sans", None]
    same = nm.RecipePlate({"shape": "round"}, {"frame": "1mm"}, machine={"pitch": "0.1mm"})
    assert same.renamed(lambda name: f"new/{name}") == same


@pytest.mark.parametrize(
    ("machine", "given", "found"),
    [
        ({}, {"base": "1mm"}, {"base": "1mm"}),
        ({"for_": "fdm-0.4"}, {}, {"base": "2mm", "max_error": "0.02mm"}),
        ({"for_": "fdm-0.4"}, {"base": "1mm"}, {"base": "1mm", "max_error": "0.02mm"}),
        ({"for_": "fdm-0.4"}, {"base": None, "max_error": None}, {"base": "2mm", "max_error": "0.02mm"}),
        ({"for_": "fdm-0.4"}, {"shell": "1mm", "triangles": "2k"}, {"shell": "1mm", "triangles": "2k"}),
        ({"for_": "fdm-0.4"}, {"max_error": "1mm"}, {"base": "2mm", "max_error": "1mm"}),
    ],
)
def test_a_machine_sets_what_is_not_given(machine, given, found):
    plate = nm.RecipePlate(machine=machine)
    assert nm.SolidOptions(**plate.solid_values(given)) == nm.SolidOptions(**found)


def test_given_values_of_a_machine_stay():
    plate = nm.RecipePlate(machine={"for_": "fdm-0.4", "pitch": "0.3mm"})
    assert plate.machine_options == nm.MachineOptions(for_="fdm-0.4", pitch="0.3mm", finest="0.4mm")


def test_a_scene_has_the_plate_and_the_machine_of_its_recipe(folder):
    text = '[relief]\nwidth = "30mm"\nheight = "1mm"\n[plate]\nshape = "round"\n[machine]\nfor = "fdm-0.4"\n'
    (folder / "coin.toml").write_text(f"{LAYER}{text}", encoding="utf-8")
    scene = nm.read_scene(folder / "coin.toml")
    assert scene.design.plate.shape == "round"
    assert scene.solid == nm.SolidOptions(base="2mm", max_error="0.02mm")
    assert scene.machine == nm.MachineOptions(for_="fdm-0.4", pitch="0.1mm", finest="0.4mm")
    made = scene.solve()
    assert made.plate.width_mm == pytest.approx(30)
    assert made.pitch_mm == pytest.approx(0.1, rel=0.02)
    (folder / "bare.toml").write_text(f"{LAYER}{text.replace('shape', '# shape')}", encoding="utf-8")
    bare = nm.read_scene(folder / "bare.toml")
    assert bare.design is None
    solved = bare.solve()
    assert solved.plate is None
    assert solved.height.frame.cols == 300


def test_the_plate_of_a_recipe_inside_another_one_is_ignored_with_a_note(folder):
    (folder / "inner.toml").write_text(f'{LAYER}[plate]\nshape = "round"\n', encoding="utf-8")
    (folder / "outer.toml").write_text('[[layer]]\nrecipe = "inner.toml"\n', encoding="utf-8")
    recipe = nm.read_recipe(folder / "outer.toml")
    assert recipe.plate is None
    assert recipe.notes == (f"{folder / 'inner.toml'}: its plate is ignored; only its layers are used",)


def random_plate(rng):
    """A plate with random keys and values, also with text and file names that TOML must escape."""

    def some(makers):
        return {name: make() for name, make in makers.items() if rng.random() < 0.5}

    def size():
        return Length(rng.choice([rng.uniform(0.001, 10), 1 / 3, 12.0]), rng.choice(["mm", "cm", "m", "in", "px", "%"]))

    def words():
        return "".join(rng.choice('AB "\\\n\t\x07\u00e9\u4e2d#]=\u2028') for _ in range(rng.randint(1, 8))) + "x"

    plate = {"shape": rng.choice(["rect", "a b.svg", "C:\\x.svg"])}
    plate |= some(
        {"margin": size, "hole_rim": lambda: Offset(rng.random(), "mm"), "loop": size, "engrave": lambda: True}
    )
    plate |= some({"draft": lambda: rng.uniform(0, 60)})
    frame = {"frame": size(), **some({"frame_height": size, "frame_profile": lambda: rng.choice(["rope", "x y.svg"])})}
    texts = (
        {"text": words(), **some({"text_size": size, "text_sunk": lambda: True, "font": words})}
        for _ in range(rng.randint(0, 3))
    )
    machine = some({"for_": lambda: "fdm-0.4", "pitch": lambda: Length(rng.random() + 0.001, "mm")})
    return nm.RecipePlate(plate, frame, tuple(texts), machine)


def test_random_plates_are_written_and_read_unchanged(trials):
    for seed in range(trials(1000)):
        recipe = nm.Recipe((nm.RecipeLayer("a.png"),), plate=random_plate(random.Random(seed)))
        assert nm.parse_recipe(tomllib.loads(to_toml(recipe))).plate == recipe.plate, seed
