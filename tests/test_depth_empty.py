"""Stored values that mean "no depth": found, reported, and set by an option."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from depth_cases import ball
from depth_scenes import bust, codes, floats, sphere
from test_depth_presets import slopes

import nmaptool as nm

SCENE = sphere()
HOLE = ~SCENE.mask


def holed(values: Any, nothing: float) -> Any:
    return np.where(HOLE, nothing, values)


@pytest.mark.parametrize(
    "nothing", [1e10, 65504.0, np.inf, -np.inf, np.nan, 3.4e38, -3.4e38, -9999.0, -32768.0, -32767.0]
)
@pytest.mark.parametrize("values", ["height", "distance"])
def test_values_of_convention_are_background(nothing: float, values: Any) -> None:
    metres = SCENE.mm / 1000
    result = nm.depth_to_normals(floats(holed(metres, nothing)), nm.DepthOptions(values=values))
    expected = nm.depth_to_normals(floats(metres), nm.DepthOptions(values=values), mask=SCENE.mask)
    np.testing.assert_array_equal(result.normal_map.coverage > 0, SCENE.mask)
    np.testing.assert_allclose(result.normal_map.normals, expected.normal_map.normals, atol=2e-3)
    assert sum(result.report.empty.values()) == np.count_nonzero(HOLE)
    assert result.report.background == "empty"
    assert result.report.empty_pixels == np.count_nonzero(HOLE)
    assert result.report.range_px == pytest.approx(20, rel=1e-2)


def test_a_value_close_to_the_others_is_a_depth() -> None:
    heights = np.tile(np.linspace(-9999, 12_000, 120), (80, 1))
    assert nm.depth_to_normals(floats(heights), nm.DepthOptions(background="none")).report.empty == {}
    tall = np.tile(np.linspace(0, 65504, 120), (80, 1))
    assert nm.depth_to_normals(floats(tall), nm.DepthOptions(background="none")).report.empty == {}


@pytest.mark.parametrize(
    "image", [floats(holed(SCENE.mm, -1.0), nodata=-1.0), codes(holed(SCENE.mm, 257 * 4), 16, nodata=1028.0)]
)
def test_the_value_that_a_file_names_is_background(image: nm.RasterImage) -> None:
    result = nm.depth_to_normals(image)
    np.testing.assert_array_equal(result.normal_map.coverage > 0, SCENE.mask)
    kept = nm.depth_to_normals(image, nm.DepthOptions(empty="none", background="none"))
    assert kept.normal_map.coverage.all()
    assert kept.report.empty == {}


def test_a_named_value_in_8_bits_widened_to_16_is_found() -> None:
    wide = np.round(200 * (SCENE.mm - SCENE.mm.min()) / np.ptp(SCENE.mm)) * 257
    result = nm.depth_to_normals(codes(holed(wide, 65535), 16, nodata=65535.0))
    assert result.report.bits == 8
    np.testing.assert_array_equal(result.normal_map.coverage > 0, SCENE.mask)


@pytest.mark.parametrize("values", ["auto", "distance"])
def test_the_zeros_of_a_depth_camera_are_background(values: Any) -> None:
    image = codes(holed(np.round(SCENE.mm), 0), 16)
    result = nm.depth_to_normals(image, nm.DepthOptions(values=values))
    np.testing.assert_array_equal(result.normal_map.coverage > 0, SCENE.mask)
    assert result.report.empty == {"0": np.count_nonzero(HOLE)}
    assert result.report.scale_from == "range"
    assert result.report.range_px == pytest.approx(20, rel=1e-2)
    doubts = [w for w in result.report.warnings if w.startswith("0 is read as no reading, as depth cameras write it")]
    assert len(doubts) == (values == "auto")
    kept = nm.depth_to_normals(image, nm.DepthOptions(values=values, empty="none", background="none"))
    assert kept.normal_map.coverage.all()


def test_a_saturated_distance_is_background() -> None:
    mm = holed(np.round(SCENE.mm), 65535)
    mm[:20, :30] = 0
    result = nm.depth_to_normals(codes(mm, 16), nm.DepthOptions(values="distance"))
    assert result.report.empty == {"0": 600, "65535": np.count_nonzero(HOLE) - 600}
    np.testing.assert_array_equal(result.normal_map.coverage > 0, SCENE.mask)


def test_a_far_plane_is_background_unless_a_plate_is_wanted() -> None:
    image = floats(holed(SCENE.mm / 1000, 100.0))
    result = nm.depth_to_normals(image, nm.DepthOptions(values="distance"))
    assert result.report.empty == {"100": np.count_nonzero(HOLE)}
    assert result.report.range_px == pytest.approx(20, rel=1e-2)
    plate = nm.depth_to_normals(image, nm.DepthOptions(values="distance", background="flat"))
    assert (plate.report.empty, plate.report.background) == ({}, "flat")


def test_zeros_that_the_user_or_the_file_names_are_not_doubted() -> None:
    mm = holed(np.round(SCENE.mm), 0)
    for image, empty in ((codes(mm, 16), "0"), (codes(mm, 16, nodata=0.0), "auto")):
        report = nm.depth_to_normals(image, nm.DepthOptions(empty=empty)).report
        assert (report.empty, report.warnings) == ({"0": np.count_nonzero(HOLE)}, ())


def test_gaps_in_heights_that_look_like_missing_readings_stay_open() -> None:
    mm = np.where(speckled(SCENE), 0, holed(np.round(SCENE.mm), 0))
    assumed = nm.depth_to_normals(codes(mm, 16))
    assert (assumed.report.filled_holes, assumed.report.empty) == (0, {"0": np.count_nonzero(mm == 0)})
    np.testing.assert_array_equal(assumed.normal_map.coverage > 0, mm > 0)
    assert nm.depth_to_normals(codes(mm, 16), nm.DepthOptions(values="distance")).report.filled_holes > 50


def test_distances_of_many_values_far_beyond_the_rest_are_background() -> None:
    y, x = np.mgrid[: HOLE.shape[0], : HOLE.shape[1]]
    sky = np.where(HOLE, 1e5 + 700 * x + 300 * y, SCENE.mm / 1000)  # a far clip seen at an angle
    result = nm.depth_to_normals(floats(sky), nm.DepthOptions(values="distance"))
    assert result.report.empty == {"far beyond the rest": np.count_nonzero(HOLE)}
    np.testing.assert_array_equal(result.normal_map.coverage > 0, SCENE.mask)
    assert result.report.range_px == pytest.approx(20, rel=1e-2)


@pytest.mark.parametrize("bits", [8, 16])
def test_the_black_ground_of_a_height_map_is_no_missing_reading(bits: int) -> None:
    scene = ball(96, 30, 30)
    image = codes(np.round(scene.heights / 60 * (2**bits - 1)), bits)
    report = nm.depth_to_normals(image).report
    assert (report.background, report.empty, report.warnings) == ("cut", {}, ())
    smooth = codes(np.tile(np.linspace(0, 255, 120), (60, 1)), 8)
    assert nm.depth_to_normals(smooth).report.empty == {}
    low = codes(np.tile(np.arange(120) * 40, (60, 1)), 16)  # few codes, but no gap above 0
    assert nm.depth_to_normals(low).report.empty == {}


def test_a_plate_was_asked_for() -> None:
    image = codes(holed(np.round(SCENE.mm), 0), 16)
    plate = nm.depth_to_normals(image, nm.DepthOptions(background="flat"))
    assert (plate.report.background, plate.report.empty) == ("flat", {})
    height = nm.depth_to_normals(image, nm.DepthOptions(values="height"))
    assert (height.report.background, height.report.empty) == ("cut", {})


def test_given_values_replace_those_found() -> None:
    values = holed(SCENE.mm, 7.5)
    values[:10] = -9999
    result = nm.depth_to_normals(floats(values), nm.DepthOptions(empty="7.5"))
    assert result.report.empty == {"7.5": np.count_nonzero(HOLE[10:])}
    both = nm.depth_to_normals(floats(values), nm.DepthOptions(empty="7.5,-9999"))
    assert both.report.empty == {"7.5": np.count_nonzero(HOLE[10:]), "-9999": 2000}
    np.testing.assert_array_equal(both.normal_map.coverage > 0, SCENE.mask & (np.arange(150) >= 10)[:, None])
    assert nm.DepthOptions(empty=0).empty == "0"
    with pytest.raises(
        nm.UsageError, match="`empty='zero'`: use auto, none or numbers separated by commas, such as 0,-9999"
    ):
        nm.DepthOptions(empty="zero")


def test_a_picture_without_any_depth_is_refused() -> None:
    with pytest.raises(nm.InputError, match="no pixel has a depth: all are transparent, -9999"):
        nm.depth_to_normals(floats(np.full((8, 8), -9999.0), nodata=-9999.0))
    with pytest.raises(nm.InputError, match="no pixel has a depth greater than 0"):
        nm.depth_to_normals(floats(np.full((8, 8), 65504.0)))


def speckled(scene: Any, share: float = 0.02) -> Any:
    """Pixels in small groups, away from the motif's outline."""
    rng = np.random.default_rng(5)
    spots = rng.random(scene.mask.shape) < share
    spots |= np.roll(spots, 1, axis=1) & (rng.random(spots.shape) < 0.7)
    return spots & scene.inside


