"""A sphere in front of a plane: neither is tilted along the outline."""

from __future__ import annotations

import numpy as np
import pytest
from depth_cases import Ball, angles, ball, coded, grid, normals_of_slopes

import nmaptool as nm

# A smoothed pixel that both cover almost equally may be assigned to either, but always to one of them.
UNDECIDED = (0.4, 0.6)
SMOOTHED = pytest.mark.parametrize("over", [1, 8], ids=["crisp", "smoothed"])
UP = (0.0, 0.0, 1.0)


def from_picture(scene: Ball, bits: int) -> nm.DepthResult:
    image, scale = coded(scene.heights, bits)
    return nm.depth_to_normals(image, nm.DepthOptions(depth_scale=scale, background="none"))


def errors(scene: Ball, result: nm.DepthResult) -> np.ndarray:
    """Angle in degrees between each pixel's normal and that of its own surface, sphere or plane."""
    normals = result.normal_map.normals
    sphere, plane = angles(normals, scene.normals), angles(normals, UP)
    either = (scene.cover > UNDECIDED[0]) & (scene.cover < UNDECIDED[1])
    return np.where(either, np.minimum(sphere, plane), np.where(scene.inside, sphere, plane))


@SMOOTHED
@pytest.mark.parametrize("bits", [16, 32])
@pytest.mark.parametrize("radius", [12.0, 30.0, 60.0, 100.0])
def test_no_pixel_of_an_outline_is_tilted(bits: int, over: int, radius: float) -> None:
    scene = ball(int(2 * radius) + 40, radius, radius, over)
    result = from_picture(scene, bits)
    assert errors(scene, result).max() < 2.5
    assert (result.report.mixed_pixels > 5 * radius) == (over > 1)


@SMOOTHED
@pytest.mark.parametrize(("radius", "most"), [(30.0, 7.5), (60.0, 5.0), (100.0, 5.0)])
def test_no_pixel_of_an_outline_is_tilted_in_8_bits(radius: float, most: float, over: int) -> None:
    # one code is 0.24 to 0.78 px high
    scene = ball(int(2 * radius) + 40, radius, radius, over)
    off = errors(scene, from_picture(scene, 8))
    assert off.max() < most
    assert np.mean(off[scene.inside & (scene.slope > 3)] > 5) < 0.07


@SMOOTHED
@pytest.mark.parametrize("bits", [8, 16, 32])
def test_the_plane_stays_flat(bits: int, over: int) -> None:
    scene = ball(192, 60.0, 60.0, over)
    plane = scene.cover < UNDECIDED[0]
    assert angles(from_picture(scene, bits).normal_map.normals, UP)[plane].max() < 1


@pytest.mark.parametrize("bits", [8, 32])
def test_a_terrace_ends_flat(bits: int) -> None:
    x, y = grid(96, 96)
    heights = np.where(np.abs(x) + 0.4 * np.abs(y) < 30, 40.0, 0.0) + np.where(np.hypot(x, y) < 12.3, 25.0, 0.0)
    image, scale = coded(heights, bits)
    result = nm.depth_to_normals(image, nm.DepthOptions(depth_scale=scale, background="none"))
    assert result.report.jumps > 300
    assert angles(result.normal_map.normals, UP).max() < 0.1


def test_a_narrow_chamfer_at_an_outline_is_not_flattened() -> None:
    x, _ = grid(64, 64)
    chamfer, inside = 3, np.abs(x) < 20
    heights = np.where(inside, 40 + np.minimum(20 - np.abs(x), chamfer), 0.0)
    image, scale = coded(heights, 32)
    result = nm.depth_to_normals(image, nm.DepthOptions(depth_scale=scale, background="none"))
    p = np.where(inside & (20 - np.abs(x) < chamfer - 1), -np.sign(x), 0.0)
    known = (np.abs(x) > 18) | (np.abs(x) < 15)  # excludes the crease itself, where both sides meet
    assert angles(result.normal_map.normals, normals_of_slopes(p, 0 * p))[known].max() < 8


