"""Errors of depth_to_normals and its options, each in one clear line."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from depth_cases import picture

import nmaptool as nm

RAMP = np.tile(np.linspace(0, 255, 40), (30, 1))


def colored(apart: float) -> nm.RasterImage:
    rgb = np.dstack([RAMP, np.clip(RAMP + apart, 0, 255), RAMP])
    return nm.RasterImage(rgb.astype(np.uint8), ("R", "G", "B"), name="photo.jpg", lossy=True)


@pytest.mark.parametrize(
    ("given", "pattern"),
    [
        ({"jump": "high"}, r"`jump='high'`: use auto, none or a height, such as 2px"),
        ({"smooth": "-1px"}, r"`smooth='-1px'`: use auto, none or a height"),
        ({"background": "white"}, r"`background='white'`: use one of auto, flat, none"),
        ({"fov": 170}, r"`fov=170`: must lie between 0\.1 and 150"),
        ({"fov": -5}, r"`fov=-5`: must lie between"),
        ({"fov": float("nan")}, r"`fov=nan`: must lie between 0\.1 and 150, such as 35 \(0 is orthographic\)"),
        ({"width": "300px"}, r"`width='300px'`: .* give it in mm, cm, m or in"),
        ({"depth_scale": "5"}, r"`depth_scale='5'`: expected a number with a unit"),
        ({"depth_scale": "0px"}, r"`depth_scale='0px'`: must be greater than zero"),
    ],
)
def test_invalid_options_are_refused(given: dict[str, Any], pattern: str) -> None:
    with pytest.raises(nm.UsageError, match=pattern):
        nm.DepthOptions(**given)


@pytest.mark.parametrize("flag", ["depth_scale", "jump", "smooth"])
def test_mm_need_a_pitch(flag: str) -> None:
    pattern = rf"`{flag}='2mm'`: the size of a pixel in image is not known; give px or %, or the `width` of the picture"
    with pytest.raises(nm.UsageError, match=pattern):
        nm.depth_to_normals(picture(RAMP, 8), nm.DepthOptions(**{flag: "2mm"}))


def test_a_colour_image_is_refused_and_a_nearly_grey_one_is_accepted() -> None:
    with pytest.raises(nm.InputError, match=r"photo\.jpg: is a colour picture, but depth and height pictures are grey"):
        nm.depth_to_normals(colored(30))
    noisy = nm.depth_to_normals(colored(3))
    assert "the colour channels differ slightly" in noisy.report.warnings[0]
    exact = nm.depth_to_normals(colored(0))
    assert exact.report.warnings == ()
    grey = nm.depth_to_normals(nm.RasterImage(RAMP.astype(np.uint8)[..., None], ("Y",), lossy=True))
    np.testing.assert_array_equal(exact.normal_map.normals, grey.normal_map.normals)


def test_wrong_channels_are_refused() -> None:
    odd = nm.RasterImage(np.zeros((4, 4, 2), np.float32), ("Z", "ZBack"), name="deep.exr", bits=32)
    with pytest.raises(
        nm.InputError, match=r"deep\.exr: has the channels Z, ZBack, but a depth picture has one grey channel"
    ):
        nm.depth_to_normals(odd)


def test_grey_in_three_channels_may_hold_any_float() -> None:
    values = RAMP.astype(np.float32)
    values[2:5, 3], values[7, 7], values[9, 9] = np.nan, np.inf, -np.inf
    grey = nm.depth_to_normals(picture(values))
    stored = nm.RasterImage(np.repeat(values[..., None], 3, axis=2), ("R", "G", "B"), bits=32)
    same = nm.depth_to_normals(stored)
    assert same.report.warnings == grey.report.warnings == ()
    np.testing.assert_array_equal(same.normal_map.normals, grey.normal_map.normals)
    nearly = stored.pixels.copy()
    nearly[..., 1] += np.float32(1e-3)
    rounded = nm.depth_to_normals(nm.RasterImage(nearly, ("R", "G", "B"), bits=32))
    assert "the colour channels differ slightly" in rounded.report.warnings[0]
    assert rounded.report.empty == grey.report.empty


def test_values_that_no_length_can_have_are_refused_or_equal() -> None:
    with pytest.raises(nm.InputError, match=r"far\.npy: has heights of .* px, which cannot be computed with; give the"):
        nm.depth_to_normals(picture(RAMP * 1e26, name="far.npy"), nm.DepthOptions(unit="1m", width="1mm"))
    tiny = nm.depth_to_normals(picture(RAMP * 1e-42))
    assert np.ptp(tiny.normal_map.normals[..., 2]) == 0
    near = nm.depth_to_normals(picture(RAMP * 1e-42 + 1), nm.DepthOptions(values="disparity", unit="1m", fov=40))
    assert np.ptp(near.normal_map.normals[..., 2]) == 0
    with pytest.raises(nm.InputError, match="greater than 0; check that this is the depth picture"):
        nm.depth_to_normals(picture(RAMP * 1e-42), nm.DepthOptions(values="disparity", unit="1m", fov=40))


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_an_image_without_any_depth_is_refused(value: float) -> None:
    with pytest.raises(nm.InputError, match="no pixel has a depth: all are transparent, NaN or infinite"):
        nm.depth_to_normals(picture(np.full((8, 8), value)))
    with pytest.raises(nm.InputError, match="no pixel has a depth greater than 0"):
        nm.depth_to_normals(picture(np.zeros((8, 8))), nm.DepthOptions(invert=True))


def test_options_that_contradict_the_file_are_refused() -> None:
    height = picture(RAMP, name="h.exr", attributes={"kind": "height", "pitch_mm": "0.5"})
    with pytest.raises(
        nm.UsageError, match=r"`invert`: h\.exr declares that it holds height, which fixes the direction; leave it out"
    ):
        nm.depth_to_normals(height, nm.DepthOptions(invert=True))
    contradictions = {"from_": "blender", "values": "distance", "unit": "1mm"}
    for name, value in contradictions.items():
        fixed = "scale" if name == "unit" else "direction"
        with pytest.raises(
            nm.UsageError, match=rf"`{name}='{value}'`: h\.exr declares .* fixes the {fixed}; leave it out"
        ):
            nm.depth_to_normals(height, nm.DepthOptions(**{name: value}))
    assert nm.depth_to_normals(height, nm.DepthOptions(values="height")).report.values_from == "file"
    with pytest.raises(nm.UsageError, match=r"`fov`: h\.exr holds heights, which have no perspective; leave it out"):
        nm.depth_to_normals(height, nm.DepthOptions(fov=40))
    unknown = picture(RAMP, name="h.exr", attributes={"kind": "height"})
    with pytest.raises(
        nm.UsageError, match=r"h\.exr: holds height in mm, but the size of a pixel is not known; give the `width`"
    ):
        nm.depth_to_normals(unknown)
    for ends in ({}, {"near_mm": "1", "far_mm": "far"}, {"near_mm": "nan", "far_mm": "2"}):
        damaged = picture(RAMP, 8, name="d.png", attributes={"kind": "depth", "pitch_mm": "1", **ends})
        with pytest.raises(nm.InputError, match=r"d\.png: declares that it holds depth, but not its range"):
            nm.depth_to_normals(damaged)


def test_impossible_cameras_are_refused() -> None:
    with pytest.raises(nm.UsageError, match="`depth_scale`: white is 100 px in front of black, but with `fov="):
        nm.depth_to_normals(picture(RAMP, 8), nm.DepthOptions(depth_scale="100px", fov=90))
    depth = picture(RAMP - 10, name="d.exr", attributes={"kind": "depth", "pitch_mm": "1"})
    with pytest.raises(
        nm.InputError, match=r"d\.exr: has a depth of -10; with `fov`, depths are distances from the eye"
    ):
        nm.depth_to_normals(depth, nm.DepthOptions(fov=40, background="none"))


def test_negative_distances_are_heights() -> None:
    with pytest.raises(
        nm.InputError, match="greater than 0; read negative distances as heights, with `values='height'`"
    ):
        nm.depth_to_normals(picture(-1 - RAMP), nm.DepthOptions(values="distance"))


def test_wrong_masks_are_refused() -> None:
    image = picture(RAMP, 8)
    with pytest.raises(nm.InputError, match="image is 40 x 30 pixels but the mask is 4 x 3; make them the same size"):
        nm.depth_to_normals(image, mask=np.ones((3, 4), np.float32))
    with pytest.raises(nm.InputError, match="the mask selects no part of the picture"):
        nm.depth_to_normals(image, mask=np.zeros((30, 40), np.float32))
    with pytest.raises(nm.InputError, match="the mask must hold values from 0 to 1"):
        nm.depth_to_normals(image, mask=np.full((30, 40), 255, np.float32))


def test_a_path_instead_of_an_image_is_refused() -> None:
    with pytest.raises(nm.UsageError, match="must be a RasterImage, found str; read one with read_raster"):
        nm.depth_to_normals("depth.png")  # type: ignore[arg-type]