def test_dropouts_are_filled_from_the_surface_around() -> None:
    scene = bust()
    spots = speckled(scene)
    mm = np.where(scene.mask, scene.mm, 0)
    options = nm.DepthOptions(values="distance", fov=50)
    whole = nm.depth_to_normals(floats(mm), options)
    result = nm.depth_to_normals(floats(np.where(spots, 0, mm)), options)
    report = result.report
    np.testing.assert_array_equal(result.normal_map.coverage > 0, scene.mask)
    assert report.filled_pixels == np.count_nonzero(spots)
    assert 100 < report.filled_holes < report.filled_pixels
    off = np.linalg.norm(slopes(result) - slopes(whole), axis=-1)
    size = np.linalg.norm(slopes(whole), axis=-1)[spots].mean()
    assert off[spots].mean() < 0.01 * size
    kept = nm.depth_to_normals(floats(np.where(spots, 0, mm)), nm.DepthOptions(values="distance", fov=50, fill="none"))
    np.testing.assert_array_equal(kept.normal_map.coverage > 0, scene.mask & ~spots)
    assert (kept.report.filled_holes, kept.report.fill_px) == (0, 0)


def test_a_tilted_plane_is_filled_exactly() -> None:
    y, x = np.mgrid[:80, :100]
    plane = 50 + 0.3 * x - 0.2 * y
    hole = np.hypot(x - 40, y - 30) < 4
    image = floats(np.where(hole | (np.hypot(x - 70, y - 50) < 9), np.nan, plane))
    options = nm.DepthOptions(depth_scale=f"{np.ptp(plane)}px", background="none", fill="9px")
    result = nm.depth_to_normals(image, options)
    assert (result.report.filled_holes, result.report.filled_pixels) == (1, np.count_nonzero(hole))
    np.testing.assert_allclose(slopes(result)[hole], np.broadcast_to([0.3, 0.2], (hole.sum(), 2)), atol=1e-3)
    assert not result.normal_map.coverage[50, 70]


