"""Layout: the plate has exactly its width, the motif touches its field, % of the longer side, symmetry."""

from __future__ import annotations

import numpy as np
import pytest
from plate_cases import ball, blob, corners_mm, depth_of, design, made, solid
from solid_cases import check_solid

import nmaptool as nm
from nmaptool.lettering.rings import united
from nmaptool.plates.fitting import Drawn, drawn_scale, ellipse_for, enclosing_circle
from nmaptool.plates.layout import lay_out
from nmaptool.plates.polygons import circle
from nmaptool.types.contours import Contours


def laid_out(mask, wanted, width=40.0, pitch=None):
    return lay_out(mask, wanted, pitch_mm=pitch, width_mm=width)


@pytest.mark.parametrize("margin", ["0.001mm", "2mm", "6%", "3px"])
@pytest.mark.parametrize("frame", [None, "3mm", "5%"])
def test_a_round_plate_touches_the_motif_at_frame_and_margin(frame, margin):
    mask = blob()
    layout = laid_out(mask, design("round", frame=frame, margin=margin))
    assert layout.width_mm == 40
    assert layout.height_mm == pytest.approx(40, rel=1e-12)
    units = {"0.001mm": 0.001, "2mm": 2, "6%": 2.4, "3px": 3 * layout.pitch_mm, None: 0, "3mm": 3, "5%": 2}
    radius = np.hypot(*corners_mm(mask, layout).T).max()
    assert radius == pytest.approx(20 - units[frame] - units[margin], abs=1e-4)


def test_a_rect_plate_touches_the_motif_on_all_sides_or_two_with_an_aspect():
    mask = blob()
    layout = laid_out(mask, design("rect", frame="2mm", margin="1mm"))
    points = corners_mm(mask, layout)
    assert points.max(axis=0) == pytest.approx((17, layout.height_mm / 2 - 3), abs=1e-8)
    assert points.min(axis=0) == pytest.approx((-17, 3 - layout.height_mm / 2), abs=1e-8)
    layout = laid_out(mask, design("rect", frame="2mm", margin="1mm", aspect="2:1"))
    assert layout.height_mm == pytest.approx(20, abs=1e-9)
    assert corners_mm(mask, layout)[:, 1].max() == pytest.approx(7, abs=1e-8)


def test_an_oval_plate_touches_the_motif():
    mask = blob()
    layout = laid_out(mask, design("oval", frame="2mm", margin="1mm", aspect="3:4"))
    assert layout.height_mm == pytest.approx(40 * 4 / 3, abs=1e-6)
    points = corners_mm(mask, layout)
    across, down = 20 - 3, layout.height_mm / 2 - 3
    assert np.hypot(points[:, 0] / across, points[:, 1] / down).max() == pytest.approx(1, abs=1e-6)
    layout = laid_out(mask, design("oval", frame="2mm", margin="1mm"))
    points = corners_mm(mask, layout)
    across, down = layout.width_mm / 2 - 3, layout.height_mm / 2 - 3
    assert np.hypot(points[:, 0] / across, points[:, 1] / down).max() == pytest.approx(1, abs=1e-6)
    size = np.ptp(points, axis=0)
    assert across / down == pytest.approx(size[0] / size[1], rel=1e-6)


@pytest.mark.parametrize("shape", ["round", "oval", "rect", "mask", "star.svg"])
def test_without_a_width_the_motif_keeps_its_size_and_the_plate_grows(shape):
    mask = blob()
    wanted = design(shape, frame="3mm", margin="5%")
    grown = laid_out(mask, wanted, None, 0.5)
    assert grown.pitch_mm == 0.5
    # the other way round is the same
    fitted = laid_out(mask, wanted, grown.width_mm)
    assert fitted.pitch_mm == pytest.approx(0.5, rel=1e-5)
    assert fitted.height_mm == pytest.approx(grown.height_mm, rel=1e-6)
    assert fitted.middle_mm == pytest.approx(grown.middle_mm, abs=1e-3)


def test_a_drawn_plate_touches_the_motif():
    mask = blob()
    wanted = design("star.svg", frame="1mm", margin="0.5mm")
    layout = laid_out(mask, wanted)
    found = made(wanted, (np.dstack([0.0 * mask, 0.0 * mask, np.ones(mask.shape)]), mask), delta=60.0)
    outline = found.height.outline
    low, high = outline.bounds_mm
    from nmaptool.plates.distance import Curves, inside_points

    points = corners_mm(mask, layout) + (low + high) / 2
    away = Curves(outline, 0.1).nearest(points).distance_mm
    assert inside_points(outline, points).all()
    # the hull of the motif touches the field; its corners nearly do
    assert 1.5 - 1e-3 <= away.min() < 2.5


