"""Frames: the heights of each profile at known depths, patterns that repeat, exact heights."""

from __future__ import annotations

import numpy as np
import pytest
from plate_cases import ball, depth_of, design, made, solid, star
from scipy import ndimage
from solid_cases import check_solid

import nmaptool as nm
from nmaptool.plates import shapes
from nmaptool.plates.board import Board
from nmaptool.plates.frame import frame_heights, slope_width
from nmaptool.plates.ground import FrameSize
from nmaptool.plates.patterns import bead_centres
from nmaptool.plates.profiles import averaged, slope

WIDTH, HEIGHT, PITCH = 4.0, 1.5, 0.1
OUTLINES = {
    "round": shapes.disc(40.0, PITCH),
    "oval": shapes.ellipse(40.0, 30.0, PITCH),
    "rect": shapes.rectangle(40.0, 30.0, 0.0, PITCH),
    "star.svg": shapes.scaled_to(star(), 50.0, PITCH),
}


def framed(shape, profile, drawn=None, draft=12.0):
    """Heights of a frame on a grid, what shows beside it, and the depth of each vertex."""
    board = Board.around(OUTLINES[shape], PITCH)
    outline = board.placed(OUTLINES[shape])
    size = FrameSize(WIDTH, HEIGHT, slope_width(HEIGHT, draft, PITCH))
    wanted = design(shape, frame=f"{WIDTH}mm", frame_profile=profile, profile=drawn)
    z, shows = frame_heights(board, outline, wanted, size)
    return z, shows, board.field(outline, np.inf).depth_mm(), board


@pytest.mark.parametrize("shape", OUTLINES)
def test_a_flat_frame_is_level_up_to_its_slope(shape):
    z, shows, depth, _ = framed(shape, "flat")
    ramp = slope_width(HEIGHT, 12.0, PITCH)
    assert z[(depth >= 0) & (depth <= WIDTH - ramp - PITCH)] == pytest.approx(HEIGHT, abs=1e-9)
    middle = np.abs(depth - (WIDTH - ramp / 2)) < ramp / 2 - PITCH
    assert z[middle] == pytest.approx((WIDTH - depth[middle]) / ramp * HEIGHT, abs=1e-3)
    assert (z[depth > WIDTH + 1.1 * PITCH] == 0).all()
    assert (shows[depth < WIDTH - ramp - 1.1 * PITCH] == 0).all()
    assert shows[depth > WIDTH + 1.1 * PITCH] == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize("draft", [0.0, 12.0, 45.0])
def test_the_slope_of_a_flat_frame_has_its_draft(draft):
    z, _, depth, _ = framed("rect", "flat", draft=draft)
    near = depth[150:170, 10:60][0], z[150:170, 10:60][0]
    steepest = np.abs(np.diff(near[1]) / np.diff(near[0])).max()
    expected = HEIGHT / max(HEIGHT * np.tan(np.radians(draft)), 1.5 * PITCH)
    # the least slope, one and a half pixels, is shorter than the two that are averaged
    assert steepest == pytest.approx(expected * (0.6875 if draft == 0 else 1), rel=1e-2)


@pytest.mark.parametrize("shape", OUTLINES)
def test_a_round_frame_is_half_an_ellipse(shape):
    z, _, depth, _ = framed(shape, "round")
    share = 2 * depth / WIDTH - 1
    inside = np.abs(share) < 0.9
    assert z[inside] == pytest.approx(np.sqrt(1 - share[inside] ** 2) * HEIGHT, abs=0.01 * HEIGHT)
    assert z.max() == pytest.approx(HEIGHT, rel=5e-3)


@pytest.mark.parametrize("shape", OUTLINES)
def test_a_bevel_rises_evenly_from_the_inside_to_the_edge(shape):
    z, _, depth, _ = framed(shape, "bevel")
    middle = (depth > 0.15 * WIDTH + PITCH) & (depth < WIDTH - PITCH)
    assert z[middle] == pytest.approx((WIDTH - depth[middle]) / (0.85 * WIDTH) * HEIGHT, abs=1e-9)
    assert z[(depth >= 0) & (depth < 0.15 * WIDTH - PITCH)] == pytest.approx(HEIGHT, abs=1e-9)


def test_a_drawn_profile_is_followed():
    drawn = np.array([[0.0, 0.4], [0.3, 1.0], [0.5, 1.0], [0.5, 0.5], [1.0, 0.0]])
    z, _, depth, _ = framed("rect", "ogee.svg", drawn)
    for low, high in ((0.05, 0.27), (0.33, 0.46), (0.54, 0.96)):
        part = (depth > low * WIDTH) & (depth < high * WIDTH)
        expected = np.interp(depth[part] / WIDTH, drawn[:, 0], drawn[:, 1]) * HEIGHT
        assert z[part] == pytest.approx(expected, abs=1e-9)
    assert z.max() == pytest.approx(HEIGHT, abs=1e-9)


