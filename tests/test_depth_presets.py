"""Each preset reads what its program writes: a sphere and a bust, encoded in the same way, give the true slopes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from depth_scenes import FOCAL, FOV, SCENES, WRITERS, Scene, Writer, bust, codes, floats, gradients, sphere, stretched

import nmaptool as nm
from nmaptool.options.presets import DEPTH_PRESETS


def slopes(result: nm.DepthResult) -> Any:
    n = result.normal_map.normals.astype(float)
    return -n[..., :2] / n[..., 2:]


def agreement(result: nm.DepthResult, true: Any, inside: Any) -> tuple[float, float]:
    """Correlation and gain of slopes."""
    inside = inside & (result.normal_map.coverage > 0)
    found, true = slopes(result)[inside].ravel(), true[inside].ravel()
    return float(np.corrcoef(found, true)[0, 1]), float((found * true).sum() / (true * true).sum())


def test_every_preset_is_tested() -> None:
    assert {writer.preset for writer in WRITERS.values()} | {"dem"} == set(DEPTH_PRESETS)


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("name", WRITERS)
def test_a_preset_reads_what_its_program_writes(name: str, scene: str) -> None:
    writer: Writer = WRITERS[name]
    truth: Scene = SCENES[scene]()
    options = nm.DepthOptions(from_=writer.preset, fov=FOV if writer.metric else None)
    result = nm.depth_to_normals(writer.write(truth), options)
    report = result.report
    correlation, gain = agreement(result, truth.slopes, truth.inside)
    assert correlation > 0.999
    assert (report.preset, report.preset_from) == (writer.preset, "given")
    assert (report.values, report.values_from) == (DEPTH_PRESETS[writer.preset].values, "preset")
    assert report.warnings == ()
    if writer.metric:
        known = truth.mm[truth.mask] if writer.empties else truth.mm
        assert gain == pytest.approx(1, abs=1e-3 if report.bits == 32 else 0.01)
        assert (report.scale_from, report.unit_from, report.pitch_from) == ("unit", "preset", "depth")
        assert report.distance_mm == pytest.approx(np.median(known), rel=2e-3)
        assert result.normal_map.frame.pitch_mm == pytest.approx(np.median(known) / FOCAL, rel=2e-3)
    else:
        assert report.pitch_mm is None
        assert report.scale_from == "assumed"
        assert report.scale_px == pytest.approx(20)
    if writer.empties:
        np.testing.assert_array_equal(result.normal_map.coverage > 0, truth.mask)
        assert report.background == "empty"


def test_heights_of_an_elevation_model_are_real_lengths() -> None:
    x, y = np.meshgrid(np.arange(120), np.arange(90))
    metres = 700 + 40 * np.sin(x / 15) * np.cos(y / 12)
    holed = np.where((x > 30) & (x < 55) & (y > 20) & (y < 50), -9999.0, metres)
    image = floats(holed, nodata=-9999.0)
    result = nm.depth_to_normals(image, nm.DepthOptions(from_="dem", width="1200m"))
    correlation, gain = agreement(result, gradients(metres / 10), (holed > 0) & (x > 60))
    assert correlation > 0.9999
    assert gain == pytest.approx(1, abs=1e-3)
    assert result.report.empty == {"-9999": np.count_nonzero(holed < 0)}
    assert result.normal_map.frame.pitch_mm == pytest.approx(10_000)
    np.testing.assert_array_equal(result.normal_map.coverage > 0, holed > 0)


def test_relative_disparities_are_exact_only_at_a_distance() -> None:
    near, far = bust(900, 300), bust(6000, 300)
    results = [nm.depth_to_normals(floats(1 / s.mm), nm.DepthOptions(from_="midas")) for s in (near, far)]
    close, distant = (agreement(r, s.slopes, s.inside)[0] for r, s in zip(results, (near, far), strict=True))
    assert distant > 0.9999
    assert 0.99 < close < 0.998
    absolute = nm.depth_to_normals(floats(1000 / near.mm), nm.DepthOptions(from_="iphone", fov=FOV))
    assert agreement(absolute, near.slopes, near.inside)[0] > 0.99999


def test_eight_bits_suffice_for_a_motif_before_a_far_wall() -> None:
    scene = bust(2000, 300)
    image = codes(stretched(1 / np.where(scene.mask, scene.mm, scene.mm + 4000), 255), 8)
    assert np.ptp(image.pixels[scene.mask].astype(int)) < 50  # codes for the motif
    result = nm.depth_to_normals(image, nm.DepthOptions(from_="depth-anything"))
    assert agreement(result, scene.slopes, scene.inside)[0] > 0.999


def test_given_options_override_a_preset() -> None:
    scene = sphere()
    image = codes(np.where(scene.mask, np.round(10 * scene.mm), 0), 16)
    plain = nm.DepthOptions(from_="realsense", fov=FOV)
    given = nm.DepthOptions(from_="realsense", fov=FOV, unit="0.1mm")
    tenth, whole = (nm.depth_to_normals(image, options) for options in (given, plain))
    assert (tenth.report.unit, tenth.report.unit_from) == ("0.1mm", "given")
    assert tenth.report.distance_mm == pytest.approx(np.median(scene.mm[scene.mask]), rel=1e-3)
    assert whole.report.pitch_mm == pytest.approx(10 * tenth.report.pitch_mm)
    assert agreement(tenth, scene.slopes, scene.inside)[1] == pytest.approx(1, abs=3e-3)
    scaled = nm.depth_to_normals(image, nm.DepthOptions(from_="realsense", depth_scale="80px"))
    assert (scaled.report.scale_from, scaled.report.unit) == ("given", None)
    bright = nm.depth_to_normals(
        codes(255 - stretched(scene.mm, 255), 8), nm.DepthOptions(from_="marigold", values="height")
    )
    assert (bright.report.values, bright.report.values_from, bright.report.inverted) == ("height", "given", False)
    kept = nm.depth_to_normals(image, nm.DepthOptions(from_="realsense", empty="none", background="none"))
    assert kept.report.empty == {}
    assert kept.normal_map.coverage.all()


def test_blender_is_recognised_by_its_value_for_nothing() -> None:
    scene = sphere()
    values = np.where(scene.mask, scene.mm / 1000, 1e10)
    for layer in ("ViewLayer.Depth.Z", "Depth", None):
        result = nm.depth_to_normals(floats(values, layer=layer), nm.DepthOptions(fov=FOV))
        report = result.report
        assert (report.preset, report.preset_from, report.values, report.values_from) == (
            "blender",
            "found",
            "distance",
            "found",
        )
        assert report.unit is None  # the unit of a scene is not certain
        assert agreement(result, scene.slopes, scene.inside)[0] > 0.99999
    for other in (values * 2, np.where(scene.mask, scene.mm, np.inf)):
        grey = nm.depth_to_normals(floats(other)).report
        assert (grey.preset, grey.values, grey.inverted) == ("", "height", False)


def test_a_layer_called_depth_or_z_holds_distances() -> None:
    scene = bust()
    channel = nm.RasterImage(scene.mm.astype(np.float32)[..., None], ("Z",), bits=32)
    for image in (channel, floats(scene.mm, layer="depth"), floats(scene.mm, layer="cam1.Z")):
        report = nm.depth_to_normals(image).report
        assert (report.values, report.values_from, report.inverted_from) == ("distance", "found", "found")
        assert report.inverted
        kept = nm.depth_to_normals(image, nm.DepthOptions(values="height")).report
        assert (kept.inverted, kept.inverted_from) == (False, "given")
    for image in (floats(scene.mm, layer="height"), floats(scene.mm, layer="depths")):
        assert nm.depth_to_normals(image).report.values == "height"


@pytest.mark.parametrize("bits", [8, 16, 32])
def test_distance_is_the_same_as_invert(bits: int) -> None:
    values = stretched(bust().mm, 1 if bits == 32 else 2**bits - 1)
    image = floats(values) if bits == 32 else codes(values, bits)
    one, two = (
        nm.depth_to_normals(image, o) for o in (nm.DepthOptions(invert=True), nm.DepthOptions(values="distance"))
    )
    np.testing.assert_allclose(slopes(two), slopes(one), atol=2e-3)
    assert one.report.values == two.report.values == "distance"


def test_codes_of_a_camera_are_distances_from_it_without_a_unit() -> None:
    scene = sphere()
    image = codes(np.where(scene.mask, np.round(scene.mm * 3), 0), 16)
    result = nm.depth_to_normals(image, nm.DepthOptions(values="distance", fov=FOV))
    assert agreement(result, scene.slopes, scene.inside)[1] == pytest.approx(1, abs=2e-3)
    assert result.report.pitch_mm is None
