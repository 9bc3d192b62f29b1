"""The light on a height field: cast shadows of known length, the sky's share, and what a pixel can be at most."""

import math

import numpy as np
import pytest
from scipy import ndimage

import nmaptool as nm
from nmaptool.options.materials import MATERIALS
from nmaptool.options.preview import Light
from nmaptool.shading.field import field_of, mean_of_corners, picture_shape
from nmaptool.shading.occlusion import sky_share
from nmaptool.shading.outlines import enlarged_coverage, plate_coverage
from nmaptool.shading.resampling import resampled
from nmaptool.shading.shadows import lit_share
from nmaptool.shading.tone import displayed
from nmaptool.shading.top import top_view
from nmaptool.types.contours import Contours

PITCH = 0.1


def field(z_mm, pitch=PITCH):
    rows, cols = (side - 1 for side in z_mm.shape)
    return nm.Height(z_mm, np.ones((rows, cols), bool), nm.Frame(rows, cols, pitch))


def cliff(azimuth_deg, side=240, height_mm=1.0):
    """A plateau towards the light that ends in the middle, and the distance of each vertex from its edge in mm."""
    row, col = np.mgrid[0:side, 0:side] - (side - 1) / 2
    angle = math.radians(azimuth_deg)
    distance = (math.sin(angle) * row - math.cos(angle) * col) * PITCH
    return np.where(distance <= 1e-9, height_mm, 0).astype(np.float32), distance


def inner(shape, share=0.7):
    """Pixels that no light from beside the picture reaches."""
    row, col = (np.abs(np.linspace(-1, 1, side)) for side in shape)
    return np.maximum(row[:, None], col[None, :]) < share


def shadow_ends(lit, azimuth_deg, from_mm):
    """Distances from the middle of the picture at which shadows end, along lines away from the light, in mm."""
    angle = math.radians(azimuth_deg)
    along, beside = np.arange(from_mm, 8.5, PITCH / 20) / PITCH, np.arange(-60, 60, 0.37)
    col = -math.cos(angle) * along + math.sin(angle) * beside[:, None] + (lit.shape[1] - 1) / 2
    row = math.sin(angle) * along + math.cos(angle) * beside[:, None] + (lit.shape[0] - 1) / 2
    seen = ndimage.map_coordinates(lit, [row, col], order=1)
    return along[(seen > 0.5).argmax(axis=1)] * PITCH


@pytest.mark.parametrize("azimuth", [0, 90, 180, 270, 45, 135, 225, 30, 101, 200, 313, -20, 64.3])
@pytest.mark.parametrize("elevation", [9, 20, 38, 60])
def test_the_shadow_of_a_step_has_the_length_that_the_elevation_says(azimuth, elevation):
    z, distance = cliff(azimuth)
    lit = lit_share(z, PITCH, Light(azimuth, elevation))
    length = 1 / math.tan(math.radians(elevation))
    ends = shadow_ends(lit, azimuth, from_mm=2.5 * PITCH)
    # the last vertices of the plateau lie up to a pixel before its edge, half a pixel on average
    steep = PITCH / max(abs(math.cos(math.radians(azimuth))), abs(math.sin(math.radians(azimuth))))
    assert ends.mean() == pytest.approx(length - steep / 2, abs=steep / 2)
    assert np.abs(ends - (length - steep / 2)).max() <= steep
    assert ends.std() < PITCH / 2
    seen = inner(z.shape)
    assert lit[seen & (distance > 2 * PITCH) & (distance < 0.7 * length - PITCH)].max(initial=0) < 0.01
    assert lit[seen & (distance > 1.5 * length + PITCH)].min(initial=1) == 1
    assert lit[seen & (distance < -PITCH)].min() == 1


def test_a_step_at_the_edge_of_pixels_is_exact():
    z = np.zeros((4, 101), np.float32)
    z[:, :31] = 2.0  # from 3.0 mm on, the side falls to the next vertex
    lit = lit_share(z, PITCH, Light(180, 45), size_deg=0.01)[1]
    places = np.arange(101) * PITCH
    edge = np.interp(0.5, lit[31:], places[31:])
    assert edge == pytest.approx(3.0 + 2.0, abs=0.01 * PITCH)


@pytest.mark.parametrize("azimuth", [0, 37, 135, 250])
def test_a_surface_that_the_light_grazes_is_not_in_its_own_shadow(azimuth):
    row, col = np.mgrid[0:120, 0:120] * PITCH
    angle = math.radians(azimuth)
    along = math.cos(angle) * col - math.sin(angle) * row
    light = Light(azimuth, 30)
    for tilt, expected in ((28, 1), (-60, 1), (32, 0)):
        plane = (along * math.tan(math.radians(tilt))).astype(np.float32)  # rises towards the light
        lit = lit_share(plane, PITCH, light, size_deg=0.5)
        assert np.abs(lit[inner(lit.shape, 0.5)] - expected).max() < 1e-6, tilt