def test_corners_of_a_rectangle_are_mitred():
    for profile in ("flat", "round", "bevel"):
        z, _, depth, board = framed("rect", profile)
        inside = depth > 0
        # the frame of a rectangle is that of the nearer side: the same at the same distance from any side
        x, y = np.meshgrid(board.x_mm, board.y_mm)
        left, right = board.x_mm[board.left] - 20, board.x_mm[board.left] + 20
        low, high = board.bottom * PITCH - 15, board.bottom * PITCH + 15
        nearest = np.minimum(np.minimum(x - left, right - x), np.minimum(y - low, high - y))
        assert nearest[inside] == pytest.approx(depth[inside], abs=1e-9)
        corner = inside & (depth < WIDTH)
        assert z[corner] == pytest.approx(np.interp(depth[corner], depth[150, :60], z[150, :60]), abs=1e-6), profile


def crests(z, depth, at, low):
    """Number of separate parts at a depth that are higher than ``low``."""
    near = (np.abs(depth - at) < 0.12 * WIDTH) & (z > low * HEIGHT)
    return ndimage.label(near, np.ones((3, 3)))[1]


@pytest.mark.parametrize("profile", ["rope", "bead"])
def test_patterns_of_a_round_frame_repeat_a_whole_number_of_times(profile):
    z, _, _, board = framed("round", profile)
    middle = (0.54 if profile == "rope" else 0.6) * WIDTH
    angle = np.linspace(0, 2 * np.pi, 7201)[:-1]
    x = (20 - middle) * np.cos(angle) + board.left * PITCH
    y = (20 - middle) * np.sin(angle) + board.bottom * PITCH
    around = ndimage.map_coordinates(z, [board.rows - y / PITCH, x / PITCH], order=1)
    power = np.abs(np.fft.rfft(around - around.mean()))
    count = int(power.argmax())
    length = 2 * np.pi * (20 - middle)
    spacing = 0.62 * 0.92 * WIDTH if profile == "rope" else 0.94 * 0.8 * WIDTH * 1.02
    expected = round(length / spacing) if profile == "rope" else int(length / spacing)
    assert count == expected
    # all its power is in multiples of the count: each part is like the others, also where the ring begins
    others = np.delete(power, np.arange(0, len(power), count))
    assert others.max() < 0.05 * power[count]
    assert around.max() == pytest.approx(HEIGHT, rel=2e-2)


@pytest.mark.parametrize("profile", ["rope", "bead"])
@pytest.mark.parametrize("shape", OUTLINES)
def test_patterns_reach_the_full_height_and_no_more(shape, profile):
    z, _, depth, _ = framed(shape, profile)
    assert z.max() == HEIGHT  # the rim along the edge
    assert z[(depth > 0) & (depth < 0.08 * WIDTH)] == pytest.approx(HEIGHT, abs=1e-9)
    assert z[depth > 0.3 * WIDTH].max() == pytest.approx(HEIGHT, rel=1e-2)
    assert z.min() == 0
    if shape != "star.svg":  # in whose tips they lie farther inside; a rope does so a little where it turns a corner
        assert (z[depth > WIDTH * (1.1 if profile == "rope" else 1) + PITCH] == 0).all()


def test_beads_lie_in_the_corners_at_equal_distances():
    line = shapes.rectangle(30.0, 20.0, 0.0, 0.1)
    centres = bead_centres(line, 1.9)
    for corner in ((15, 10), (-15, 10), (-15, -10), (15, -10)):
        assert np.hypot(*(centres - corner).T).min() < 1e-9
    assert len(centres) == 2 * (int(30 / 1.9) + int(20 / 1.9))
    apart = np.hypot(*(centres[:, None] - centres[None]).transpose(2, 0, 1)) + np.eye(len(centres)) * 99
    assert apart.min() >= 1.9


def test_beads_in_sharp_corners_do_not_overlap():
    centres = bead_centres(OUTLINES["star.svg"], 2.0)
    apart = np.hypot(*(centres[:, None] - centres[None]).transpose(2, 0, 1)) + np.eye(len(centres)) * 99
    assert apart.min() >= 0.98 * 2.0
    tips = star().rings[0][::2] * 50 / np.ptp(star().rings[0][:, 0])
    tips = tips - (np.array([0, tips[:, 1].max() + tips[:, 1].min()]) / 2)
    assert all(np.hypot(*(centres - tip).T).min() < 1.0 for tip in tips)


