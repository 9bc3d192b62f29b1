"""Holes with their rims, and the loop of a pendant."""

from __future__ import annotations

import numpy as np
import pytest
from plate_cases import design, genus, made, solid
from solid_cases import check_solid

import nmaptool as nm
from nmaptool.plates.distance import inside_points
from nmaptool.types.contours import ring_area

SHAPES = ("round", "oval", "rect", "mask", "star.svg")


def holes(relief):
    """Clockwise rings of the outline."""
    return [ring for ring in relief.height.outline.rings if ring_area(ring) < 0]


def vertices(relief, hole):
    """Distance of the vertices from the middle of a hole."""
    rows, cols = relief.height.frame.shape
    pitch = relief.pitch_mm
    x, y = np.meshgrid(np.arange(cols + 1) * pitch, (rows - np.arange(rows + 1)) * pitch)
    middle = (hole.min(axis=0) + hole.max(axis=0)) / 2
    return np.hypot(x - middle[0], y - middle[1])


@pytest.mark.parametrize("shape", ["round", "oval", "rect"])
def test_a_hole_has_its_diameter_and_place(shape):
    relief = made(design(shape, hole="4mm@50%,6mm", frame="1mm"))
    (hole,) = holes(relief)
    low, high = relief.height.outline.bounds_mm
    assert hole.max(axis=0) - hole.min(axis=0) == pytest.approx((4, 4), abs=1e-9)
    middle = (hole.min(axis=0) + hole.max(axis=0)) / 2
    assert middle - (low[0], high[1]) == pytest.approx((20, -6), abs=1e-9)
    assert 0 <= np.pi * 4 + ring_area(hole) <= 2 * np.pi * 2 * relief.plate.outline_tolerance_mm
    assert relief.plate.area_mm2 == pytest.approx(relief.height.outline.area_mm2)
    found = solid(relief)
    check_solid(found)
    assert genus(found) == 1


def test_several_holes_make_several_handles():
    relief = made(
        design("rect", aspect="4:3", hole="3mm@10%,10%; 3mm@90%,10%; 3mm@10%,90%; 3mm@90%,90%", pitch="0.2mm")
    )
    assert len(holes(relief)) == 4
    found = solid(relief)
    check_solid(found)
    assert genus(found) == 4
    assert len(relief.plate.holes) == 4
    assert genus(solid(made(design("rect")))) == 0


def test_the_rim_of_a_hole_is_half_round():
    relief = made(design("rect", aspect="1:2", hole="4mm@50%,6mm", hole_rim="2mm", pitch="0.05mm"))
    (hole,) = holes(relief)
    away = vertices(relief, hole) - 2
    rim = (away > 0.2) & (away < 1.8)
    # half as high as wide
    assert relief.z_mm[rim] == pytest.approx(np.sqrt(1 - (away[rim] - 1) ** 2), abs=0.02)
    assert (relief.z_mm[(away > 2.1) & (away < 2.5)] == 0).all()
    facts = {"diameter_mm": 4.0, "across_mm": 20.0, "down_mm": 6.0, "rim_mm": 2.0}
    (found,) = relief.plate.holes
    assert found == {"loop": False} | {name: pytest.approx(value) for name, value in facts.items()}


def test_a_rim_is_a_fifth_of_its_hole_unless_it_is_given():
    assert made(design("round", hole="4mm@50%,6mm")).plate.holes[0]["rim_mm"] == pytest.approx(0.8)
    relief = made(design("rect", aspect="1:2", hole="4mm@50%,6mm", hole_rim="0mm"))
    assert relief.plate.holes[0]["rim_mm"] == 0
    away = vertices(relief, holes(relief)[0])
    assert (relief.z_mm[away < 3] == 0).all()


def test_a_rim_that_reaches_beyond_the_edge_ends_there():
    relief = made(design("round", hole="3mm@50%,2mm", hole_rim="2mm"))
    check_solid(solid(relief))
    assert genus(solid(relief)) == 1