def test_polygons_in_drawn_shapes_touch_them():
    square = np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1]])
    box = Drawn(Contours((np.array([[0.0, 0], [10, 0], [10, 6], [0, 6]]),)))
    assert drawn_scale(box, square, 0.0) == pytest.approx(3, rel=1e-6)
    assert drawn_scale(box, square, 1.0) == pytest.approx(2, rel=1e-6)
    assert drawn_scale(box, square, 3.1) == 0.0
    diamond = np.array([[-1.0, 0], [0, -1], [1, 0], [0, 1]])
    assert drawn_scale(box, diamond, 0.0) == pytest.approx(3, rel=1e-6)
    # an L: the largest circle lies in its corner
    ell = Drawn(Contours((np.array([[0.0, 0], [10, 0], [10, 4], [4, 4], [4, 10], [0, 10]]),)))
    _, middle = ell.field(0.0)
    radius = 8 - 4 * np.sqrt(2)  # touches two sides and the inner corner: r = (4 - r) sqrt(2)
    assert radius == pytest.approx((4 - radius) * np.sqrt(2))
    assert middle + 5 == pytest.approx((radius, radius), abs=0.02)


def test_the_middle_of_a_long_shape_is_its_middle():
    for turn in (0.0, 0.4, 1.2):
        rotation = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        bar = Drawn(Contours((np.array([[0.0, 0], [10, 0], [10, 3], [0, 3]]) @ rotation,)))
        _, middle = bar.field(0.2)
        assert np.hypot(*middle) < 0.25, turn
    # two equal lobes: one of them, not the neck between them
    lobes = [circle(x, 0.0, 3.0, 0.1) for x in (-4.0, 4.0)]
    both = united([*lobes, np.array([[-4.0, -0.5], [4, -0.5], [4, 0.5], [-4, 0.5]])])
    _, middle = Drawn(both).field(0.0)
    assert np.abs(middle) == pytest.approx((4, 0), abs=0.15)


def test_circles_and_ellipses_hold_their_points():
    points = np.random.default_rng(0).normal(size=(50, 2))
    middle, radius = enclosing_circle(points)
    away = np.hypot(*(points - middle).T)
    assert away.max() <= radius * (1 + 1e-9)
    assert np.sort(away)[-2] == pytest.approx(radius, rel=1e-4)
    width, height = ellipse_for(points, 0.5, 1.5, 1.0)
    assert width == pytest.approx(1.5 * height)
    inside = np.hypot(points[:, 0] / (width / 2 - 0.5), points[:, 1] / (height / 2 - 0.5))
    assert inside.max() == pytest.approx(1, abs=1e-9)


@pytest.mark.parametrize("shape", ["round", "oval", "rect", "star.svg", "mask"])
def test_plates_are_exactly_as_wide_as_asked_for(shape):
    relief = made(design(shape, frame="2mm"), width="37.5mm")
    low, high = relief.height.outline.bounds_mm
    assert (high - low)[0] == pytest.approx(37.5, abs=1e-9)
    assert relief.plate.width_mm == pytest.approx(37.5, abs=1e-9)
    assert solid(relief).size_mm[0] == pytest.approx(37.5, abs=1e-9)


def test_a_picture_that_covers_the_plate_is_cropped_to_it():
    normals, _ = ball(60, 90, 2.0)
    for fill, motif in (
        ("cover", (normals, None)),
        ("auto", (normals, None)),
        ("auto", (normals, normals[..., 2] > 0)),
    ):
        relief = made(design("round", fill=fill), motif, background="free")
        assert relief.plate.fill == "cover"
        assert relief.plate.margin_mm == 0
        assert relief.pitch_mm == pytest.approx(40 / 60)
        assert relief.height.range_mm[0] >= -1e-9
        check_solid(solid(relief))
    inside = made(design("round", fill="inside"), (normals, None))
    assert inside.plate.fill == "inside"
    assert inside.pitch_mm < 0.4


def test_covering_a_plate_in_the_outline_of_the_motif_is_refused():
    with pytest.raises(nm.UsageError, match="`fill='cover'`: is not for `shape='mask'`, whose edge follows the motif"):
        made(design("mask", fill="cover"))
    full = np.ones((40, 40), bool)
    relief = made(design("mask", margin="2mm"), (ball(40, 40)[0], full))
    assert relief.plate.fill == "inside"
    assert relief.plate.area_mm2 == pytest.approx((relief.plate.width_mm) ** 2 - (4 - np.pi) * 4, rel=1e-3)


