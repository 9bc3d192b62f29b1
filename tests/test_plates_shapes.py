"""Outlines of plates: areas of the true curves, corners on them, solids with their exact size and volume."""

from __future__ import annotations

import numpy as np
import pytest
from plate_cases import ball, design, made, solid, star
from solid_cases import check_solid

import nmaptool as nm
from nmaptool.plates import shapes
from nmaptool.plates.distance import Curves, inside_points
from nmaptool.plates.polygons import offset, refined, without_short_edges
from nmaptool.types.contours import ring_area

# an outline of length L with a tolerance t loses at most L * t of the area of the true curve
CURVES = {
    "disc": (shapes.disc(30.0, 0.2), np.pi * 15**2),
    "ellipse": (shapes.ellipse(40.0, 24.0, 0.2), np.pi * 20 * 12),
    "flat ellipse": (shapes.ellipse(8.0, 60.0, 0.3), np.pi * 4 * 30),
    "rounded": (shapes.rectangle(30.0, 20.0, 4.0, 0.2), 600 - (4 - np.pi) * 16),
    "tiny corner": (shapes.rectangle(30.0, 20.0, 0.01, 0.2), 600 - (4 - np.pi) * 1e-4),
    "stadium": (shapes.rectangle(30.0, 20.0, 10.0, 0.2), 200 + np.pi * 100),
}


@pytest.mark.parametrize("name", CURVES)
def test_round_outlines_have_the_area_of_their_curve_within_the_tolerance(name):
    found, area = CURVES[name]
    length = sum(Curves(found, 1.0).lengths_mm)
    assert 0 <= area - found.area_mm2 <= length * found.tolerance_mm
    assert 0 < found.tolerance_mm < 2e-3


def test_a_sharp_rectangle_is_exact():
    found = shapes.rectangle(30.0, 20.0, 0.0, 0.7)
    assert found.area_mm2 == pytest.approx(600, abs=1e-10)
    assert found.tolerance_mm == 0
    assert np.hypot(*(found.rings[0] - np.roll(found.rings[0], 1, axis=0)).T).max() <= 0.7 + 1e-12


def test_every_corner_lies_on_the_true_curve():
    (disc,) = CURVES["disc"][0].rings
    assert np.abs(np.hypot(*disc.T) - 15).max() < 1e-9
    (oval,) = CURVES["ellipse"][0].rings
    assert np.abs(np.hypot(oval[:, 0] / 20, oval[:, 1] / 12) - 1).max() < 1e-9
    (rounded,) = shapes.rectangle(30.0, 20.0, 4.0, 100.0).rings  # without corners on the straight sides
    away = np.hypot(*np.maximum(np.abs(rounded) - (11.0, 6.0), 0).T)
    assert np.abs(away - 4).max() < 1e-9


def test_the_stated_tolerance_is_the_greatest_distance_from_the_curve():
    for name in ("disc", "ellipse", "flat ellipse"):
        found, _ = CURVES[name]
        (ring,) = found.rings
        a, b = np.abs(ring).max(axis=0)
        middles = (ring + np.roll(ring, -1, axis=0)) / 2
        inside = 1 - np.hypot(middles[:, 0] / a, middles[:, 1] / b)
        slope = np.hypot(middles[:, 0] / a**2, middles[:, 1] / b**2)
        distance = inside / slope  # to first order
        assert found.tolerance_mm * 0.9 <= distance.max() <= found.tolerance_mm * 1.02, name


def test_corners_that_do_not_fit_are_refused():
    with pytest.raises(
        nm.InputError, match=r"`corner='11mm'`: the plate is 30 x 20 mm, so its corners .* 10 mm at most"
    ):
        shapes.rectangle(30.0, 20.0, 11.0, 0.2)
    with pytest.raises(nm.InputError, match=r"`corner='30mm'`: the plate is 40 x 20 mm.* 10 mm at most"):
        made(design("rect", aspect="2:1", corner="30mm"))


def test_a_drawn_shape_is_scaled_to_the_width():
    found = shapes.scaled_to(star(), 50.0, 0.3)
    low, high = found.bounds_mm
    assert (high - low)[0] == pytest.approx(50, abs=1e-9)
    assert np.allclose(low + high, 0, atol=1e-9)
    (width,) = np.diff(star().bounds_mm[:, 0])
    assert found.area_mm2 == pytest.approx(star().area_mm2 * (50 / width) ** 2, rel=1e-12)


def test_refined_rings_keep_their_shape():
    (ring,) = star().rings
    fine = refined(ring, 0.37)
    assert ring_area(fine) == pytest.approx(ring_area(ring), rel=1e-12)
    assert np.hypot(*(fine - np.roll(fine, 1, axis=0)).T).max() <= 0.37 + 1e-12
    assert all((np.hypot(*(fine - corner).T) < 1e-12).any() for corner in ring)


