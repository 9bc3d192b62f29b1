"""Faults in recipes, in one line each: the location, the key, the value found and the values accepted."""

import re
import tomllib

import pytest

import nmaptool as nm
from nmaptool.io.recipes.lines import Lines

BUNNY = '[[layer]]\nfile = "plate.exr"\n[[layer]]\nname = "bunny"\nfile = "b.exr"\n'


def message_of(text, kind=nm.InputError, line_of=None):
    with pytest.raises(kind) as caught:
        nm.parse_recipe(tomllib.loads(text), name="scene.toml", line_of=line_of)
    (message,) = caught.value.args
    assert "\n" not in message
    return message


def line_in(text, kind=nm.InputError):
    """Return the line in the message; the rest of the message is the same without lines."""
    message = message_of(text, kind, Lines(text).of)
    (line,) = re.findall(r"^scene\.toml, line (\d+): ", message)
    assert message.replace(f", line {line}", "", 1) == message_of(text, kind)
    return int(line)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("rotation = 3", "unknown key 'rotation'; did you mean 'rotate'?"),
        ("Scale = 3", "unknown key 'Scale'; did you mean 'scale'?"),
        ("xyz = 3", "unknown key 'xyz'; use one of file, name, mode, strength, at, anchor, scale, rotate"),
        ("flip-h = true\nflip_h = true", "flip_h: is given twice, with _ and with -; remove one"),
        ('strength = "0.8"', "strength: found the text '0.8', expected a number such as 0.8"),
        ("strength = true", "strength: found true, expected a number such as 0.8"),
        ("strength = -1", "strength = -1: must be zero or more"),
        ("strength = 2", 'strength = 2: must lie between 0 and 1 for the mode "over"'),
        ("strength = nan", "strength = nan: must be zero or more"),
        ("rotate = [30]", "rotate: found a list, expected a number such as 30"),
        ("rotate = inf", "rotate = inf: must lie between -3600 and 3600"),
        (f"rotate = 1{'0' * 400}", "rotate: found a number of more than 30 digits, which is too large"),
        ("height_factor = 5000", "height_factor = 5000: must lie between -1000 and 1000, such as 1"),
        ("at = 5", 'at: found the number 5, expected text in quotes, such as "30%,50%"'),
        ('at = "30%"', 'at = "30%": expected 2 distances separated by commas, such as 30%,12mm'),
        ('at = "3,4"', "at = \"3,4\": distance '3': expected a number with a unit"),
        ('anchor = "middle"', 'anchor = "middle": use one of center, top-left'),
        ('mode = "multiply"', 'mode = "multiply": use one of over, rnm, pd'),
        ("mode = {}", 'mode: found a table, expected text in quotes, such as "over"'),
        ('clip = "maybe"', 'clip = "maybe": use one of auto, yes, no'),
        ("feather = 6", 'feather: found the number 6, expected text in quotes, such as "6px"'),
        ('feather = "wide"', 'feather = "wide": expected a number with a unit'),
        ('feather = "-2px"', 'feather = "-2px": must be zero or more'),
        ("scale = 0", 'scale = "0": expected one or two factors between 0.001 and 1000'),
        ('scale = "1,2,3"', 'scale = "1,2,3": expected one or two factors'),
        ('scale = "a,b"', 'scale = "a,b": expected one factor, two separated by a comma, or a width such as 30mm'),
        ("scale = false", 'scale: found false, expected a number such as 0.5, text such as "0.5,0.7" or "30mm"'),
        ('flip_h = "yes"', "flip_h: found the text 'yes', expected true or false"),
        ("hidden = 1", "hidden: found the number 1, expected true or false"),
        ("mask = 2026-01-01", "mask: found the date or time 2026-01-01, expected text in quotes"),
        ('mask = ""', "mask: found nothing, expected the name of a grey picture"),
        ("read = 1", "read: found the number 1, expected a table [layer.read]"),
        ('read.gren = "up"', "read: unknown key 'gren'; did you mean 'green'?"),
        ('read.green = "left"', 'read: green = "left": use one of auto, up, down'),
        ("read.zero_code = 128", "read: zero_code: found the number 128, expected text in quotes"),
        ('read.background_color = "pink"', 'read: background_color = "pink": use one of auto, none'),
        ("read.max_megapixels = 1000", "read: unknown key 'max_megapixels'; use one of layer, from, green"),
    ],
)
def test_wrong_keys_of_a_layer_are_named(line, message):
    assert f"scene.toml: layer 2 (bunny): {message}" in message_of(BUNNY + line)
    assert line_in(f"{BUNNY}# a comment\n\n{line}\n\n# the end") == 8 + line.count("\n")