def test_a_lamp_of_any_size_casts_its_half_shadow_at_the_same_place():
    z, _ = cliff(180, side=241)
    for size in (0.2, 2, 8):
        ends = shadow_ends(lit_share(z, PITCH, Light(180, 25), size_deg=size), 180, from_mm=2.5 * PITCH)
        assert ends == pytest.approx(1 / math.tan(math.radians(25)), abs=0.1 * PITCH)


def test_a_flat_plate_sees_all_of_the_sky_and_a_groove_less():
    flat = np.zeros((90, 120), np.float32)
    assert np.array_equal(sky_share(flat, PITCH), np.ones_like(flat))
    grooved = flat.copy()
    grooved[:, 55:65] = -1.0
    sky = sky_share(grooved, PITCH)
    assert sky[20:-20, 60].max() < 0.65
    assert sky[:, 20].min() > 0.99
    assert sky.min() >= 0
    deeper = flat.copy()
    deeper[:, 55:65] = -2.0
    assert sky_share(deeper, PITCH)[45, 60] < sky[45, 60]


@pytest.mark.parametrize("tilt", [10, 30, 45, 60])
def test_a_tilted_plane_sees_the_part_of_the_sky_above_it(tilt):
    row, _ = np.mgrid[0:200, 0:200] * PITCH
    sky = sky_share((row * math.tan(math.radians(tilt))).astype(np.float32), PITCH)
    assert sky[100, 100] == pytest.approx((1 + math.cos(math.radians(tilt))) / 2, abs=0.01)


def test_light_from_the_horizon_reaches_no_level_plate():
    plate = field(np.zeros((40, 40)))
    for name, material in MATERIALS.items():
        dark = top_view(field_of(plate, 40), material, [], np.zeros(3, np.float32))
        low = top_view(field_of(plate, 40), material, [Light(0, 1e-6)], np.zeros(3, np.float32))
        # studio light in metals and the sky remain; the lamp itself adds nothing but its gleam
        if not material.metal:
            assert np.abs(low - dark).max() < 0.02, name


def bumps(side=160):
    y, x = np.mgrid[-1 : 1 : side * 1j, -1 : 1 : side * 1j]
    return field(np.sin(9 * x + y) * np.cos(7 * y) + 2 * np.exp(-6 * (x * x + y * y)))


@pytest.mark.parametrize("name", MATERIALS)
def test_no_material_scatters_more_light_than_it_gets(name):
    material = MATERIALS[name]
    assert min(material.color) >= 0 and max(material.color) <= 1
    lights = [Light(135, 38), Light(15, 22, 0.3)]
    light = top_view(field_of(bumps(), 320), material, lights, np.zeros(3, np.float32))
    assert np.isfinite(light).all()
    assert light.min() >= 0
    if not material.metal:  # two lamps and the sky on a surface that faces them, and a gleam
        assert light.max() < 2.0
        assert light.mean() < max(material.color)
    codes = displayed(light)
    assert np.mean(codes == 255) < 0.03
    assert np.mean(codes == 0) < 0.2
    assert codes.std() > 8


def test_the_table_of_materials_describes_each_in_one_clause():
    assert {"clay", "plaster", "bronze", "silver", "gold", "marble", "walnut"} <= set(MATERIALS)
    for name, material in MATERIALS.items():
        assert material.description.startswith("is "), name
        assert not material.description.endswith("."), name
        assert 0 < material.roughness <= 1
        assert all(0 <= part <= 1 for part in (*material.color, *material.recess, *material.backdrop))
    assert len({material.color for material in MATERIALS.values()}) == len(MATERIALS)


@pytest.mark.parametrize("name", [name for name, material in MATERIALS.items() if material.pattern == "none"])
def test_a_relief_and_its_light_turned_together_give_the_turned_picture(name):
    height = bumps(97)
    lights = [Light(135, 38), Light(15, 22, 0.3)]
    turned = [Light(light.azimuth_deg + 90, light.elevation_deg, light.strength) for light in lights]
    backdrop = np.zeros(3, np.float32)
    plain = top_view(field_of(height, 192), MATERIALS[name], lights, backdrop)
    again = field(np.rot90(height.z_mm).copy())
    found = top_view(field_of(again, 192), MATERIALS[name], turned, backdrop)
    wrong = np.abs(found - np.rot90(plain))
    assert wrong.mean() < 5e-4
    # rounding decides which of two equally high points casts a shadow
    assert np.mean(wrong > 4e-3) < 0.01


def test_highlights_are_compressed_and_order_is_kept():
    light = np.linspace(0, 6, 500, dtype=np.float32)[:, None].repeat(3, axis=1)
    codes = displayed(light)[:, 0].astype(int)
    assert (np.diff(codes) >= 0).all()
    assert codes[0] == 0
    assert codes[-1] == 255
    assert 200 < displayed(np.full((1, 3), 0.9, np.float32))[0, 0] < 250


