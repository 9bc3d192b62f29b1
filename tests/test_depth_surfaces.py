"""Slopes of continuous surfaces: ramps, bowls and detail, from stepped, noisy and clean codes."""

from __future__ import annotations

import numpy as np
import pytest
from depth_cases import angles, coded, grid, normals_of_slopes, picture

import nmaptool as nm

SIDE = 192
STEP = 0.2


def fitted(codes: np.ndarray, step: float = STEP, **more: object) -> nm.DepthResult:
    """Normals fitted to 8-bit codes that are ``step`` px high each."""
    options = nm.DepthOptions(depth_scale=f"{255 * step}px", background="none", **more)
    return nm.depth_to_normals(picture(codes, 8), options)


@pytest.mark.parametrize("angle", [0, 10, 45, 80, 200])
@pytest.mark.parametrize("slope", [0.01, 0.03, 0.1, 0.25, 1 / 3, 0.5, 0.77, 1.0])
def test_stepped_ramps_give_the_normal_of_the_ramp(slope: float, angle: int) -> None:
    x, y = grid(SIDE, SIDE)
    p, q = slope * np.cos(np.radians(angle)), slope * np.sin(np.radians(angle))
    result = fitted(128 + p * x + q * y if slope < 0.9 else 127.5 + 0.9 * (p * x + q * y))
    scale = STEP if slope < 0.9 else 0.9 * STEP
    assert angles(result.normal_map.normals, normals_of_slopes(p * scale, q * scale)).max() < 1
    assert result.report.jumps == 0


@pytest.mark.parametrize("slope", [1.5, 2.3, 4.0])
def test_stepped_ramps_of_several_codes_per_pixel_give_the_normal(slope: float) -> None:
    x, y = grid(48, 48)
    p, q = slope * np.cos(0.4), slope * np.sin(0.4)
    result = fitted(127.5 + p * x + q * y)
    assert angles(result.normal_map.normals, normals_of_slopes(p * STEP, q * STEP)).max() < 1


@pytest.mark.parametrize("slope", [0.0, 0.05, 0.3, 0.8])
def test_noisy_ramps_are_smoothed(slope: float) -> None:
    x, y = grid(SIDE, SIDE)
    noise = np.random.default_rng(4).normal(0, 1.2, x.shape)
    result = fitted(127.5 + slope * (0.8 * x + 0.6 * y) + noise)
    off = angles(result.normal_map.normals, normals_of_slopes(0.8 * slope * STEP, 0.6 * slope * STEP))
    assert np.mean(off) < 1.5  # plain differences would be off by 9 degrees
    assert result.report.noise_px == pytest.approx(1.2 * STEP, rel=0.15)
    assert result.report.jumps == 0


@pytest.mark.parametrize("quality", [75, 90])
@pytest.mark.parametrize("slope", [0.05, 0.3, 0.8])
def test_compressed_ramps_are_smoothed(slope: float, quality: int) -> None:
    import cv2

    x, y = grid(SIDE, SIDE)
    exact = np.floor(128 + slope * (0.8 * x + 0.6 * y)).astype(np.uint8)
    codes = cv2.imdecode(cv2.imencode(".jpg", exact, [cv2.IMWRITE_JPEG_QUALITY, quality])[1], -1)
    image = picture(codes, 8, lossy=True)
    options = nm.DepthOptions(depth_scale=f"{255 * STEP}px", background="none")
    result = nm.depth_to_normals(image, options)
    off = angles(result.normal_map.normals, normals_of_slopes(0.8 * slope * STEP, 0.6 * slope * STEP))
    assert off.max() < 2.5
    assert np.mean(off) < 0.5


QUADRATICS = {
    "dome": (lambda x, y: -(x**2 + y**2) / 400, lambda x, y: (-x / 200, -y / 200)),
    "trough": (lambda x, y: x**2 / 400 + 0.1 * y, lambda x, y: (x / 200, 0.1 + 0 * y)),
    "saddle": (lambda x, y: x * y / 400, lambda x, y: (y / 400, x / 400)),
}


@pytest.mark.parametrize("name", QUADRATICS)
def test_stepped_quadratics_give_the_slopes_of_the_surface(name: str) -> None:
    x, y = grid(SIDE, SIDE)
    height, slope = QUADRATICS[name]
    z = height(x, y)
    z -= z.min()
    result = fitted(z / STEP)
    off = angles(result.normal_map.normals, normals_of_slopes(*slope(x, y)))
    assert np.mean(off) < 0.6
    assert off.max() < 2
    raw = angles(fitted(z / STEP, smooth="none").normal_map.normals, normals_of_slopes(*slope(x, y)))
    assert np.mean(raw) > 4 * np.mean(off)


@pytest.mark.parametrize("bits", [16, 32])
@pytest.mark.parametrize("name", QUADRATICS)
def test_clean_quadratics_are_exact(name: str, bits: int) -> None:
    x, y = grid(SIDE, SIDE)
    height, slope = QUADRATICS[name]
    z = height(x, y) - height(x, y).min()
    image, scale = coded(z, bits)
    result = nm.depth_to_normals(image, nm.DepthOptions(depth_scale=scale, background="none"))
    inner = (slice(2, -2), slice(2, -2))
    assert angles(result.normal_map.normals, normals_of_slopes(*slope(x, y)))[inner].max() < 0.15
    assert result.report.tolerance_px == 0


