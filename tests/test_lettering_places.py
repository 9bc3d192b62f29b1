"""Where letters stand: straight, on arcs, around circles and other curves."""

from __future__ import annotations

import numpy as np
import pytest

import nmaptool as nm
from nmaptool.lettering.curve import TextCurve, curve_around
from nmaptool.lettering.place import along, around, repeated, spread, straight
from nmaptool.lettering.rings import cross_section
from nmaptool.lettering.shaping import lay_out, lay_out_lines
from nmaptool.types.contours import ring_area

RADIUS = 15.0


@pytest.fixture(scope="module")
def serif():
    return nm.read_font("DejaVu Serif:bold")


def circle(radius=RADIUS, count=3600):
    turn = np.arange(count) * (2 * np.pi / count)
    return radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)


def outer(contours):
    return [ring for ring in contours.rings if ring_area(ring) > 0]


def middles(contours):
    """Middle of the bounds of each letter."""
    return np.array([(ring.min(axis=0) + ring.max(axis=0)) / 2 for ring in outer(contours)])


def angles(points):
    """Clockwise from the top, in degrees, sorted."""
    return np.sort(np.degrees(np.arctan2(points[:, 0], points[:, 1])))


def turned(points, degrees):
    """Points turned counter-clockwise."""
    cos, sin = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return points @ np.array([[cos, sin], [-sin, cos]])


def overlap(one, other):
    """Part of an area that two shapes have in common."""
    return (cross_section(one.rings) ^ cross_section(other.rings)).area() / one.area_mm2


def test_straight_text_is_centred_by_its_outlines(serif):
    for text in ("AVATAR", "J", "Typography 2026", "שלום", "f"):
        low, high = straight([lay_out(serif if text.isascii() else nm.read_font("DejaVu Sans"), text, 3.0)]).bounds_mm
        assert low[0] == pytest.approx(-high[0], abs=1e-7)
    low, high = straight([lay_out(serif, "HIH", 3.0)]).bounds_mm
    assert (low[1], high[1]) == pytest.approx((-1.5, 1.5), abs=1e-7)
    symmetric = straight([lay_out(serif, "HOIOH", 3.0)])
    mirrored = nm.Contours(tuple(np.ascontiguousarray((ring * (-1, 1))[::-1]) for ring in symmetric.rings))
    assert overlap(symmetric, mirrored) > 0.98


def test_lines_stand_below_each_other_at_the_fonts_distance(serif):
    lines = lay_out_lines(serif, "HHH\nI\n\nH", 3.0)
    made = straight(lines)
    pitch = lines[0].line_height_mm
    low, high = made.bounds_mm
    assert high[1] == pytest.approx(-low[1]) == pytest.approx((3.0 + 3 * pitch) / 2)
    heights = sorted({round(y, 6) for y in middles(made)[:, 1]})
    assert np.diff(heights) == pytest.approx([2 * pitch, pitch], abs=1e-5)
    x = [ring[:, 0].min() + ring[:, 0].max() for ring in outer(made) if abs(ring[:, 1].mean()) < pitch]
    assert x == pytest.approx([0.0], abs=1e-6)


def test_a_rotated_text_is_the_text_rotated(serif):
    line = lay_out(serif, "Rotate me", 3.0)
    plain, rotated = straight([line]), straight([line], 33.0)
    expected = nm.Contours(tuple(turned(ring, 33.0) for ring in plain.rings))
    assert rotated.area_mm2 == pytest.approx(plain.area_mm2, rel=1e-7)
    assert overlap(rotated, expected) == pytest.approx(1.0, abs=1e-6)


