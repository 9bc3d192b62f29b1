"""A sphere in front of a plane: the outline tilts neither of them."""

from __future__ import annotations

import numpy as np
import pytest
from depth_cases import angles, ball, coded

import nmaptool as nm

# A pixel that both share almost evenly may fall to either; where the sphere rises more than STEEP px a px, it rises by
# as much again within that pixel, and no grid tells which way exactly.
UNDECIDED = (0.4, 0.6)
STEEP = 3.0


def errors(bits: int, radius: float, over: int, side: int = 192) -> tuple[np.ndarray, np.ndarray, object]:
    """Angles to the normals of sphere and plane, and which pixels the sphere's slope is told apart on."""
    scene = ball(side, radius, radius, over)
    image, scale = coded(scene.heights, bits)
    result = nm.depth_to_normals(image, nm.DepthOptions(depth_scale=scale, background="none"))
    true = np.where(scene.inside[..., None], scene.normals, (0.0, 0.0, 1.0))
    off = angles(result.normal_map.normals, true)
    off[(scene.cover > UNDECIDED[0]) & (scene.cover < UNDECIDED[1])] = 0
    return off, scene.inside & (scene.slope > STEEP), result


@pytest.mark.parametrize("bits", [8, 16, 32])
@pytest.mark.parametrize("over", [1, 8], ids=["crisp", "smoothed"])
def test_no_pixel_of_an_outline_is_tilted(bits: int, over: int) -> None:
    off, grazing, result = errors(bits, 60.0, over)
    assert off[~grazing].max() < 5
    # even where it grazes, a normal turns to its own side: it is never a mixture with the plane's
    assert off[grazing].max() < 25
    assert result.report.mixed_pixels > 100 if over > 1 else result.report.mixed_pixels <= 4


@pytest.mark.parametrize("bits", [8, 16, 32])
@pytest.mark.parametrize("over", [1, 8], ids=["crisp", "smoothed"])
def test_the_plane_stays_a_plane(bits: int, over: int) -> None:
    scene = ball(192, 60.0, 60.0, over)
    image, scale = coded(scene.heights, bits)
    result = nm.depth_to_normals(image, nm.DepthOptions(depth_scale=scale, background="none"))
    plane = scene.cover < UNDECIDED[0]
    assert angles(result.normal_map.normals, (0.0, 0.0, 1.0))[plane].max() < 1


def test_jumps_are_beside_the_outline_only_and_have_its_height() -> None:
    scene = ball(192, 60.0, 60.0)
    image, scale = coded(scene.heights, 16)
    jumps = nm.depth_to_normals(image, nm.DepthOptions(depth_scale=scale)).jumps
    beside = np.zeros(jumps.shape, bool)
    for axis in (0, 1):
        change = np.diff(scene.inside, axis=axis)
        beside |= np.insert(change, 0, False, axis=axis) | np.insert(change, change.shape[axis], False, axis=axis)
    np.testing.assert_array_equal(jumps > 0, beside)
    assert jumps[beside].min() >= 60


def test_without_jumps_the_plane_is_torn_up() -> None:
    scene = ball(192, 60.0, 60.0)
    image, scale = coded(scene.heights, 16)
    result = nm.depth_to_normals(image, nm.DepthOptions(depth_scale=scale, jump="none", background="none"))
    off = angles(result.normal_map.normals, (0.0, 0.0, 1.0))[~scene.inside]
    assert off.max() > 80
    assert result.report.jump_px is None
    assert not result.jumps.any()


def test_a_jump_by_hand_is_a_height() -> None:
    x = np.arange(64) - 32.0
    steps = np.where(x < -10, 0.0, np.where(x < 10, 3.0, 8.0))
    heights = np.tile(steps, (64, 1))
    image, scale = coded(heights, 32)
    few = nm.depth_to_normals(image, nm.DepthOptions(depth_scale=scale, jump="4px", background="none"))
    assert set(np.nonzero(few.jumps)[1]) == {41, 42}
    both = nm.depth_to_normals(image, nm.DepthOptions(depth_scale=scale, jump="2px", background="none"))
    assert set(np.nonzero(both.jumps)[1]) == {21, 22, 41, 42}
    assert angles(both.normal_map.normals, (0.0, 0.0, 1.0)).max() == 0


def test_a_motif_of_one_pixel_has_a_jump_all_around() -> None:
    heights = np.zeros((32, 32))
    heights[10, 12] = 20
    image, scale = coded(heights, 32)
    result = nm.depth_to_normals(image, nm.DepthOptions(depth_scale=scale, background="none"))
    assert np.count_nonzero(result.jumps) in (0, 5)
    assert np.isfinite(result.normal_map.normals).all()


@pytest.mark.parametrize("width", [5.0, 8.0, 20.0])
@pytest.mark.parametrize("height", [10.0, 40.0])
@pytest.mark.parametrize("angle", [0.0, 27.0, 45.0])
def test_steep_but_continuous_cliffs_are_no_jumps(width: float, height: float, angle: float) -> None:
    y, x = np.mgrid[:96, :96] - 48.0
    along = x * np.cos(np.radians(angle)) + y * np.sin(np.radians(angle))
    ramp = height * np.clip(along / width + 0.5, 0, 1)
    smooth = height / (1 + np.exp(-along * 4 / width))
    for heights in (ramp, smooth):
        image, scale = coded(heights, 32)
        result = nm.depth_to_normals(image, nm.DepthOptions(depth_scale=scale, background="none"))
        assert result.report.jumps == 0
        # the cliff's whole height is in the slopes, rows across it
        p = -result.normal_map.normals[..., 0] / result.normal_map.normals[..., 2]
        if angle == 0:
            np.testing.assert_allclose(p.sum(axis=1), heights[:, -1] - heights[:, 0], rtol=0.02, atol=0.05)


def test_a_crease_is_no_jump() -> None:
    y, x = np.mgrid[:64, :64] - 32.0
    for heights in (3 * np.abs(x + 0.3 * y), 5 * np.maximum(x, 0), np.minimum(2 * np.abs(x), np.abs(y))):
        image, scale = coded(heights, 32)
        assert nm.depth_to_normals(image, nm.DepthOptions(depth_scale=scale, background="none")).report.jumps == 0
