"""Faults in the tables of a recipe that describe a plate: each message names file, line, table, key and remedy."""

import tomllib

import pytest
from stack_cases import write_maps

import nmaptool as nm

LAYER = '[[layer]]\nfile = "bunny.exr"\n'

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
        nm.parse_recipe(tomllib.loads(f"{LAYER}{text}"), name="coin.toml")
    assert str(bare.value) == told.replace(f", line {line}", "")


@pytest.mark.parametrize("text", KEYS)
def test_a_key_in_the_place_of_a_table(text):
    with pytest.raises(nm.InputError, match=KEYS[text]):
        nm.parse_recipe(tomllib.loads(f"{text}{LAYER}"), name="coin.toml")


@pytest.fixture
def folder(tmp_path, png):
    return write_maps(tmp_path, png)


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
