"""Height, direction and camera of a depth image: options, metadata, own files, backgrounds."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bake_cases import plate_mesh
from depth_cases import angles, ball, grid, normals_of_slopes, picture

import nmaptool as nm


def slopes(result: nm.DepthResult) -> tuple[Any, Any]:
    n = result.normal_map.normals.astype(float)
    return -n[..., 0] / n[..., 2], -n[..., 1] / n[..., 2]


def ramp16(**more: Any) -> nm.RasterImage:
    return picture(np.tile(np.linspace(0, 65535, 101), (40, 1)), 16, **more)


@pytest.mark.parametrize(
    ("given", "width", "scale_px"),
    [("20px", None, 20.0), ("30%", None, 30.3), ("5mm", "202mm", 2.5), (None, None, 10.1), ("1in", "202mm", 12.7)],
)
def test_the_scale_may_be_in_px_mm_or_percent_of_the_width(given: Any, width: Any, scale_px: float) -> None:
    result = nm.depth_to_normals(ramp16(), nm.DepthOptions(depth_scale=given, width=width, background="none"))
    assert result.report.scale_px == pytest.approx(scale_px)
    assert result.report.scale_from == ("given" if given else "assumed")
    p, q = slopes(result)
    np.testing.assert_allclose(p, scale_px / 100, rtol=2e-2)
    np.testing.assert_allclose(q, 0, atol=1e-3)
    if width:
        assert result.normal_map.frame.pitch_mm == pytest.approx(2.0)


def test_a_percentage_refers_to_the_width_even_in_tall_images() -> None:
    tall = picture(np.tile(np.linspace(0, 65535, 200)[:, None], (1, 50)), 16)
    assert nm.depth_to_normals(tall, nm.DepthOptions(depth_scale="20%")).report.scale_px == pytest.approx(10)


def test_invert_negates_every_slope() -> None:
    plain, turned = (nm.depth_to_normals(ramp16(), nm.DepthOptions(invert=i, background="none")) for i in (0, 1))
    np.testing.assert_allclose(slopes(turned)[0], -slopes(plain)[0], atol=1e-4)
    assert (turned.report.inverted, turned.report.inverted_from) == (True, "given")


def relief_of_dome(tmp_path: Path, name: str) -> tuple[Path, nm.Relief]:
    x, y = grid(72, 60 + 20)
    z = 6 * np.exp(-(x**2 + y**2) / 400)
    p, q = -x / 200 * z, -y / 200 * z
    dome = nm.NormalMap(normals_of_slopes(p, q).astype(np.float32), np.ones(x.shape, np.float32), nm.Frame(*x.shape))
    options = nm.ReliefOptions(background="free", beta=0, mu=0, height="3mm", width="40mm")
    relief = nm.relief(dome, options=options)
    nm.write_relief(relief, tmp_path / name)
    return tmp_path / name, relief


@pytest.mark.parametrize("ending", ["exr", "tif", "png"])
def test_heights_of_a_relief_are_read_back_in_exact_mm(tmp_path: Path, ending: str) -> None:
    path, relief = relief_of_dome(tmp_path, f"height.{ending}")
    result = nm.depth_to_normals(nm.read_raster(path), nm.DepthOptions(background="none"))
    assert (result.report.kind, result.report.scale_from, result.report.inverted) == ("height", "file", False)
    assert result.normal_map.frame.pitch_mm == pytest.approx(0.5)
    height = relief.height.at_pixels() / relief.pitch_mm
    true = normals_of_slopes(np.gradient(height, axis=1), -np.gradient(height, axis=0))
    inner = (slice(1, -1), slice(1, -1))
    assert angles(result.normal_map.normals, true)[inner].max() < 0.2
    assert result.report.jumps == 0


@pytest.mark.parametrize("fov", [0.0, 50.0])
@pytest.mark.parametrize("format", ["exr", "png"])
def test_depth_of_a_baked_mesh_gives_the_baked_normals(tmp_path: Path, format: str, fov: float) -> None:
    options = nm.BakeOptions(size="360x300", renderer="numpy", fov=fov, shading="flat")
    layers = nm.bake(plate_mesh(), options)
    nm.write_layers(layers, tmp_path / "layers", format=format, depth=True)
    image = nm.read_raster(tmp_path / "layers" / f"depth.{format}")
    result = nm.depth_to_normals(image)
    report = result.report
    assert (report.kind, report.fov, report.scale_from) == ("depth", fov, "file")
    assert report.inverted == (format == "exr")
    original = layers.original
    inside = original.coverage == 1
    inside[1:-1, 1:-1] &= inside[:-2, 1:-1] & inside[2:, 1:-1] & inside[1:-1, :-2] & inside[1:-1, 2:]
    off = angles(result.normal_map.normals, original.normals)[inside]
    # flat faces some 12 px wide: differences across their edges lie between two faces
    assert np.median(off) < 0.6
    assert np.mean(off) < 2
    np.testing.assert_array_equal(result.normal_map.coverage > 0, original.coverage > 0)
    assert report.background == "empty"
    assert report.jumps == 0


@pytest.mark.parametrize("metre", [1.0, 0.001])
def test_a_plane_and_a_sphere_in_perspective_are_recovered(metre: float) -> None:
    x, y = grid(120, 160)
    fov = 60.0
    focal = 160 / (2 * np.tan(np.radians(fov / 2)))
    ray = np.stack([x / focal, y / focal, -np.ones_like(x)], axis=-1)
    normal = np.array([0.3, -0.2, 1.0])
    depth = (normal @ [0, 0, -4.0]) / (ray @ normal)
    # distance * ln(depth) is what the slopes integrate to
    log = -focal * np.log(depth)
    true = normals_of_slopes(np.gradient(log, axis=1), -np.gradient(log, axis=0))
    image = picture(depth * metre)
    result = nm.depth_to_normals(image, nm.DepthOptions(fov=fov, invert=True, background="none"))
    inner = (slice(2, -2), slice(2, -2))
    assert angles(result.normal_map.normals, true)[inner].max() < 0.1
    b = ray @ np.array([0, 0, -5.0])
    inside = b**2 - (ray**2).sum(-1) * (25 - 2.0**2) > 0
    hit = (b - np.sqrt(np.where(inside, b**2 - (ray**2).sum(-1) * (25 - 2.0**2), 0))) / (ray**2).sum(-1)
    image = picture(np.where(inside, hit, 0) * metre)
    result = nm.depth_to_normals(image, nm.DepthOptions(fov=fov, invert=True))
    n = (ray * hit[..., None] - [0, 0, -5.0]) / 2
    facing = -(n * ray).sum(-1)
    well = inside & (facing > 0.4)
    facing = np.where(well, facing, 1)
    true = normals_of_slopes(-n[..., 0] / facing, -n[..., 1] / facing)
    assert angles(result.normal_map.normals, true)[well].max() < 1
    np.testing.assert_array_equal(result.normal_map.coverage > 0, inside)


def test_grey_in_perspective_is_true_to_scale_at_black() -> None:
    x, _ = grid(60, 101)
    image = picture(np.tile(np.linspace(0, 65535, 101), (60, 1)), 16)
    result = nm.depth_to_normals(image, nm.DepthOptions(depth_scale="30px", fov=40, background="none"))
    focal = 101 / (2 * np.tan(np.radians(20)))
    log = -focal * np.log(focal - np.linspace(0, 30, 101))
    np.testing.assert_allclose(slopes(result)[0][30, 2:-2], np.gradient(log)[2:-2], rtol=2e-3)
    assert x.shape == result.jumps.shape


def test_the_lowest_flat_patch_is_the_background() -> None:
    scene = ball(96, 30, 30)
    codes = scene.heights / 60 * 255
    for options, codes_ in ((nm.DepthOptions(), codes), (nm.DepthOptions(invert=True), 255 - np.floor(codes + 0.5))):
        result = nm.depth_to_normals(picture(codes_, 8), options)
        assert result.report.background == "cut"
        np.testing.assert_array_equal(result.normal_map.foreground, scene.heights > 0)
        assert np.array_equal(result.normal_map.coverage > 0, scene.heights > 0)
        assert (result.normal_map.normals[~result.normal_map.foreground] == (0, 0, 1)).all()
    plate = nm.depth_to_normals(picture(codes, 8), nm.DepthOptions(background="flat"))
    assert plate.normal_map.coverage.min() == 1
    np.testing.assert_array_equal(plate.normal_map.foreground, scene.heights > 0)
    whole = nm.depth_to_normals(picture(codes, 8), nm.DepthOptions(background="none"))
    assert whole.normal_map.foreground.all()
    assert whole.report.background == "none"


def test_transparent_nan_and_masked_pixels_are_not_surface() -> None:
    x, y = grid(64, 64)
    z = (0.3 * x + 0.1 * y + 20).astype(np.float32)
    hole = np.hypot(x, y) < 12
    holed = np.where(hole, np.float32(np.nan), z)
    alpha = (~hole).astype(np.float32)
    scale = nm.DepthOptions(depth_scale=f"{np.ptp(z)}px", background="none")
    results = [
        nm.depth_to_normals(picture(holed), scale),
        nm.depth_to_normals(nm.RasterImage(np.dstack([z, alpha]), ("Y", "A"), bits=32), scale),
        nm.depth_to_normals(picture(z), scale, mask=alpha),
    ]
    for result in results:
        np.testing.assert_array_equal(result.normal_map.coverage, alpha)
        assert angles(result.normal_map.normals, normals_of_slopes(0.3, 0.1))[~hole].max() < 0.1
        assert (result.normal_map.normals[hole] == (0, 0, 1)).all()
        assert result.report.jumps == 0


def test_the_report_is_plain_json() -> None:
    result = nm.depth_to_normals(ramp16(), nm.DepthOptions(jump="3px"))
    values = json.loads(json.dumps(result.report.to_dict()))
    assert values["options"]["jump"] == "3px"
    assert values["jump_px"] == 3
    assert set(values["seconds"]) == {"reading", "jumps", "surface", "normals", "curl"}
