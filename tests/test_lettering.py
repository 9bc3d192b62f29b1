"""Shaping: size, area, kerning, ligatures, writing direction and missing glyphs, with the DejaVu fonts."""

from __future__ import annotations

import io
from itertools import pairwise

import numpy as np
import pytest
from fontTools.pens.areaPen import AreaPen
from fontTools.ttLib import TTFont

import nmaptool as nm
from nmaptool.core.curves import flatten_bezier
from nmaptool.lettering.place import straight
from nmaptool.lettering.rings import united
from nmaptool.lettering.shaping import lay_out, lay_out_lines
from nmaptool.options.plates.text import TextOptions
from nmaptool.types.contours import ring_area


@pytest.fixture(scope="module")
def sans():
    return nm.read_font("DejaVu Sans")


@pytest.fixture(scope="module")
def serif():
    return nm.read_font("DejaVu Serif:bold")


def exact_area(font, text, size_mm):
    """Area of the glyphs of letters by another library, from the curves themselves."""
    opened = TTFont(io.BytesIO(font.data))
    glyphs, names = opened.getGlyphSet(), opened.getBestCmap()
    total = 0.0
    for letter in text:
        pen = AreaPen(glyphs)
        glyphs[names[ord(letter)]].draw(pen)
        total += abs(pen.value)
    return total * (size_mm / opened["glyf"]["H"].yMax) ** 2


@pytest.mark.parametrize("text", ["HILFE", "BOS", "abcdgop", "8&%", "שלום", "ЖДФ"])
@pytest.mark.parametrize("size_mm", [0.8, 2.0, 15.0])
def test_area_of_letters_is_that_of_the_fonts_curves(sans, text, size_mm):
    made = straight([lay_out(sans, text, size_mm)])
    assert made.area_mm2 == pytest.approx(exact_area(sans, text, size_mm), rel=6e-4)
    fine = straight([lay_out(sans, text, size_mm, tolerance_mm=size_mm * 1e-6)])
    assert fine.area_mm2 == pytest.approx(exact_area(sans, text, size_mm), rel=2e-6)
    assert made.tolerance_mm == pytest.approx(min(0.002, size_mm / 4000))


def test_size_is_the_height_of_capitals(sans, serif):
    for font in (sans, serif):
        low, high = straight([lay_out(font, "H", 3.5)]).bounds_mm
        assert (low[1], high[1]) == pytest.approx((-1.75, 1.75), abs=1e-7)