def test_offsets_are_at_their_distance():
    for by in (-2.0, -0.3, 0.7, 5.0):
        moved = offset(star(), by)
        distance = Curves(star(), 0.1).nearest(np.concatenate(moved.rings)).distance_mm
        # corners of round joins lie on the true arc
        assert np.abs(distance - abs(by)).max() < 1e-3, by
        assert inside_points(star(), np.concatenate(moved.rings)).all() == (by < 0)


@pytest.mark.parametrize("margin", [0.0, 1.5, 6.0])
def test_the_outline_of_a_motif_is_at_the_margin(margin):
    _, mask = ball(90, 70, 0.7)
    found = shapes.motif_outline(mask, 0.25, margin, 0.25)
    # the true curve: a circle of the mask's radius and the margin
    radius = 0.7 * 35 * 0.25 + margin
    away = np.hypot(*(found.rings[0] - (35 * 0.25, 45 * 0.25)).T)
    # within the pixels, whose steps are smoothed outwards
    assert away.min() > radius - 0.25
    assert away.max() < radius + 0.25


def test_the_outline_of_a_motif_in_several_parts_is_refused_unless_the_margin_joins_them():
    mask = np.zeros((40, 60), bool)
    mask[10:30, 5:20] = mask[10:30, 40:55] = True
    with pytest.raises(nm.InputError, match="`shape='mask'`: the motif has 2 separate parts at a margin of 2 mm"):
        shapes.motif_outline(mask, 0.5, 2.0, 0.5)
    found = shapes.motif_outline(mask, 0.5, 6.0, 0.5)
    assert len(found.rings) == 1


def test_holes_and_single_pixels_of_a_motif_make_no_trouble():
    _, mask = ball()
    mask[30:34, 30:34] = False
    assert len(shapes.motif_outline(mask, 0.25, 0.0, 0.25).rings) == 1
    one = np.zeros((9, 9), bool)
    one[4, 4] = True
    assert shapes.motif_outline(one, 1.0, 3.0, 0.2).area_mm2 == pytest.approx(1 + 4 * 3 + np.pi * 9, rel=0.02)


PLATES = {"round": "1:1", "oval": "4:3", "rect": "4:3"}


@pytest.mark.parametrize("shape", [*PLATES, "star.svg", "mask"])
def test_a_flat_plate_has_the_volume_of_its_area_and_a_solid_its_exact_size(shape):
    flat = np.dstack([np.zeros((40, 40)), np.zeros((40, 40)), np.ones((40, 40))])
    _, mask = ball(40, 40)
    more = {"aspect": "4:3"} if shape in ("oval", "rect") else {}
    relief = made(design(shape, **more), (flat, mask), height=None, delta=0.0)
    found = solid(relief)
    check_solid(found)
    assert found.volume_mm3 == pytest.approx(2 * relief.height.outline.area_mm2, rel=1e-9)
    assert relief.plate.area_mm2 == pytest.approx(relief.height.outline.area_mm2)
    assert found.size_mm[0] == pytest.approx(40, abs=1e-9)
    assert found.size_mm[2] == pytest.approx(2, abs=1e-9)


@pytest.mark.parametrize("shape", [*PLATES, "star.svg", "mask"])
def test_the_solid_of_a_plate_has_the_height_of_the_motif(shape):
    relief = made(design(shape, margin="2mm"))
    found = solid(relief)
    check_solid(found)
    assert relief.height.range_mm[1] == pytest.approx(1, abs=1e-9)
    assert found.size_mm[2] == pytest.approx(3, abs=1e-6)


def test_areas_of_round_and_oval_plates():
    assert made(design("round")).plate.area_mm2 == pytest.approx(np.pi * 20**2, rel=5e-4)
    assert made(design("oval", aspect="4:3")).plate.area_mm2 == pytest.approx(np.pi * 20 * 15, rel=5e-4)
    relief = made(design("rect", aspect="4:3", corner="3mm"))
    assert relief.plate.area_mm2 == pytest.approx(1200 - (4 - np.pi) * 9, rel=5e-4)
    length = 2 * (40 + 30)
    assert abs(relief.plate.area_mm2 - (1200 - (4 - np.pi) * 9)) <= length * relief.plate.outline_tolerance_mm


def test_corners_close_together_are_left_out():
    square = np.array([[0.0, 0], [1, 0], [1, 1e-6], [1, 2e-6], [1, 1], [0, 1], [0, 1e-7]])
    assert without_short_edges(square, 1e-3).tolist() == [[0, 0], [1, 0], [1, 1], [0, 1]]
    (ring,) = star().rings
    assert without_short_edges(ring, 1e-3) is ring


def test_no_edge_of_a_plate_is_a_needle():
    relief = made(design("mask", loop="4mm", margin="6%", frame="4%", hole="2mm@50%,50%", pitch="0.3mm"))
    for ring in relief.height.outline.rings:
        assert np.hypot(*(ring - np.roll(ring, 1, axis=0)).T).min() >= 1e-3 * relief.pitch_mm
