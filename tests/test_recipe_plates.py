"""The tables of a recipe that describe a plate: what they mean, how they are written, and every message about them."""

import dataclasses
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


# what follows the layer, which takes two lines; the line of the fault; what is said
FAULTS = {
    # unknown keys
    '[plate]\nshap = "round"\n': (4, r"plate: unknown key 'shap'; did you mean 'shape'\?"),
    '[plate]\nframe = "3mm"\n': (4, r"plate: unknown key 'frame'; did you mean|plate: unknown key 'frame'; use one of"),
    '[frame]\nframe_width = "3mm"\n': (4, r"frame: unknown key 'frame_width'; did you mean 'width'\?"),
    '[frame]\ncolour = "red"\n': (4, r"frame: unknown key 'colour'; use one of width, height, profile"),
    '[[text]]\ntext = "A"\ntext_size = "2mm"\n': (5, r"text 1: unknown key 'text_size'; did you mean '\w+'\?"),
    '[machine]\nnozzle = "0.4mm"\n': (4, r"machine: unknown key 'nozzle'; use one of for, pitch, finest"),
    '[plates]\nshape = "round"\n': (3, r"unknown key 'plates'; did you mean 'plate'\?"),
    '[plate]\nhole_rim = "1mm"\nhole-rim = "1mm"\n': (5, r"plate: hole_rim: is given twice, with _ and with -"),
    # types
    "[plate]\nshape = 3\n": (4, r'plate: shape: found the number 3, expected text in quotes, such as "shield\.svg"'),
    '[plate]\nshape = "round"\nmargin = 5\n': (
        5,
        r'margin: found the number 5, expected text in quotes, such as "5mm"',
    ),
    '[plate]\nshape = "round"\nengrave = "yes"\n': (5, r"engrave: found the text 'yes', expected true or false"),
    '[plate]\nshape = "round"\ndraft = "12"\n': (5, r"draft: found the text '12', expected a number such as 12"),
    "[frame]\nwidth = true\n": (4, r'frame: width: found true, expected text in quotes, such as "3mm"'),
    "[[text]]\ntext = 2026\n": (4, r'text 1: text: found the number 2026, expected text in quotes, such as "ANNO MMXX'),
    '[[text]]\ntext = "A"\nspacing = "wide"\n': (5, r"text 1: spacing: found the text 'wide', expected a number such"),
    "[machine]\nfor = 3\n": (4, r'machine: for: found the number 3, expected text in quotes, such as "fdm-0\.4"'),
    # values
    '[plate]\nshape = "star"\n': (4, r'plate: shape = "star": use rect, round, oval, mask or an SVG file, such as shi'),
    '[plate]\nshape = "oval"\naspect = "3"\n': (
        5,
        r'plate: aspect = "3": expected width:height up to 20:1, such as 3:4',
    ),
    '[plate]\nshape = "round"\nmargin = "wide"\n': (5, r'plate: margin = "wide": expected a number with a unit'),
    '[plate]\nshape = "round"\nmargin = "-1mm"\n': (5, r'plate: margin = "-1mm": must be greater than zero'),
    '[plate]\nshape = "round"\nfill = "crop"\n': (5, r'plate: fill = "crop": use one of auto, inside, cover'),
    '[plate]\nshape = "round"\nhole = "3mm"\n': (
        5,
        r'plate: hole = "3mm": expected DIAMETER@ACROSS,DOWN, such as 4mm@50',
    ),
    '[plate]\nshape = "round"\nhole = "a@1,2"\n': (5, r'plate: hole = "a@1,2": expected DIAMETER@ACROSS,DOWN, such'),
    '[plate]\nshape = "round"\nhole_rim = "-1mm"\n': (5, r'plate: hole_rim = "-1mm": must be zero or more'),
    '[plate]\nshape = "round"\ndraft = 75\n': (5, r"plate: draft = 75: must lie between 0 and 60, such as 12"),
    '[frame]\nwidth = "3mm"\nprofile = "fancy"\n': (
        5,
        r'frame: profile = "fancy": use flat, round, bevel, rope, bead or an',
    ),
    '[[text]]\ntext = "A"\npath = "spiral"\n': (5, r'text 1: path = "spiral": use one of line, arc, circle, ring'),
    '[[text]]\ntext = "A"\nside = "left"\n': (5, r'text 1: side = "left": use one of top, bottom'),
    '[[text]]\ntext = "A"\nspacing = 0.1\n': (5, r"text 1: spacing = 0.1: must lie between 0.5 and 5, such as 1.1"),
    '[[text]]\ntext = "A"\nrotate = 720\n': (5, r"text 1: rotate = 720: must lie between -360 and 360, such as 90"),
    '[[text]]\ntext = "A"\nat = "middle"\n': (
        5,
        r'text 1: at = "middle": expected 2 distances separated by commas, such',
    ),
    '[[text]]\ntext = "A"\nsize = "0mm"\n': (5, r'text 1: size = "0mm": must be greater than zero'),
    '[[text]]\ntext = "  "\n': (4, r'text 1: text = "  ": is empty; give at least one letter'),
    '[machine]\nfor = "lathe"\n': (4, r'machine: for = "lathe": use one of fdm-0.4, resin-0.05, cnc-3mm, laser-254dpi'),
    '[machine]\npitch = "2%"\n': (4, r'machine: pitch = "2%": sets the size of a pixel; give it in mm, cm, m or in'),
    # what does not fit together
    '[plate]\nmargin = "5mm"\n': (4, r'plate: margin = "5mm": needs a plate, such as shape = "round"'),
    '[plate]\nfill = "cover"\n': (4, r'plate: fill = "cover": needs a plate, such as shape = "round"'),
    '[plate]\nshape = "round"\naspect = "3:4"\n': (5, r'aspect = "3:4": is for shape = "rect" or shape = "oval", not'),
    '[plate]\nshape = "oval"\ncorner = "1mm"\n': (5, r'corner = "1mm": is for shape = "rect", not oval'),
    '[plate]\nshape = "round"\nemboss = true\nengrave = true\n': (
        6,
        r"plate: engrave and emboss exclude each other; give",
    ),
    '[frame]\nheight = "2mm"\n': (4, r'frame: height = "2mm": needs width, such as width = "3mm"'),
    '[frame]\nprofile = "rope"\n': (4, r'frame: profile = "rope": needs width, such as width = "3mm"'),
    '[[text]]\ntext = "A"\npath = "arc"\nat = "1mm,1mm"\n': (
        6,
        r'text 1: at = "1mm,1mm": is for a straight text, path = "line"',
    ),
    '[[text]]\ntext = "A"\npath = "arc"\nrotate = 3\n': (
        6,
        r'text 1: rotate = 3: is for a straight text, path = "line"',
    ),
    '[[text]]\ntext = "A"\ninset = "1mm"\n': (5, r'inset = "1mm": is for a text along the edge, such as path = "arc"'),
    '[[text]]\ntext = "A\\nB"\npath = "arc"\n': (
        4,
        r"text 1: text = .*: only a straight text has several lines, path = \"line\"",
    ),
    # tables
    '[text]\ntext = "A"\n': (3, r"\[text\] is one table; write \[\[text\]\], with double brackets"),
    '[[text]]\ntext = "A"\n[[text]]\npath = "arc"\n': (
        5,
        r'text 2: text: found nothing, expected letters, such as text = "ANNO',
    ),
    "[[plate]]\nshape = 'round'\n": (3, r"plate: found a list, expected a table \[plate\]"),
    "[[frame]]\nwidth = '1mm'\n": (3, r"frame: found a list, expected a table \[frame\]"),
    "[[machine]]\nfor = 'fdm-0.4'\n": (3, r"machine: found a list, expected a table \[machine\]"),
}
# these stand before the layer, where they are keys of the recipe
KEYS = {
    'plate = "round"\n': r"plate: found the text 'round', expected a table \[plate\]",
    'text = "ANNO"\n': r"text: found the text 'ANNO', expected tables \[\[text\]\]",
    "text = [3]\n": r"text 1: found the number 3, expected a table \[\[text\]\]",
}