def test_letters_on_an_arc_stand_at_the_angles_of_their_advances(serif):
    line = lay_out(serif, "HIHIHHI", 2.0)
    made = around(line, circle())
    centres = line.starts_mm[:-1] + [c.advance_mm / 2 for c in line.clusters] - sum(line.ink_mm) / 2
    expected = np.degrees(centres / RADIUS)
    # the rings of letters in order from left to right
    assert angles(middles(made)) == pytest.approx(expected, abs=0.1)
    for ring, angle in zip(sorted(outer(made), key=lambda r: r[:, 0].mean()), expected, strict=True):
        upright = turned(ring, angle)  # as if at the top: the feet stand on the circle, the head is above
        assert upright[:, 1].min() == pytest.approx(RADIUS, abs=1e-4)
        assert upright[:, 1].max() == pytest.approx(RADIUS + 2.0, abs=1e-4)


def test_at_the_bottom_letters_read_from_left_to_right_with_their_heads_inwards(serif):
    line = lay_out(serif, "HIL", 2.0)
    made = around(line, circle(), side="bottom")
    left_to_right = sorted(outer(made), key=lambda ring: ring[:, 0].mean())
    straight_areas = [ring_area(outer(straight([lay_out(serif, letter, 2.0)]))[0]) for letter in "HIL"]
    assert [ring_area(ring) for ring in left_to_right] == pytest.approx(straight_areas, rel=1e-6)
    middle = left_to_right[1]
    assert middle[:, 1].max() == pytest.approx(-RADIUS, abs=0.03)
    assert middle[:, 1].min() == pytest.approx(-RADIUS - 2.0, abs=0.03)
    # the foot of L, at its right, is at the outside
    foot = turned(left_to_right[2], -np.degrees(np.arctan2(*(left_to_right[2].mean(axis=0) * (1, -1)))))
    assert np.ptp(foot[foot[:, 1] < -RADIUS - 1.7][:, 0]) > np.ptp(foot[foot[:, 1] > -RADIUS - 0.3][:, 0]) * 1.3


@pytest.mark.parametrize("side", ["top", "bottom"])
def test_letters_on_a_small_circle_do_not_touch(serif, side):
    line = lay_out(serif, "MMXXVIHHHH", 3.0)
    made = around(line, circle(8.0), side=side)
    assert len(outer(made)) == len(outer(straight([line]))) == 10


def test_direction_of_the_ring_does_not_matter(serif):
    line = lay_out(serif, "EITHER WAY", 2.0)
    for side in ("top", "bottom"):
        one, other = around(line, circle(), side=side), around(line, circle()[::-1], side=side)
        assert overlap(one, other) == pytest.approx(1.0, abs=1e-4)
        shifted = around(line, np.roll(circle(), 777, axis=0), side=side)
        assert overlap(one, shifted) == pytest.approx(1.0, abs=1e-4)


def test_text_on_an_edge_is_centred_at_the_top_of_any_outline(serif):
    lopsided = np.array([[0.0, 0.0], [40.0, 0.0], [40.0, 12.0], [30.0, 20.0], [0.0, 20.0]])
    low, high = around(lay_out(serif, "AHA", 2.0), lopsided).bounds_mm
    assert (low[0] + high[0]) / 2 == pytest.approx(20.0, abs=1e-6)
    assert (low[1], high[1]) == pytest.approx((20.0, 22.0), abs=0.01)
    curve, middle = curve_around(lopsided, "bottom")
    assert curve.at(np.asarray(middle)) == pytest.approx((20.0, 0.0))


def test_spread_letters_divide_the_circle_evenly(serif):
    assert np.diff(angles(middles(around(lay_out(serif, "HHHHHH", 2.0), circle(), "circle")))) == pytest.approx(60.0)
    with_kerning = lay_out(serif, "AVAVAV", 2.0)
    made = spread(with_kerning, *curve_around(circle()))
    assert len(outer(made)) == 6
    # letters and words: equal spaces between outlines of equal letters, one more space at each end of a word
    steps = np.diff(angles(middles(around(lay_out(serif, "HH HH HH", 2.0), circle(), "circle"))))
    assert steps == pytest.approx([steps[0], steps[1]] * 2 + [steps[0]])
    assert steps[0] + steps[1] == pytest.approx(120.0)
    assert steps[1] > steps[0]