@pytest.mark.parametrize("shape", SHAPES)
def test_a_loop_is_part_of_the_plate_with_one_hole(shape):
    plain = made(design(shape, frame="1mm", margin="2mm", pitch="0.2mm"))
    relief = made(design(shape, frame="1mm", margin="2mm", loop="4mm", pitch="0.2mm"))
    (eye,) = holes(relief)
    outer = [ring for ring in relief.height.outline.rings if ring_area(ring) > 0]
    assert len(outer) == 1
    assert 0 <= np.pi * 4 + ring_area(eye) <= 2 * np.pi * 2 * relief.plate.outline_tolerance_mm
    # the eye lies wholly above the plate over whose middle it stands
    top = plain.height.outline.bounds_mm[1, 1] - plain.height.outline.bounds_mm[0, 1]
    low = relief.height.outline.bounds_mm[0, 1]
    middle = float(np.mean([eye[:, 0].min(), eye[:, 0].max()]))
    ring = outer[0]
    assert middle == pytest.approx(np.mean([ring[:, 0].min(), ring[:, 0].max()]), abs=0.05 if shape == "mask" else 1e-8)
    if shape not in ("mask", "star.svg"):
        assert eye[:, 1].min() - low > top
    # and the ring around it is as thick as stated everywhere
    thick = relief.plate.holes[0]["rim_mm"]
    angle = np.linspace(0, 2 * np.pi, 100)
    around = np.column_stack([np.cos(angle), np.sin(angle)]) * (2 + 0.99 * thick) + [middle, eye[:, 1].mean()]
    assert inside_points(relief.height.outline, around).all()
    found = solid(relief)
    check_solid(found)
    assert genus(found) == 1
    assert len(found.bodies) == 1
    (facts,) = relief.plate.holes
    assert facts["loop"]
    assert facts["diameter_mm"] == pytest.approx(4)
    assert facts["down_mm"] < -2
    assert relief.plate.width_mm == pytest.approx(plain.plate.width_mm)
    assert relief.plate.height_mm == pytest.approx(plain.plate.height_mm)  # without the loop


@pytest.mark.parametrize("shape", SHAPES)
def test_a_loop_blends_into_the_plate_without_cliffs(shape):
    wanted = design(shape, frame="1.5mm", frame_height="1mm", margin="2mm", loop="4mm", draft=45.0, pitch="0.1mm")
    relief = made(wanted)
    z, pitch = relief.z_mm, relief.pitch_mm
    away = vertices(relief, holes(relief)[0])
    near = (away < 2 + 3 * 1.6) & (away > 2.3)
    inside = inside_points(relief.height.outline, _points(relief)).reshape(z.shape) & near
    from scipy import ndimage

    inside = ndimage.binary_erosion(inside, np.ones((3, 3)), iterations=2)
    steps = np.maximum(np.abs(z - np.roll(z, 1, axis=0)), np.abs(z - np.roll(z, 1, axis=1)))
    # the half round of the loop is steep at its sides; nothing else is steeper than it
    assert steps[inside].max() < 4.5 * pitch


def _points(relief):
    rows, cols = relief.height.frame.shape
    pitch = relief.pitch_mm
    x, y = np.meshgrid(np.arange(cols + 1) * pitch, (rows - np.arange(rows + 1)) * pitch)
    return np.column_stack([x.ravel(), y.ravel()])


def test_a_loop_and_a_hole_together():
    relief = made(design("round", loop="3mm", hole="2mm@50%,90%", pitch="0.2mm"))
    found = solid(relief)
    check_solid(found)
    assert genus(found) == 2
    assert [hole["loop"] for hole in relief.plate.holes] == [False, True]


def test_holes_outside_the_plate_or_too_near_its_edge_are_refused():
    with pytest.raises(
        nm.InputError,
        match=r"`hole='4mm@50%,-3mm'`: the hole of 4 mm has its middle 3 mm outside the plate of 40 x 40 mm; it must "
        r"lie 2.2 mm inside, so move it inwards or make it smaller",
    ):
        made(design("round", hole="4mm@50%,-3mm"))
    with pytest.raises(nm.InputError, match=r"middle \S+ mm from the edge of the plate of 40 x 40 mm; it must lie 2.2"):
        made(design("round", hole="4mm@50%,1mm"))
    with pytest.raises(nm.InputError, match=r"two holes are 3 mm apart, and need 4.2 mm; move them apart"):
        made(design("round", hole="4mm@50%,6mm; 4mm@50%,9mm"))


def test_a_loop_larger_than_the_plate_is_still_one_piece():
    relief = made(design("round", loop="30mm", pitch="0.3mm"))
    check_solid(solid(relief))
    assert genus(solid(relief)) == 1


def test_rims_leave_what_lies_below_the_plate_beside_them():
    text = {"text": "ANNO", "text_at": "50%,88%", "text_size": "3mm", "text_height": "0.4mm", "text_sunk": True}
    sunk = made(design("round", (text,), loop="3mm", margin="9mm"))
    assert sunk.plate.lowest_mm == pytest.approx(-0.4, abs=1e-9)
    engraved = made(design("round", hole="2mm@50%,50%", engrave=True))
    assert engraved.plate.lowest_mm < -0.9
    assert engraved.plate.top_mm == pytest.approx(0.2, rel=0.06)  # of the rim
    check_solid(solid(engraved))