@pytest.mark.parametrize(
    ("line", "text", "message"),
    [
        (None, "", "scene.toml: has no layers; start one with [[layer]]"),
        (None, "layer = []", "scene.toml: has no layers"),
        (1, 'layers = "a"', "scene.toml: unknown key 'layers'; did you mean 'layer'?"),
        (1, '[layer]\nfile = "a"', "scene.toml: [layer] is one table; write [[layer]], with double brackets"),
        (1, "layer = 3", "scene.toml: layer: found the number 3, expected tables [[layer]]"),
        (1, "layer = [3]", "scene.toml: layer 1: found the number 3, expected a table [[layer]]"),
        (1, "canvas = 3", "scene.toml: canvas: found the number 3, expected a table [canvas]"),
        (2, "[canvas]\nsise = 3", "scene.toml: canvas: unknown key 'sise'; did you mean 'size'?"),
        (
            2,
            "[canvas]\nsize = 3",
            'scene.toml: canvas: size: found the number 3, expected text in quotes, such as "1000x',
        ),
        (2, '[canvas]\nsize = "0x9"', 'scene.toml: canvas: size = "0x9": expected columns x rows in px'),
        (2, '[canvas]\nwidth = "9px"', 'scene.toml: canvas: width = "9px": sets the size of a pixel; give it in mm'),
        (2, '[canvas]\nwidth = "9"', 'scene.toml: canvas: width = "9": expected a number with a unit'),
        (2, '[canvas]\nground = "wood"', 'scene.toml: canvas: ground = "wood": use one of clear, flat'),
        (
            1,
            "[[layer]]",
            "scene.toml: layer 1: holds neither file, recipe nor layers; give one of them: file (a normal map), ",
        ),
        (
            3,
            '[[layer]]\nname = "x"\nlayer = []',
            "scene.toml: layer 1 (x): holds neither file, recipe nor layers; give one of",
        ),
        (2, '[[layer]]\nfile = "a"\nrecipe = "b"', "scene.toml: layer 1 (a): holds file and recipe; give one of them"),
        (2, '[[layer]]\nfile = ""', "scene.toml: layer 1: file: found nothing, expected the name of a normal map"),
        (2, '[[layer]]\nrecipe = ""', "scene.toml: layer 1: recipe: found nothing, expected the name of a recipe"),
        (2, "[[layer]]\nfile = 1", "scene.toml: layer 1: file: found the number 1, expected text"),
        (
            2,
            '[[layer]]\nat = "1px,1px"\n[[layer.layer]]\nfile = "a"',
            "scene.toml: layer 1: at: is for a layer with a file, not for a group; give it to its layers",
        ),
        (
            3,
            '[[layer]]\nrecipe = "a.toml"\nscale = 2',
            "scene.toml: layer 1 (a.toml): scale: is for a layer with a file, not for a recipe; give it to its layers",
        ),
        (
            2,
            '[[layer]]\n[layer.layer]\nfile = "a"',
            "scene.toml: layer 1: [layer.layer] is one table; write [[layer.layer]], with double brackets",
        ),
        (
            5,
            '[[layer]]\nname = "g"\n[[layer.layer]]\nfile = "sub/a.png"\nmood = 1',
            "scene.toml: layer 1.1 (a.png): unknown key 'mood'; did you mean 'mode'?",
        ),
        (2, '[[layer]]\nmode = "x"\n[[layer.layer]]\nfile = "a"', 'scene.toml: layer 1: mode = "x": use one of over'),
    ],
)
def test_wrong_recipes_are_refused(line, text, message):
    assert message in message_of(text)
    if line is not None:
        assert line_in(text) == line


def test_groups_nested_too_deeply_are_refused():
    depth = 17
    tables = "".join(f"[[{'.'.join(['layer'] * (i + 1))}]]\n" for i in range(depth))
    where = re.escape("layer " + ".".join(["1"] * (depth - 1)))
    text = f'{tables}file = "a"'
    message = message_of(text, nm.LimitError)
    assert re.match(f"scene.toml: {where}: groups are nested more than 16 deep; flatten them", message)
    assert line_in(text, nm.LimitError) == depth


def test_names_in_messages_are_short_and_printable():
    message = message_of(f'[[layer]]\nname = "a\\n\\u001b[31m{"b" * 90}"\nfile = 1')
    assert message.startswith("scene.toml: layer 1 (a [31mbbb")
    assert "...): file" in message


@pytest.mark.parametrize(
    ("line", "text"),
    [
        (1, 'layer = [{file = "a.png", strength = "much"}]'),
        (3, 'layer = [\n  {file = "a.png"},\n  {name = "b"},\n]'),
        (4, "layer = [\n  {layer = [ # [[layer]]\n    {file = 'a.png'},\n    {file = 'b.png', mode = 'x'},\n  ]},\n]"),
        (2, 'canvas.ground = "clear"\ncanvas.size = 3'),
        (4, '[[layer]]\nfile = "a.png"\nread.green = "up"\nread . "gren" = "up"'),
        (3, '[[layer]]\n"file" = "a.png"\n\'zero-code\' = 1'),
        (7, "[[layer]]\nfile = 'a.png'\nname = \"\"\"\n[[layer]]\nmode = 'x'\n\"\"\"\nmode = 'y'"),
        (5, '[[layer]]\nfile = "a.png"\n[canvas]\n[[layer]]\n  [[layer.layer]]\n  mode = "rnm"\n'),
        (6, '[[layer]]\nfile = "a.png"\n[[layer]]\nfile = "b.png"\n[layer.read]\nlayer = 1'),
    ],
)
def test_lines_are_found_however_a_key_is_written(line, text):
    assert line_in(text) == line
    assert line_in(text.replace("\n", "\r\n")) == line