@pytest.mark.parametrize("text", FAULTS)
def test_a_fault_is_one_line_with_place_key_value_and_remedy(text, tmp_path):
    line, said = FAULTS[text]
    (tmp_path / "coin.toml").write_text(f"{LAYER}{text}", encoding="utf-8")
    with pytest.raises(nm.InputError, match=said) as found:
        nm.read_recipe(tmp_path / "coin.toml", name="coin.toml")
    told = str(found.value)
    assert told.startswith(f"coin.toml, line {line}: ")
    assert "\n" not in told
    assert "`" not in told
    assert "--" not in told
    with pytest.raises(nm.InputError) as bare:
        parsed(text)
    assert str(bare.value) == told.replace(f", line {line}", "")


@pytest.mark.parametrize("text", KEYS)
def test_a_key_in_the_place_of_a_table(text):
    with pytest.raises(nm.InputError, match=KEYS[text]):
        nm.parse_recipe(tomllib.loads(f"{text}{LAYER}"), name="coin.toml")


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
    assert made.plate.width_mm == 30
    assert made.pitch_mm == pytest.approx(0.1, rel=0.02)
    (folder / "bare.toml").write_text(f"{LAYER}{text.replace('shape', '# shape')}", encoding="utf-8")
    bare = nm.read_scene(folder / "bare.toml")
    assert bare.design is None
    solved = bare.solve()
    assert solved.plate is None
    assert solved.height.frame.cols == 300


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            '[[text]]\ntext = "A"\n',
            r'coin\.toml: \[\[text\]\]: needs a plate; add \[plate\] with a shape, such as shape = "round"',
        ),
        ('[frame]\nwidth = "1mm"\n', r"coin\.toml: \[frame\]: needs a plate; add"),
        ('[plate]\nshape = "no.svg"\n', r"coin\.toml: \S*no\.svg: no such file"),
        (
            '[plate]\nshape = "round"\n[frame]\nwidth = "1mm"\nprofile = "no.svg"\n',
            r"coin\.toml: \S*no\.svg: no such file",
        ),
        ('[plate]\nshape = "round"\n[[text]]\ntext = "A"\nfont = "no.ttf"\n', r"coin\.toml: \S*no\.ttf: no such file"),
        (
            '[plate]\nshape = "round"\n[[text]]\ntext = "A"\nfont = "Nope"\n',
            r"coin\.toml: font 'Nope': is not installed",
        ),
    ],
)
def test_what_a_scene_lacks_is_named_with_its_recipe(text, said, folder):
    (folder / "coin.toml").write_text(f"{LAYER}{text}", encoding="utf-8")
    with pytest.raises(nm.InputError, match=said) as found:
        nm.read_scene(nm.read_recipe(folder / "coin.toml", name="coin.toml"))
    assert "\n" not in str(found.value)
    assert "`" not in str(found.value)