def test_a_hole_on_an_outline_keeps_the_jump() -> None:
    y, x = np.mgrid[:80, :100]
    heights = np.where(x < 50, 60 + 0.1 * x, 20 + 0.2 * y)
    hole = (np.hypot(x - 50, y - 30) < 3.2) | ((np.abs(y - 55) < 2) & (np.abs(x - 48) < 2))
    image = floats(np.where(hole, np.nan, heights))
    options = nm.DepthOptions(depth_scale=f"{np.ptp(heights)}px", background="none", fill="8px")
    filled, whole = nm.depth_to_normals(image, options), nm.depth_to_normals(floats(heights), options)
    assert filled.report.filled_pixels == np.count_nonzero(hole)
    assert np.linalg.norm(slopes(filled) - slopes(whole), axis=-1).max() < 0.25
    np.testing.assert_allclose(filled.jumps.sum(), whole.jumps.sum(), rtol=0.05)


def test_only_dropouts_are_filled() -> None:
    y, x = np.mgrid[:80, :100]
    heights = (60 + 0.1 * x + 0.1 * y).astype(np.float32)
    spot = np.hypot(x - 40, y - 30) < 1.5
    options = nm.DepthOptions(values="distance")
    for nothing in (1e10, np.inf, 65504):  # a renderer saw nothing there
        report = nm.depth_to_normals(floats(np.where(spot, nothing, heights)), options).report
        assert report.filled_holes == 0
        given = nm.DepthOptions(values="distance", fill="4px")
        assert nm.depth_to_normals(floats(np.where(spot, nothing, heights)), given).report.filled_holes == 1
    transparent = nm.RasterImage(np.dstack([heights, ~spot]).astype(np.float32), ("Y", "A"), bits=32)
    for either in (options, given):
        assert not nm.depth_to_normals(transparent, either).normal_map.coverage[30, 40]
        masked = nm.depth_to_normals(floats(np.where(spot, 0, heights)), either, mask=~spot)
        assert masked.report.filled_holes == 0
    edge = np.where((x < 2) & (y > 40) & (y < 43), 0, heights)
    assert nm.depth_to_normals(floats(edge), options).report.filled_holes == 0
    own = floats(np.where(spot, np.nan, heights), depth_facts=nm.DepthFacts("height"), attributes={"pitch_mm": "1"})
    assert nm.depth_to_normals(own).report.filled_holes == 0


def test_a_hole_that_takes_too_long_is_left_or_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("nmaptool.depth.fill.MOST_PIXELS", 30)
    monkeypatch.setattr("nmaptool.depth.source.MOST_PIXELS", 30)
    y, x = np.mgrid[:80, :200]
    long = (np.abs(y - 20) < 2) & (np.abs(x - 40) < 10)
    small = (np.abs(y - 60) < 2) & (np.abs(x - 40) < 2)
    image = floats(np.where(long | small, np.nan, 60 + 0.1 * x), name="d.npy")
    result = nm.depth_to_normals(image)
    assert (result.report.filled_holes, result.report.filled_pixels) == (1, 9)
    assert not result.normal_map.coverage[long].any()
    message = r"`fill='6px'`: a hole of d\.npy has 57 pixels; at most 30 are filled; give a smaller `fill`"
    with pytest.raises(nm.LimitError, match=message):
        nm.depth_to_normals(image, nm.DepthOptions(fill="6px"))


def test_a_named_value_beyond_floats_is_infinite() -> None:
    image = floats(holed(SCENE.mm, -np.inf), nodata=-1.7976931348623157e308)
    assert nm.depth_to_normals(image).report.empty == {"infinite": np.count_nonzero(HOLE)}
    assert nm.depth_to_normals(codes(SCENE.mm, 16, nodata=-9999.0)).report.empty == {}