def test_a_ring_repeats_a_whole_number_of_times_and_closes(serif):
    line = lay_out(serif, "HOH", 2.0)
    period = line.advance_mm + line.word_space_mm
    times = int(2 * np.pi * RADIUS / period)
    made = around(line, circle(), "ring")
    assert len(outer(made)) == 3 * times
    found = np.sort(np.degrees(np.arctan2(*middles(made).T)) % 360)
    assert found[::3][1:] - found[::3][:-1] == pytest.approx(360 / times, abs=0.02)
    turned_by_one = nm.Contours(tuple(turned(ring, 360 / times) for ring in made.rings))
    assert overlap(made, turned_by_one) == pytest.approx(1.0, abs=1e-3)
    # one of the texts is centred at the side
    for side, sign in (("top", 1), ("bottom", -1)):
        x, y = middles(around(line, circle(), "ring", side)).T
        assert abs(x[np.argmax(sign * y)]) < 0.01


def test_a_text_that_just_fits_is_repeated_once(serif):
    line = lay_out(serif, "HOHO", 2.0)
    curve, middle = curve_around(circle((line.advance_mm + line.word_space_mm) * 1.001 / (2 * np.pi)))
    assert len(repeated(line, curve, middle).rings) == len(straight([line]).rings)


def test_scripts_that_join_letters_are_bent_without_gaps():
    line = lay_out(nm.read_font("DejaVu Sans"), "بيتبيت", 3.0)
    for side in ("top", "bottom"):
        bent = around(line, circle(8.0), side=side)
        assert len(bent.rings) == len(straight([line]).rings)
    # on a straight curve, nothing is bent
    level = along(line, TextCurve(np.array([[-50.0, -1.5], [50.0, -1.5]])))
    assert overlap(straight([line]), level) == pytest.approx(1.0, abs=1e-6)


def test_open_curves_carry_text_at_a_place(serif):
    line = lay_out(serif, "HIH", 2.0)
    diagonal = TextCurve(np.array([[0.0, 0.0], [10.0, 10.0], [20.0, 20.0]]))
    assert diagonal.length_mm == pytest.approx(20 * np.sqrt(2))
    made = along(line, diagonal, 10.0, baseline_mm=-1.0)
    low, high = nm.Contours(tuple(turned(ring, -45.0) for ring in made.rings)).bounds_mm
    assert low + high == pytest.approx((20.0, 0.0), abs=1e-6)


@pytest.mark.parametrize(
    ("place", "message"),
    [
        (
            lambda line: along(line, TextCurve(np.array([[0.0, 0.0], [8.0, 0.0]]))),
            r"is 15\.4 mm long at 2mm, the edge has 8\.0 mm; use a smaller `text_size`, less `text_spacing` or a",
        ),
        (
            lambda line: along(line, TextCurve(np.array([[0.0, 0.0], [30.0, 0.0]])), 5.0),
            r"the text reaches 2\.7 mm beyond the end of its line of 30\.0 mm; use a smaller `text_size`",
        ),
        (lambda line: around(line, circle(2.0)), r"the text is 15\.4 mm long at 2mm, the edge has 12\.6 mm"),
        (lambda line: around(line, circle(2.4), "circle"), r"the text is 15\.5 mm long at 2mm, the edge has 15\.1 mm"),
        (lambda line: around(line, circle(2.6), "ring"), r"the text is 16\.4 mm long at 2mm, the edge has 16\.3 mm"),
        (
            lambda line: spread(line, TextCurve(np.array([[0.0, 0.0], [90.0, 0.0]])), 45.0),
            "the text goes around a closed curve; the curve is open",
        ),
        (lambda _: TextCurve(np.zeros((3, 2))), "a curve for text has 1 point; expected at least two"),
        (lambda _: TextCurve(np.array([[0.0, np.nan], [1.0, 1.0]])), r"must be finite points \(n, 2\); found \(2, 2\)"),
    ],
)
def test_text_that_does_not_fit_is_refused(serif, place, message):
    with pytest.raises(nm.InputError, match=message):
        place(lay_out(serif, "LEGENDA", 2.0))