def test_a_spline_passes_through_its_samples_and_follows_a_smooth_surface():
    y, x = np.mgrid[0:30, 0:40]
    wave = (np.sin(x / 4) * np.cos(y / 5)).astype(np.float32)
    np.testing.assert_allclose(resampled(wave, np.arange(30.0), np.arange(40.0)), wave)
    rows, cols = np.linspace(0, 29, 117), np.linspace(0, 39, 157)
    fine = resampled(wave, rows, cols)
    expected = np.sin(cols / 4) * np.cos(rows[:, None] / 5)
    assert np.abs(fine - expected)[20:-20, 20:-20].max() < 1e-3
    plane = (2 * x + 3 * y).astype(np.float32)
    np.testing.assert_allclose(resampled(plane, rows, cols), 2 * cols + 3 * rows[:, None], atol=1e-4)
    # the samples are the fine grid's every fourth
    np.testing.assert_allclose(fine[::4, ::4], wave, atol=1e-5)


@pytest.mark.parametrize(
    ("shape", "size", "expected"),
    [((200, 300), None, (600, 900)), ((901, 1200), None, (901, 1200)), ((20, 40), 512, (256, 512))],
)
def test_the_size_of_a_picture(shape, size, expected):
    assert picture_shape(*shape, size) == expected
    height = field(np.zeros((shape[0] + 1, shape[1] + 1)))
    found = field_of(height, size)
    assert found.shape == expected
    assert found.pitch_mm * expected[1] == pytest.approx(PITCH * shape[1])


def test_a_large_relief_is_averaged_instead_of_sampled():
    stripes = np.tile(np.array([0.0, 1.0] * 1500), (4, 1))
    z = field_of(field(stripes), 300).z_mm
    assert np.abs(z[:, 5:-5] - 0.5).max() < 0.1


def test_the_exact_outline_of_a_plate_sets_its_coverage():
    turn = np.linspace(0, math.tau, 720, endpoint=False)
    ring = np.stack([4 + 3 * np.cos(turn), 4 + 3 * np.sin(turn)], axis=1)
    hole = np.stack([4 + np.cos(-turn), 5 + np.sin(-turn)], axis=1)
    outline = Contours((ring, hole))
    y, x = np.mgrid[0:80, 0:80] * PITCH + PITCH / 2
    inside = (np.hypot(x - 4, y - 4) < 3) & (np.hypot(x - 4, 8 - y - 5) > 1)
    plate = nm.Height(np.zeros((81, 81)), inside, nm.Frame(80, 80, PITCH), outline=outline)
    for side in (80, 400):
        cover = plate_coverage(plate, (side, side))
        area = cover.sum() * (8 / side) ** 2
        assert area == pytest.approx(outline.area_mm2, rel=0.003)
        soft = (cover > 0) & (cover < 1)
        assert 0 < soft.sum() < 4 * math.tau * 4 / (8 / side)
    assert cover[150, 200] == 0  # in the hole, above the middle
    assert cover[250, 200] == 1


def test_the_outline_of_a_mask_is_smooth_and_keeps_its_area_and_thin_parts():
    y, x = np.mgrid[0:100, 0:100] + 0.5
    round_ = np.hypot(x - 50, y - 50) < 30
    fine = enlarged_coverage(round_, (600, 600))
    assert fine.sum() / 36 == pytest.approx(math.pi * 900, rel=0.01)
    v, u = (np.mgrid[0:600, 0:600] + 0.5) / 6
    away = np.hypot(u - 50, v - 50) - 30
    assert fine[away < -0.6].min() == 1
    assert fine[away > 0.6].max() == 0
    line = np.zeros((100, 100), bool)
    line[50, 10:90] = True
    assert enlarged_coverage(line, (100, 100))[50, 20:80].min() == 1
    assert enlarged_coverage(line, (400, 400))[202, 100:300].min() > 0.5
    assert enlarged_coverage(np.ones((5, 7), bool), (50, 70)).min() == 1


def test_walls_of_a_raised_motif_stay_steep_when_it_is_enlarged():
    raised = np.zeros((40, 40), bool)
    raised[10:30, 10:30] = True
    z = np.where(np.pad(raised, ((0, 1), (0, 1))) | np.pad(raised, ((1, 0), (1, 0))), 2.0, 0.0)
    height = nm.Height(z, np.ones((40, 40), bool), nm.Frame(40, 40, PITCH), raised=raised)
    found = mean_of_corners(field_of(height, 400).z_mm)
    across = found[200]
    assert across[150] == pytest.approx(2, abs=0.01)
    assert across[50] == pytest.approx(0, abs=0.01)
    assert ((across > 0.05) & (across < 1.95)).sum() <= 8
