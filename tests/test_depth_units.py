"""Real lengths: units, fields of view, disparities, and the range of codes in use."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from depth_scenes import FOCAL, FOV, ROWS, codes, floats, sphere, stretched
from test_depth_presets import agreement, slopes

import nmaptool as nm


def ramp(low: float, high: float, bits: int = 16) -> nm.RasterImage:
    return codes(np.round(np.tile(np.linspace(low, high, 101), (40, 1))), bits)


def test_orthographic_distances_need_the_width() -> None:
    image = ramp(1000, 2000)
    result = nm.depth_to_normals(image, nm.DepthOptions(values="distance", unit="0.5mm", width="202mm"))
    # 500 mm over 100 px of 2 mm, towards the viewer on the left
    np.testing.assert_allclose(slopes(result)[..., 0], -2.5, rtol=1e-3)
    assert (result.report.scale_from, result.report.pitch_from) == ("unit", "given")
    assert result.report.scale_px == pytest.approx(250)
    assert "more than the picture is wide (101 px): check `unit` and `width`" in result.report.warnings[0]
    with pytest.raises(
        nm.UsageError, match=r"`unit='1mm'`: the size of a pixel in image is not known; give the `width` of"
    ):
        nm.depth_to_normals(image, nm.DepthOptions(unit="1mm"))
    with pytest.raises(nm.UsageError, match=r"give the `width` of the picture, or the `fov` of the camera"):
        nm.depth_to_normals(image, nm.DepthOptions(unit="1mm", values="distance"))


@pytest.mark.parametrize("unit", ["1m", "100cm", "1000mm"])
def test_units_may_be_metres_centimetres_or_millimetres(unit: str) -> None:
    scene = sphere()
    result = nm.depth_to_normals(floats(scene.mm / 1000), nm.DepthOptions(values="distance", unit=unit, fov=FOV))
    assert result.report.pitch_mm == pytest.approx(np.median(scene.mm) / FOCAL, rel=1e-3)
    assert agreement(result, scene.slopes, scene.inside)[1] == pytest.approx(1, abs=1e-4)


def test_heights_in_front_of_a_camera_name_the_unit() -> None:
    with pytest.raises(nm.UsageError, match=r"`unit`: white is 500 px in front of black, .*; check `unit` and `width`"):
        nm.depth_to_normals(ramp(1000, 2000), nm.DepthOptions(unit="1mm", width="202mm", fov=60))


def test_a_width_sets_the_pitch_and_leaves_slopes_in_perspective() -> None:
    scene = sphere()
    image = floats(scene.mm / 1000)
    plain, wide = (
        nm.depth_to_normals(image, nm.DepthOptions(values="distance", unit="1m", fov=FOV, width=width))
        for width in (None, "100mm")
    )
    np.testing.assert_allclose(wide.normal_map.normals, plain.normal_map.normals, atol=1e-6)
    assert (wide.report.pitch_mm, wide.report.pitch_from) == (pytest.approx(0.5), "given")
    # px are those at the median distance
    assert plain.report.scale_px == pytest.approx(np.ptp(scene.mm) * FOCAL / np.median(scene.mm), rel=1e-3)


def test_a_focal_length_is_a_field_of_view() -> None:
    image = floats(sphere().mm)
    degrees, focal = (
        nm.depth_to_normals(image, nm.DepthOptions(values="distance", fov=fov)) for fov in (FOV, f"{FOCAL:.6f}px")
    )
    assert focal.report.fov == pytest.approx(FOV, abs=1e-4)
    np.testing.assert_allclose(focal.normal_map.normals, degrees.normal_map.normals, atol=1e-5)
    with pytest.raises(
        nm.UsageError, match=r"`fov='5px'`: a focal length of 5 px gives 174 degrees across 200 px; must"
    ):
        nm.depth_to_normals(image, nm.DepthOptions(fov="5px"))


@pytest.mark.parametrize("fov", [None, FOV])
def test_absolute_disparities_become_distances(fov: float | None) -> None:
    scene = sphere(700, 300)
    far = np.where(scene.mask, 1000 / scene.mm, 0)  # 0 is infinitely far
    inverse = nm.depth_to_normals(floats(far), nm.DepthOptions(values="disparity", fov=fov))
    plain = nm.depth_to_normals(
        floats(np.where(scene.mask, scene.mm / 1000, np.nan)), nm.DepthOptions(values="distance", fov=fov)
    )
    assert inverse.report.absolute
    assert inverse.report.inverted
    assert inverse.report.empty == {"0 or less": np.count_nonzero(~scene.mask)}
    np.testing.assert_allclose(inverse.normal_map.normals, plain.normal_map.normals, atol=1e-3)
    np.testing.assert_array_equal(inverse.normal_map.coverage, plain.normal_map.coverage)


def test_disparities_in_pixels_are_distances_by_their_unit() -> None:
    scene = sphere()
    image = codes(np.round(256 * 2.4e5 / scene.mm), 16)  # focal length times baseline is 240 m px, 1/256 px per code
    options = nm.DepthOptions(values="disparity", unit=f"{256 * 240}m", fov=FOV)
    result = nm.depth_to_normals(image, options)
    assert agreement(result, scene.slopes, scene.inside)[0] > 0.999
    assert result.report.distance_mm == pytest.approx(np.median(scene.mm), rel=1e-3)


def test_normalised_disparities_are_heights() -> None:
    scene = sphere()
    for image in (floats(stretched(1 / scene.mm)), codes(stretched(1 / scene.mm, 255), 8)):
        report = nm.depth_to_normals(image, nm.DepthOptions(values="disparity")).report
        assert (report.values, report.absolute, report.inverted) == ("disparity", False, False)


@pytest.mark.parametrize(
    ("low", "high", "source"), [(0, 65535, "assumed"), (20_000, 27_000, "assumed"), (20_000, 25_000, "range")]
)
def test_few_codes_in_use_have_the_whole_height(low: int, high: int, source: str) -> None:
    result = nm.depth_to_normals(ramp(low, high), nm.DepthOptions(background="none"))
    report = result.report
    used = 10.1 if source == "range" else 10.1 * (high - low) / 65535
    assert report.scale_from == source
    assert report.range_px == pytest.approx(used, rel=1e-3)
    assert (report.lowest_value, report.highest_value) == (low, high)
    assert report.used_share == pytest.approx((high - low) / 65535)
    np.testing.assert_allclose(slopes(result)[:, 2:-2, 0], used / 100, rtol=2e-2)


def test_a_given_scale_stays_that_of_all_codes_with_a_warning() -> None:
    few = nm.depth_to_normals(ramp(743, 792), nm.DepthOptions(depth_scale="24px", background="none"))
    assert few.report.range_px == pytest.approx(24 * 49 / 65535, rel=1e-3)
    (warning,) = few.report.warnings
    assert warning.startswith(
        "only the codes 743 to 792 of 0 to 65535 are in use, so the surface is only 0.0179 px deep"
    )
    assert "give `depth_scale='32099px'` for 24 px" in warning
    deep = nm.depth_to_normals(ramp(743, 792), nm.DepthOptions(depth_scale="32099px", background="none"))
    assert deep.report.range_px == pytest.approx(24, abs=0.3)  # half a step of the codes
    more = nm.depth_to_normals(ramp(743, 1500), nm.DepthOptions(depth_scale="24px", background="none"))
    assert more.report.warnings == ()


def test_few_values_of_normalised_floats_have_the_whole_height() -> None:
    report = nm.depth_to_normals(floats(np.tile(np.linspace(0.5, 0.55, 100), (40, 1)))).report
    assert (report.scale_from, report.used_share) == ("range", None)
    assert report.range_px == pytest.approx(10, rel=1e-4)


def test_a_preset_without_a_lens_or_width_is_scaled_by_its_range() -> None:
    scene = sphere()
    report = nm.depth_to_normals(floats(scene.mm / 1000), nm.DepthOptions(from_="depth-pro")).report
    assert (report.unit, report.scale_from, report.pitch_mm, report.lens) == (
        "1m",
        "assumed",
        None,
        "its output, as a focal length in px",
    )
    assert report.range_px == pytest.approx(20, rel=1e-3)


def test_lengths_may_be_in_metres() -> None:
    assert nm.length("1.5 m") == nm.Length(1.5, "m")
    assert nm.length("2m").to_mm(1.0, 1) == 2000
    assert nm.length("2m").is_absolute
    with pytest.raises(nm.UsageError, match=r"expected a number with a unit \(mm, cm, m, in, px, %\)"):
        nm.length("2km")


TURNS: dict[int, Any] = {
    1: lambda a: a,
    2: np.fliplr,
    3: lambda a: np.rot90(a, 2),
    4: np.flipud,
    5: np.transpose,
    6: lambda a: np.rot90(a, -1),
    7: lambda a: np.rot90(a, 2).T,
    8: np.rot90,
}


@pytest.mark.parametrize("orientation", TURNS)
def test_a_picture_is_turned_upright(orientation: int) -> None:
    stored = np.round(stretched(sphere().mm, 65535)[:, :180])
    stored[:20, :30] = 60000
    result = nm.depth_to_normals(codes(stored, 16, orientation=orientation))
    upright = nm.depth_to_normals(codes(np.ascontiguousarray(TURNS[orientation](stored)), 16))
    np.testing.assert_array_equal(result.normal_map.normals, upright.normal_map.normals)
    assert result.normal_map.frame.shape == ((180, ROWS) if orientation > 4 else (ROWS, 180))
    assert result.report.orientation == orientation


def test_a_mask_of_the_turned_picture_fits_it() -> None:
    image = codes(stretched(sphere().mm, 255), 8, orientation=6, name="tall.jpg")
    mask = np.zeros((200, ROWS), bool)
    mask[:60] = True
    np.testing.assert_array_equal(nm.depth_to_normals(image, mask=mask).normal_map.coverage[60:], 0)
    with pytest.raises(
        nm.InputError,
        match=r"tall\.jpg, turned upright by its EXIF orientation 6, is 150 x 200 pixels but the mask is 200 x 150",
    ):
        nm.depth_to_normals(image, mask=mask.T)