def test_strands_have_no_cut_where_the_line_begins():
    z, _, _, board = framed("round", "rope")
    # turned by one strand, the rope is the same
    count = round(2 * np.pi * (20 - 0.54 * WIDTH) / (0.62 * 0.92 * WIDTH))
    x, y = np.meshgrid(board.x_mm - board.left * PITCH, board.y_mm - board.bottom * PITCH)
    turn = 2 * np.pi / count
    xt, yt = np.cos(turn) * x - np.sin(turn) * y, np.sin(turn) * x + np.cos(turn) * y
    turned = ndimage.map_coordinates(z, [board.rows - yt / PITCH - board.bottom, xt / PITCH + board.left], order=1)
    inside = np.hypot(x, y) < 19.5
    assert np.abs(turned - z)[inside].max() < 0.2 * HEIGHT
    assert np.abs(turned - z)[inside].mean() < 0.01 * HEIGHT


def test_slopes_are_exact_away_from_their_edges():
    depth = np.linspace(-3, 3, 601)
    found = slope(depth, 2.0, 0.1)
    assert found[depth <= -1.1].max() == 0
    assert found[depth >= 1.1].min() == 1
    middle = np.abs(depth) < 0.9
    assert found[middle] == pytest.approx((depth[middle] + 1) / 2, abs=1e-12)
    assert (np.diff(found) >= 0).all()


def test_averages_keep_the_integral():
    depth = np.linspace(-4, 4, 8001)
    found = averaged(lambda d: np.where(np.abs(d) < 1.237, 1.0, 0.0), depth, 1.5, 0.1)
    assert np.trapezoid(found, depth) == pytest.approx(2 * 1.237, abs=2 * 0.1 / 16)


@pytest.mark.parametrize("profile", ["flat", "round", "bevel", "rope", "bead"])
def test_the_frame_of_a_plate_has_its_height_and_the_relief_keeps_its(profile):
    relief = made(design("round", frame="5mm", frame_height="2mm", frame_profile=profile))
    outline = relief.height.outline
    depth = depth_of(relief, outline)
    inside = (depth > 0) & (depth < 5)
    exact = profile != "round"
    assert relief.z_mm[inside].max() == pytest.approx(2, abs=1e-9 if exact else 2e-2)
    assert relief.z_mm[depth > 5].max() == pytest.approx(1, abs=1e-9)
    assert relief.plate.frame == {"width_mm": 5.0, "height_mm": pytest.approx(2.0), "profile": profile}
    check_solid(solid(relief))


def test_without_a_height_the_frame_is_as_high_as_the_motif():
    relief = made(design("round", frame="3mm"))
    depth = depth_of(relief, relief.height.outline)
    assert relief.z_mm[(depth > 0) & (depth < 2)] == pytest.approx(1.0, abs=1e-9)
    engraved = made(design("round", frame="3mm", engrave=True))
    assert engraved.z_mm[(depth > 0) & (depth < 2)] == pytest.approx(1.0, abs=1e-9)
    assert engraved.height.range_mm == pytest.approx((-1, 1), abs=1e-9)


def test_the_relief_does_not_show_under_the_frame():
    normals, _ = ball(60, 60, 2.0)
    covered = made(design("round", frame="6mm", fill="cover"), (normals, None), background="plane", delta=80.0)
    depth = depth_of(covered, covered.height.outline)
    assert covered.plate.fill == "cover"
    level = covered.z_mm[(depth > 0) & (depth < 4)]
    assert level == pytest.approx(level[0], abs=1e-12)


def test_frames_that_leave_no_room_are_refused():
    message = r"no room is left for the motif on a plate 40 mm wide: frame 21 mm, margin 1.6 mm on each side; make the"
    with pytest.raises(nm.InputError, match=message):
        made(design("round", frame="21mm"))
    normals, _ = ball(40, 40, 2.0)
    with pytest.raises(nm.InputError, match="40 mm wide: frame 21 mm on each side"):
        made(design("round", frame="21mm", fill="cover"), (normals, None))
    with pytest.raises(nm.InputError, match=r"40 mm wide: frame 12 mm, margin 1.6 mm"):
        made(design("star.svg", frame="12mm"))
    with pytest.raises(
        nm.InputError, match=r"`frame='14mm'`: a frame 14 mm wide leaves nothing inside a plate of 40 x"
    ):
        made(design("star.svg", frame="14mm", fill="cover"), (normals, None))


def test_the_frame_of_an_engraving_is_as_high_as_it_is_deep_also_if_the_motif_dips():
    normals, mask = ball()
    y, x = np.mgrid[-1:1:64j, -1:1:64j]
    dip = np.exp(-((np.hypot(x, y) - 0.6) ** 2) / 0.01)[..., None]
    normals = normals * [[[-1.0, -1.0, 1.0]]] * dip + normals * (1 - dip)
    relief = made(design("round", frame="3mm", engrave=True), (normals, mask), delta=5.0)
    assert relief.plate.frame["height_mm"] == pytest.approx(1, abs=1e-9)
    assert relief.report.relief_range_mm == pytest.approx(1)
