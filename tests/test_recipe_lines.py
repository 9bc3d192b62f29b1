"""The lines of keys in TOML text: every key that tomllib finds gets the line where it is written."""

import itertools
import random
import re
import tomllib

import pytest

from nmaptool.io.recipes.lines import Lines

SCENE = """\
# [[layer]] in a comment
canvas.size = "9x9"
canvas . "width" = "9mm"  # "quoted"

[[layer]]
name = '''
[[layer]]
file = "no key"
'''
file = "a.png"
read.green = "up"
'strength' = 0.5
read.swizzle = "x"

[canvas.more]
x = 1

[[layer]]
  [[layer.layer]]
  file = \"""\\
  "b" \\\""" ]}'''
\"""
  [layer.layer.read]
  zero-code = "128"

  [["layer".layer]]
  "fi\\u006ce" = "c.png"
"""


def paths(values, above=()):
    """Yield the keys of everything in values."""
    pairs = values.items() if isinstance(values, dict) else enumerate(values) if isinstance(values, list) else ()
    for key, value in pairs:
        yield (*above, key)
        yield from paths(value, (*above, key))


def found_in(text):
    """Return the line of everything that tomllib finds."""
    lines = Lines(text)
    return {keys: lines.of(keys) for keys in paths(tomllib.loads(text))}


@pytest.mark.parametrize("ending", ["\n", "\r\n"])
def test_a_scene_has_the_expected_lines(ending):
    first, second = ("layer", 0), ("layer", 1)
    assert found_in(SCENE.replace("\n", ending)) == {
        ("canvas",): 2,
        ("canvas", "size"): 2,
        ("canvas", "width"): 3,
        ("canvas", "more"): 15,
        ("canvas", "more", "x"): 16,
        ("layer",): 5,
        first: 5,
        (*first, "name"): 6,
        (*first, "file"): 10,
        (*first, "read"): 11,
        (*first, "read", "green"): 11,
        (*first, "strength"): 12,
        (*first, "read", "swizzle"): 13,
        second: 18,
        (*second, "layer"): 19,
        (*second, "layer", 0): 19,
        (*second, "layer", 0, "file"): 20,
        (*second, "layer", 0, "read"): 23,
        (*second, "layer", 0, "read", "zero-code"): 24,
        (*second, "layer", 1): 26,
        (*second, "layer", 1, "file"): 27,
    }


def test_lists_and_inline_tables_are_followed():
    text = """layer = [ # ]
  {file = "a.png", read = {green = "up"}},

  {file = "]}", layer = [[
    1, 2
  ]]}, 3]
x = 1"""
    layer = ("layer", 1, "layer")
    assert found_in(text) == {
        ("layer",): 1,
        ("layer", 0): 2,
        ("layer", 0, "file"): 2,
        ("layer", 0, "read"): 2,
        ("layer", 0, "read", "green"): 2,
        ("layer", 1): 4,
        ("layer", 1, "file"): 4,
        layer: 4,
        (*layer, 0): 4,
        (*layer, 0, 0): 5,
        (*layer, 0, 1): 5,
        ("layer", 2): 6,
        ("x",): 7,
    }


def test_missing_keys_have_the_line_of_the_table_around_them():
    lines = Lines(SCENE)
    assert lines.of(("layer", 1, "mode")) == 18
    assert lines.of(("layer", 1, "layer", 0, "read", "green")) == 23
    assert lines.of(("layer", 7, "file")) == 5
    assert lines.of(("other",)) == lines.of(()) == 1
    assert Lines("").of(("layer", 0)) == 1


def test_keys_are_found_with_underscores():
    lines = Lines("[a]\nflip-h = 1\nflip_h = 2\nheight-factor = 3\n")
    assert [lines.of(("a", key)) for key in ("flip-h", "flip_h", "height_factor", "height-factor")] == [2, 3, 4, 4]


class Writer:
    """Random TOML. Every key and every number is there once; strings and comments hold what only looks like TOML."""

    traps = ("[[x]]", "x = 1", "#", "{", "]", "=", "'''", '\\"', "\\\\", "a, b")

    def __init__(self, seed):
        self.rng = random.Random(seed)
        self.numbers = itertools.count(1)

    def key(self):
        key = f"k{next(self.numbers)}"
        return self.rng.choice([key, key, f'"{key}"', f"'{key}'"])

    def keys(self):
        return self.rng.choice([".", " . "]).join(self.key() for _ in range(self.rng.choice([1, 1, 1, 2, 3])))

    def string(self):
        traps = " ".join(self.rng.sample(self.traps, 3))
        plain = traps.replace("\\", "").replace("'", "")
        lines = traps.replace(" ", "\n")
        return self.rng.choice([f'"{traps}"', f"'{plain}'", f'"""{lines}"""', f"'''\n{plain}\n''\n'''", '""""a"""""'])

    def value(self, depth=0):
        kind = self.rng.choice(["number", "string", "date", "list", "table"][: 5 if depth < 3 else 3])
        if kind == "list":
            blank = self.rng.choice(["", " ", "\n", " # ]\n\n"])
            inner = f",{blank}".join(self.value(depth + 1) for _ in range(self.rng.randrange(4)))
            return f"[{blank}{inner}{blank}{',' if inner and blank != ' ' else ''}]"
        if kind == "table":
            pairs = (f"{self.keys()} = {self.value(depth + 1)}" for _ in range(self.rng.randrange(3)))
            return f"{{ {', '.join(pairs)} }}"
        number = f"1{next(self.numbers)}"
        return {"number": number, "string": self.string(), "date": f"{number:0>4}-01-01 07:32:00"}[kind]

    def text(self):
        headers = [""]
        lines = []
        for _ in range(12):
            lines += [f"{self.keys()} = {self.value()}  # [x]" for _ in range(self.rng.randrange(3))]
            around = self.rng.choice(headers)
            inner = f"{around}.{self.keys()}" if around else self.keys()
            if self.rng.random() < 0.5:
                headers.append(inner)
                lines.append(f"  [[ {inner} ]] # [[x]]")
            else:
                lines.append(f"[{inner}]")
            lines += [""] * self.rng.randrange(2)
        return "\n".join(lines)


@pytest.mark.parametrize("seed", range(150))
def test_every_key_of_random_text_is_found(seed):
    text = Writer(seed).text()
    values = tomllib.loads(text)
    lines = Lines(text)
    for keys in paths(values):
        value = values
        for key in keys:
            value = value[key]
        word = keys[-1] if isinstance(keys[-1], str) else str(value) if type(value) is int else None
        if word:
            place = re.search(rf"\b{word}\b", text).start()
            assert lines.of(keys) == text.count("\n", 0, place) + 1, keys


def test_deeply_nested_lists_are_followed():
    assert Lines(f"x = [{'[' * 90}1{']' * 90}]\ny = 1").of(("y",)) == 2