@pytest.mark.parametrize("width", [3, 5, 7])
def test_a_thin_round_stem_is_round(width: int) -> None:
    x, _ = grid(64, 64)
    x = x + 0.5 * (width % 2)
    radius = width / 2 + 0.5
    heights = np.where(np.abs(x) < width / 2, 20 + np.sqrt(np.maximum(radius**2 - x**2, 0)), 0.0)
    image, scale = coded(heights, 32)
    normals = nm.depth_to_normals(image, nm.DepthOptions(depth_scale=scale, background="none")).normal_map.normals
    stem = np.abs(x) < width / 2
    true = normals_of_slopes(-x / np.sqrt(np.maximum(radius**2 - x**2, 1e-3)), 0 * x)
    assert np.abs(normals[..., 1]).max() < 1e-3
    assert (normals[..., 0] * np.sign(x))[stem & (np.abs(x) > 0.9)].min() > 0.1
    assert angles(normals, true)[stem].mean() < 20


def test_jumps_lie_only_along_the_outline_and_have_its_height() -> None:
    scene = ball(192, 60.0, 60.0)
    image, scale = coded(scene.heights, 16)
    jumps = nm.depth_to_normals(image, nm.DepthOptions(depth_scale=scale)).jumps
    beside = np.zeros(jumps.shape, bool)
    for axis in (0, 1):
        change = np.diff(scene.inside, axis=axis)
        beside |= np.insert(change, 0, False, axis=axis) | np.insert(change, change.shape[axis], False, axis=axis)
    np.testing.assert_array_equal(jumps > 0, beside)
    assert jumps[beside].min() >= 60


def test_without_jumps_the_plane_is_distorted() -> None:
    scene = ball(192, 60.0, 60.0)
    image, scale = coded(scene.heights, 16)
    result = nm.depth_to_normals(image, nm.DepthOptions(depth_scale=scale, jump="none", background="none"))
    off = angles(result.normal_map.normals, (0.0, 0.0, 1.0))[~scene.inside]
    assert off.max() > 80
    assert result.report.jump_px is None
    assert not result.jumps.any()


def test_a_given_jump_is_a_height() -> None:
    x = np.arange(64) - 32.0
    steps = np.where(x < -10, 0.0, np.where(x < 10, 3.0, 8.0))
    heights = np.tile(steps, (64, 1))
    image, scale = coded(heights, 32)
    few = nm.depth_to_normals(image, nm.DepthOptions(depth_scale=scale, jump="4px", background="none"))
    assert set(np.nonzero(few.jumps)[1]) == {41, 42}
    both = nm.depth_to_normals(image, nm.DepthOptions(depth_scale=scale, jump="2px", background="none"))
    assert set(np.nonzero(both.jumps)[1]) == {21, 22, 41, 42}
    assert angles(both.normal_map.normals, (0.0, 0.0, 1.0)).max() == 0


def test_a_motif_of_one_pixel_has_jumps_all_around_or_none() -> None:
    heights = np.zeros((32, 32))
    heights[10, 12] = 20
    image, scale = coded(heights, 32)
    result = nm.depth_to_normals(image, nm.DepthOptions(depth_scale=scale, background="none"))
    assert np.count_nonzero(result.jumps) in (0, 5)
    assert np.isfinite(result.normal_map.normals).all()


@pytest.mark.parametrize("width", [5.0, 8.0, 20.0])
@pytest.mark.parametrize("height", [10.0, 40.0])
@pytest.mark.parametrize("angle", [0.0, 27.0, 45.0])
def test_steep_but_continuous_cliffs_are_not_jumps(width: float, height: float, angle: float) -> None:
    y, x = np.mgrid[:96, :96] - 48.0
    along = x * np.cos(np.radians(angle)) + y * np.sin(np.radians(angle))
    ramp = height * np.clip(along / width + 0.5, 0, 1)
    smooth = height / (1 + np.exp(-along * 4 / width))
    for heights in (ramp, smooth):
        image, scale = coded(heights, 32)
        result = nm.depth_to_normals(image, nm.DepthOptions(depth_scale=scale, background="none"))
        assert result.report.jumps == 0
        # summed across the cliff, the slopes give its full height
        p = -result.normal_map.normals[..., 0] / result.normal_map.normals[..., 2]
        if angle == 0:
            np.testing.assert_allclose(p.sum(axis=1), heights[:, -1] - heights[:, 0], rtol=0.02, atol=0.05)


def test_a_crease_is_not_a_jump() -> None:
    y, x = np.mgrid[:64, :64] - 32.0
    for heights in (3 * np.abs(x + 0.3 * y), 5 * np.maximum(x, 0), np.minimum(2 * np.abs(x), np.abs(y))):
        image, scale = coded(heights, 32)
        assert nm.depth_to_normals(image, nm.DepthOptions(depth_scale=scale, background="none")).report.jumps == 0