def test_heights_are_exact_also_engraved():
    for more in ({}, {"engrave": True}, {"frame": "3mm", "frame_height": "0.5mm"}):
        relief = made(design("round", **more), height="1.7mm", delta=10.0)
        sign = -1 if "engrave" in more else 1
        inside = depth_of(relief, relief.height.outline) > 5
        assert (sign * relief.z_mm[inside]).max() == pytest.approx(1.7, abs=1e-9)
    raised, sunk = (made(design("round", engrave=engrave)) for engrave in (False, True))
    assert sunk.z_mm == pytest.approx(-raised.z_mm, abs=1e-12)
    assert sunk.plate.lowest_mm == pytest.approx(-1, abs=1e-9)


def mirrored(normals):
    out = normals[:, ::-1].copy()
    out[..., 0] *= -1
    return out


def turned(normals):
    """A map rotated by 90 degrees counter-clockwise."""
    out = np.rot90(normals).copy()
    return np.dstack([-out[..., 1], out[..., 0], out[..., 2]])


@pytest.mark.parametrize("shape", ["round", "oval", "rect", "mask"])
def test_a_mirrored_or_turned_map_gives_the_mirrored_or_turned_plate(shape):
    rng = np.random.default_rng(3)
    mask = blob()
    normals = np.dstack([*rng.normal(0, 0.3, (2, *mask.shape)), np.ones(mask.shape)])
    wanted = design(shape, frame="20mm", frame_profile="round", margin="2mm")
    sizes = {"width": None, "tolerance": 1e-12}
    plain = made(wanted, (normals, mask), **sizes)
    area = plain.height.outline.area_mm2
    for other, change in (
        (made(wanted, (mirrored(normals), mask[:, ::-1]), **sizes), lambda z: z[:, ::-1]),
        (made(wanted, (turned(normals), np.rot90(mask)), **sizes), np.rot90),
    ):
        assert other.height.outline.area_mm2 == pytest.approx(area, rel=1e-4)
        expected, found = change(plain.z_mm), other.z_mm
        inside = (change(depth_of(plain, plain.height.outline)) > 0) & True
        # the boards may differ by a pixel at the edges
        if expected.shape == found.shape:
            assert np.abs(expected - found)[inside].max() < (5e-2 if shape == "mask" else 2e-4)
        assert np.sort(found.ravel())[-500:] == pytest.approx(np.sort(expected.ravel())[-500:], abs=1e-2)


def test_a_motif_that_is_empty_is_refused():
    normals, _ = ball()
    with pytest.raises(nm.InputError, match="the motif is empty; give a `mask`"):
        made(design("round"), (normals, np.zeros((64, 64), bool)))


def test_shapes_without_their_files_are_refused():
    with pytest.raises(nm.UsageError, match="a plate needs a shape, such as `shape='round'`"):
        made(design(None))
    with pytest.raises(nm.UsageError, match=r"`shape='x.svg'`: the design lacks the outline of the file"):
        made(design("x.svg"))
    with pytest.raises(nm.UsageError, match=r"`frame_profile='x.svg'`: the design lacks the profile of the file"):
        made(design("round", frame="2mm", frame_profile="x.svg"))
    with pytest.raises(nm.UsageError, match="`background='cut'`: leaves no plate"):
        made(design("round"), background="cut")


def test_tiny_and_large_plates():
    normals, mask = ball(8, 8)
    for width in ("1mm", "40mm", "5m"):
        relief = made(design("round"), (normals, mask), width=width)
        check_solid(solid(relief))
        assert relief.plate.width_mm == pytest.approx(nm.length(width).to_mm(1, 1))
    tall = made(design("rect", aspect="1:5"))
    assert tall.plate.height_mm == pytest.approx(200)
    assert tall.plate.margin_mm == pytest.approx(8)  # 4% of the longer side
    wide = made(design("rect", aspect="5:1"))
    assert wide.plate.height_mm == pytest.approx(8)
    assert wide.plate.margin_mm == pytest.approx(1.6)


def test_a_motif_at_the_border_of_its_picture():
    normals, _ = ball(40, 40)
    mask = np.zeros((40, 40), bool)
    mask[:25, :30] = True
    for shape in ("round", "rect", "mask", "star.svg"):
        relief = made(design(shape, frame="1mm"), (normals, mask))
        check_solid(solid(relief))
        assert relief.height.range_mm[1] == pytest.approx(1, abs=1e-9)


def test_a_motif_with_walls_on_a_plate_without_margin():
    for shape in ("round", "mask"):
        relief = made(design(shape, margin="0.001mm", frame="1mm"), edge="wall")
        assert relief.height.raised is not None
        check_solid(solid(relief))
