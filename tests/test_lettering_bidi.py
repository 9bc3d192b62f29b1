"""Order of text in two directions, with the cases of UAX #9."""

from __future__ import annotations

import pytest

from nmaptool.lettering.bidi import embedding_levels, visual_order


def shown(text):
    """A text in which capitals stand for Hebrew, as it is drawn."""
    letters = {chr(ord("A") + i): chr(0x5D0 + i) for i in range(26)}
    levels = embedding_levels("".join(letters.get(letter, letter) for letter in text))
    mirrored = str.maketrans("()", ")(")  # which the shaping does
    return "".join(text[i].translate(mirrored if levels[i] % 2 else {}) for i in visual_order(levels))


@pytest.mark.parametrize(
    ("text", "drawn"),
    [
        ("car is THE CAR in", "car is RAC EHT in"),
        ("THE car IS BLUE", "EULB SI car EHT"),
        ("SUM 1,234.56 END", "DNE 1,234.56 MUS"),
        ("COSTS $12 NOW", "WON $12 STSOC"),
        ("A (b) C", "C (b) A"),
        ("a (B) c", "a (B) c"),
        ("a (B C) D", "a (C B) D"),
        ("A(b)C", "C(b)A"),
        ("1 A 2 b", "b 2 A 1"),
        ("abc", "abc"),
        ("ABC ", " CBA"),
        ("", ""),
    ],
)
def test_text_is_reordered(text, drawn):
    assert shown(text) == drawn


def test_digits_after_arabic_letters_are_arabic_numbers():
    assert embedding_levels("م1,2") == [1, 2, 2, 2]
    assert embedding_levels("م1-2") == [1, 2, 1, 2]
    assert embedding_levels("א1-2") == [1, 2, 2, 2]
    assert embedding_levels("a م٣%") == [0, 0, 1, 2, 0]


def test_marks_and_controls_take_the_level_of_their_letter():
    assert embedding_levels("אָa\u0301") == [1, 1, 2, 2]
    assert embedding_levels("a\u200dא\u200d") == [0, 0, 1, 0]
