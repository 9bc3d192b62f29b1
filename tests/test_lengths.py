"""Lengths and distances as text: every unit and every way to write it."""

import pytest

import nmaptool as nm
from nmaptool.core.units import Length, Offset, offset


@pytest.mark.parametrize(
    ("text", "value", "unit"),
    [
        ("12mm", 12.0, "mm"),
        ("1.5 cm", 1.5, "cm"),
        (".5m", 0.5, "m"),
        ("2in", 2.0, "in"),
        ("2inch", 2.0, "in"),
        (" 2 Inch ", 2.0, "in"),
        ('2"', 2.0, "in"),
        ('0.25 "', 0.25, "in"),
        ("2\u2033", 2.0, "in"),
        ("1e2px", 100.0, "px"),
        ("3.5%", 3.5, "%"),
    ],
)
def test_a_length_has_a_number_and_a_unit(text, value, unit):
    assert nm.length(text) == Length(value, unit)
    assert offset(f"-{text.strip()}") == Offset(-value, unit)
    assert nm.length(str(nm.length(text))) == Length(value, unit)


def test_an_inch_has_25_4_millimetres_however_it_is_written():
    for text in ("2in", "2inch", '2"', "2\u2033"):
        assert nm.length(text).to_mm(pitch_mm=1.0, longer_side_px=10) == 50.8
        assert nm.ReliefOptions(width=text).width.is_absolute


@pytest.mark.parametrize("text", ["", "mm", "3", "3 inches", "3''", "3'", "3 mm2", "3ft", "1,5mm", "--3mm", "3 m m"])
def test_other_text_is_no_length(text):
    with pytest.raises(nm.UsageError, match=r"expected a number with a unit \(mm, cm, m, in, px, %\), such as 12mm"):
        nm.length(text)
    with pytest.raises(nm.UsageError, match=r"expected a number with a unit \(mm, cm, m, in, px, %\), such as 12mm"):
        offset(text)


def test_inches_in_recipes_and_on_the_command_line_are_the_same(tmp_path, run):
    nm.write_normal_map(nm.NormalMap.from_array([[[0.0, 0.0, 1.0]] * 8] * 8), tmp_path / "flat.exr")
    for written in ('1"', "1inch", "1in"):
        done = run("relief", tmp_path / "flat.exr", "--width", written, "--save-recipe", "-")
        assert done.code == 0, done.err
        assert 'width = "1in"' in done.out
        recipe = nm.parse_recipe({"layer": [{"file": "a.png"}], "relief": {"width": written}})
        assert recipe.relief.options["width"] == Length(1.0, "in")