@pytest.mark.parametrize("bits", [16, 32])
@pytest.mark.parametrize(("wavelength", "kept"), [(5, 0.93), (6, 0.96), (8, 0.985), (16, 0.995)])
def test_fine_detail_is_kept(wavelength: int, kept: float, bits: int) -> None:
    x, y = grid(SIDE, SIDE)
    wave = 2 * np.pi / wavelength
    z = 20 + 0.15 * x + 0.4 * np.sin(wave * x) * np.cos(0.1 * y)
    image, scale = coded(z - z.min(), bits)
    result = nm.depth_to_normals(image, nm.DepthOptions(depth_scale=scale, background="none"))
    assert result.report.jumps == 0
    normals = result.normal_map.normals[:, 4:-4].astype(float)
    p = -normals[..., 0] / normals[..., 2] - 0.15
    true = (0.4 * wave * np.cos(wave * x) * np.cos(0.1 * y))[:, 4:-4]
    assert (p * true).sum() / (true * true).sum() == pytest.approx(1, abs=1 - kept)


def test_an_8_bit_picture_widened_to_16_bits_is_fitted_like_one() -> None:
    x, y = grid(96, 96)
    codes = np.floor(128.5 + 0.3 * x - 0.2 * y)
    options = nm.DepthOptions(depth_scale="40px", background="none")
    one, two = (nm.depth_to_normals(p, options) for p in (picture(codes, 8), picture(codes * 257, 16)))
    np.testing.assert_array_equal(one.normal_map.normals, two.normal_map.normals)
    assert two.report.bits == 8


def test_steps_wider_than_a_code_are_measured() -> None:
    x, y = grid(SIDE, SIDE)
    codes = 4096 * np.floor(8 + 0.05 * x + 0.02 * y) + 7
    result = nm.depth_to_normals(picture(codes, 16), nm.DepthOptions(depth_scale="16px", background="none"))
    assert result.report.step_px == pytest.approx(4096 * 16 / 65535)
    assert angles(result.normal_map.normals, normals_of_slopes(0.05, 0.02)).max() < 2


TURNS = {
    "left": (np.rot90, lambda n: np.rot90(n)[..., [1, 0, 2]] * [-1, 1, 1]),
    "half": (lambda a: a[::-1, ::-1], lambda n: n[::-1, ::-1] * [-1, -1, 1]),
    "across": (lambda a: a[:, ::-1], lambda n: n[:, ::-1] * [-1, 1, 1]),
    "down": (lambda a: a[::-1], lambda n: n[::-1] * [1, -1, 1]),
}


@pytest.mark.parametrize("bits", [8, 16])
@pytest.mark.parametrize("turn", TURNS)
def test_rotating_the_image_rotates_the_map(turn: str, bits: int) -> None:
    x, y = grid(80, 80)
    disc = np.hypot(x - 5, y + 3) < 25
    z = 10 + 3 * np.sin(x / 9) * np.cos(y / 7) + np.where(disc, 25 + 0.2 * x, 0)
    image, turned = TURNS[turn]
    codes = np.floor(z / 45 * (2**bits - 1))
    options = nm.DepthOptions(depth_scale="45px", background="none")
    one, two = (nm.depth_to_normals(picture(np.ascontiguousarray(c), bits), options) for c in (codes, image(codes)))
    np.testing.assert_allclose(two.normal_map.normals, turned(one.normal_map.normals), atol=2e-3)
    np.testing.assert_allclose(two.jumps, image(one.jumps), atol=1e-3)


def test_a_constant_changes_nothing_and_the_scale_multiplies_slopes() -> None:
    x, y = grid(64, 64)
    z = (4 * np.sin(x / 9) * np.cos(y / 11) + 8).astype(np.float32)
    plain, raised, doubled = (
        nm.depth_to_normals(picture(values), nm.DepthOptions(depth_scale=f"{scale * np.ptp(z)}px", background="none"))
        for values, scale in ((z, 1), (z + 64, 1), (z, 2))
    )
    np.testing.assert_allclose(raised.normal_map.normals, plain.normal_map.normals, atol=1e-4)
    n, m = plain.normal_map.normals.astype(float), doubled.normal_map.normals.astype(float)
    np.testing.assert_allclose(m[..., :2] / m[..., 2:], 2 * n[..., :2] / n[..., 2:], atol=1e-4)


def test_a_given_tolerance_smooths_and_none_follows_every_code() -> None:
    x, _ = grid(96, 96)
    codes = np.floor(100 + 0.1 * x + 40 * np.random.default_rng(1).random(x.shape))
    rough, smooth = (fitted(codes, smooth=word) for word in ("none", "6px"))
    assert rough.report.tolerance_px == 0
    assert smooth.report.tolerance_px == 6
    assert smooth.report.curl < 0.2 * rough.report.curl + 1e-3


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (2, 2), (3, 7), (13, 5)])
def test_tiny_images_are_converted(shape: tuple[int, int]) -> None:
    for bits in (8, 16, 32):
        values = np.arange(shape[0] * shape[1]).reshape(shape) % 200
        result = nm.depth_to_normals(picture(values, bits), nm.DepthOptions(depth_scale="3px"))
        assert result.normal_map.frame.shape == shape
        assert result.jumps.shape == shape