def test_the_height_of_capitals_that_a_font_states_comes_before_that_of_its_h(sans):
    opened = TTFont(io.BytesIO(sans.data))
    real = opened["glyf"]["H"].yMax
    for stated, expected in ((real // 2, 7.0), (0, 3.5)):
        table = opened["OS/2"]
        table.version, table.sCapHeight = 2, stated
        table.sxHeight = table.usDefaultChar = table.usBreakChar = table.usMaxContext = 0
        stream = io.BytesIO()
        opened.save(stream)
        font = nm.Font(stream.getvalue(), "changed")
        height = np.ptp(straight([lay_out(font, "H", 3.5)]).bounds_mm[:, 1])
        assert height == pytest.approx(expected, rel=1e-3)


def test_flattened_curves_keep_to_the_tolerance():
    rng = np.random.default_rng(3)
    for _ in range(100):
        controls = rng.normal(size=(int(rng.integers(3, 5)), 2))
        tolerance = 10 ** rng.uniform(-4, -1)
        polygon = np.concatenate([controls[:1], flatten_bezier(controls, tolerance)])
        curve = np.concatenate([controls[:1], flatten_bezier(controls, 1e-7)])
        nearest = np.full(len(curve), np.inf)
        for begin, end in pairwise(polygon):
            edge = end - begin
            part = ((curve - begin) @ edge / (edge @ edge)).clip(0, 1)
            nearest = np.minimum(nearest, np.hypot(*(begin + part[:, None] * edge - curve).T))
        assert nearest.max() <= tolerance * (1 + 1e-6)


def test_rings_are_clean_also_where_letters_or_contours_overlap(serif):
    crowded = straight([lay_out(serif, "WAVE", 4.0, 0.6)])
    apart = straight([lay_out(serif, "WAVE", 4.0)])
    assert crowded.area_mm2 < apart.area_mm2 * 0.98
    again = united(crowded.rings)
    assert again.area_mm2 == pytest.approx(crowded.area_mm2, rel=1e-9)
    assert len(again.rings) == len(crowded.rings)


def test_outer_rings_run_counter_clockwise_and_holes_clockwise(sans):
    areas = [ring_area(ring) for ring in straight([lay_out(sans, "O", 10.0)]).rings]
    assert sorted(area > 0 for area in areas) == [False, True]
    assert len(straight([lay_out(sans, "B8i", 10.0)]).rings) == 3 + 3 + 2


def test_pairs_are_kerned(serif):
    def width(text):
        return lay_out(serif, text, 2.0).advance_mm

    assert width("AV") < width("A") + width("V") - 0.05
    assert width("HI") == pytest.approx(width("H") + width("I"))


def test_spacing_is_a_factor_of_the_length_and_undoes_ligatures(sans):
    plain, wide = lay_out(sans, "office", 2.0), lay_out(sans, "office", 2.0, 1.25)
    assert [cluster.text for cluster in plain.clusters] == ["o", "ffi", "c", "e"]
    assert [cluster.text for cluster in wide.clusters] == list("office")
    even = lay_out(sans, "HILDE", 2.0, 1.25)
    assert even.advance_mm == pytest.approx(lay_out(sans, "HILDE", 2.0).advance_mm * 1.25)
    gaps = np.diff(even.starts_mm)[:-1] - [cluster.advance_mm for cluster in even.clusters[:-1]]
    assert np.ptp(gaps) < 1e-12


def test_accents_stay_with_their_letters(sans):
    # a letter and a combining accent, which the font draws apart from it
    assert [cluster.text for cluster in lay_out(sans, "q\u0301a", 2.0).clusters] == ["q\u0301", "a"]


def test_right_to_left_text_stands_in_the_order_in_which_it_is_drawn(sans):
    assert lay_out(sans, "שלום", 2.0).text == "שלום"[::-1]
    assert lay_out(sans, "שלום 123", 2.0).text == "123 " + "שלום"[::-1]
    assert lay_out(sans, "abc שלום 12 xyz", 2.0).text == "abc 12 " + "שלום"[::-1] + " xyz"


def test_arabic_letters_join_and_are_not_pulled_apart(sans):
    line, wide = lay_out(sans, "بيت", 4.0), lay_out(sans, "بيت", 4.0, 1.5)
    assert wide.advance_mm == line.advance_mm
    # one body and the dots of the three letters, whereas letters apart are three bodies
    assert len(straight([line]).rings) == 1 + 1 + 2 + 2
    assert line.advance_mm < sum(lay_out(sans, letter, 4.0).advance_mm for letter in "بيت")
    two, wide = lay_out(sans, "بيت بيت", 4.0), lay_out(sans, "بيت بيت", 4.0, 1.5)
    assert wide.advance_mm == pytest.approx(1.5 * two.advance_mm)


def test_scripts_are_shaped_one_by_one(sans):
    assert [c.is_joined for c in lay_out(sans, "aب1", 2.0).clusters] == [False, True, True]


def test_lines_of_a_text_keep_empty_lines_between(sans):
    lines = lay_out_lines(sans, "\nAB\n\nC\n", 2.0)
    assert [line and line.text for line in lines] == ["AB", None, "C"]


def test_repr_of_a_line(sans):
    assert repr(lay_out(sans, "AB", 2.0)) == "<TextLine 'AB': 2 clusters, 3.75887 x 2 mm>"


@pytest.mark.parametrize(
    ("text", "changes", "error", "message"),
    [
        ("", {}, nm.InputError, "the text is empty; give at least one letter"),
        (" \t", {}, nm.InputError, "the text is empty"),
        ("A\nB", {}, nm.InputError, r"the text 'A\\nB' has a line break; only a straight text has several lines"),
        ("A漢B字", {}, nm.InputError, r"the font DejaVu Sans \(DejaVuSans.ttf\) lacks '字' \(U\+5B57\) and '漢' "),
        ("\u200b\u200b", {}, nm.InputError, "draws nothing for the text"),
        ("A" * 2001, {}, nm.LimitError, "the text has 2001 characters, more than 2000; use a shorter text"),
        ("A", {"size_mm": 0.0}, nm.UsageError, "`size_mm=0.0`: must be a number greater than zero"),
        ("A", {"spacing": float("nan")}, nm.UsageError, "`spacing=nan`: must be a number greater than zero"),
        ("A", {"tolerance_mm": -1.0}, nm.UsageError, "`tolerance_mm=-1.0`: must be a number greater than zero"),
    ],
)
def test_what_cannot_be_laid_out_is_refused(sans, text, changes, error, message):
    with pytest.raises(error, match=message):
        lay_out(sans, text, **{"size_mm": 2.0, **changes})


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"text": "A\\nB", "text_path": "arc"}, "only a straight text has several lines, `text_path='line'`"),
        ({"text": "\\n "}, "is empty; give at least one letter"),
        ({"text_spacing": 9.0}, r"`text_spacing=9`: must lie between 0.5 and 5, such as 1.1"),
    ],
)
def test_options_of_a_text_are_checked(values, message):
    with pytest.raises(nm.UsageError, match=message):
        TextOptions(**values)


def test_a_command_line_may_write_a_line_break_as_two_characters():
    assert TextOptions(text="A\\nB").wording == TextOptions(text=" A\nB").wording == "A\nB"
