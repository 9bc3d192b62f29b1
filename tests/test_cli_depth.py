"""``nmap compose depth``: reads a depth image and writes a map, its jumps and a report."""

from __future__ import annotations

import io
import json
import re
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from depth_cases import ball
from depth_scenes import FOCAL, floats, sphere

import nmaptool as nm


@pytest.fixture
def depth_png(tmp_path: Path, png: Any) -> Path:
    """A 16-bit sphere in front of a plane."""
    scene = ball(96, 30, 30)
    return png(tmp_path / "depth.png", np.floor(scene.heights / 60 * 65535).astype(np.uint16))


def test_map_jumps_curl_and_report_are_written(run: Any, tmp_path: Path, depth_png: Path) -> None:
    out, jumps, curl, report = (tmp_path / name for name in ("map.exr", "jumps.png", "curl.png", "report.json"))
    words = ("--jumps-out", jumps, "--curl", curl, "--report", report, "--depth-scale", "60px", "--width", "48mm")
    done = run("compose", "depth", depth_png, "-o", out, *words)
    assert done.code == 0, done.err
    assert "scale 60 px (given)" in done.err
    assert "of the picture; --background flat keeps the flat patches at the lowest height" in done.err
    assert "jumps: 1 px or more, beside" in done.err
    assert f"wrote {out}" in done.err
    read = nm.read_normal_map(out)
    expected = nm.depth_to_normals(nm.read_raster(depth_png), nm.DepthOptions(depth_scale="60px", width="48mm"))
    np.testing.assert_allclose(read.normals, expected.normal_map.normals, atol=1e-6)
    np.testing.assert_array_equal(read.foreground, expected.normal_map.foreground)
    assert read.frame.pitch_mm == pytest.approx(0.5)
    picture = nm.read_raster(jumps)
    assert picture.attributes["kind"] == "jumps"
    white = float(picture.attributes["white"])
    np.testing.assert_allclose(picture.pixels[..., 0] / 65535 * white, expected.jumps, atol=white / 65535)
    metadata = json.loads(report.read_text(encoding="utf-8"))
    assert metadata["files"] == {"image": str(depth_png), "mask": None}
    assert metadata["jumps"] == np.count_nonzero(expected.jumps)
    assert metadata["options"]["depth_scale"] == "60px"
    assert json.loads(nm.read_raster(out).attributes["recipe"])["command"] == "depth"


def test_an_assumed_depth_is_reported(run: Any, tmp_path: Path, depth_png: Path) -> None:
    done = run("compose", "depth", depth_png, "-o", tmp_path / "map.png")
    assert "no depth scale given: white at 10% of the width above black is assumed" in done.err
    assert run("compose", "depth", depth_png, "-o", tmp_path / "map.png", "-q", "--overwrite").err == ""


def test_depth_reads_standard_input(run: Any, tmp_path: Path, depth_png: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=io.BytesIO(depth_png.read_bytes())))
    done = run("compose", "depth", "-", "-o", tmp_path / "map.exr", "--jump", "none")
    assert done.code == 0, done.err
    assert "standard input: 96 x 96" in done.err
    assert "jumps: not searched for" in done.err


def test_options_take_effect(run: Any, tmp_path: Path, depth_png: Path) -> None:
    words = ("--jump", "4px", "--smooth", "0.5px", "--background", "flat", "--json")
    done = run("compose", "depth", depth_png, "-o", tmp_path / "map.exr", *words)
    metadata = json.loads(done.out)
    assert (metadata["jump_px"], metadata["tolerance_px"], metadata["background"]) == (4, 0.5, "flat")
    assert nm.read_normal_map(tmp_path / "map.exr").coverage.min() == 1
    run("compose", "depth", depth_png, "-o", tmp_path / "motif.exr")
    assert nm.read_normal_map(tmp_path / "motif.exr").coverage.min() == 0


def test_a_mask_sets_the_coverage(run: Any, tmp_path: Path, depth_png: Path, png: Any) -> None:
    left = np.zeros((96, 96), np.uint8)
    left[:, :48] = 255
    mask = png(tmp_path / "mask.png", left)
    done = run("compose", "depth", depth_png, "-o", tmp_path / "map.exr", "--background", "flat", "--mask", mask)
    assert done.code == 0, done.err
    np.testing.assert_array_equal(nm.read_normal_map(tmp_path / "map.exr").coverage, left / 255)


def camera_png(tmp_path: Path, png: Any) -> Path:
    """A 16-bit picture in mm as a depth camera writes it, with dropouts."""
    scene = sphere()
    mm = np.where(scene.mask, np.round(scene.mm), 0)
    mm[60:62, 80:82] = 0
    return png(tmp_path / "camera.png", mm.astype(np.uint16))


def test_a_depth_camera_gives_real_millimetres(run: Any, tmp_path: Path, png: Any) -> None:
    image, out = camera_png(tmp_path, png), tmp_path / "map.exr"
    done = run("compose", "depth", image, "-o", out, "--from", "realsense", "--fov", f"{FOCAL}px", "--json")
    assert done.code == 0, done.err
    metadata = json.loads(done.out)
    assert (metadata["preset"], metadata["unit"], metadata["values"]) == ("realsense", "1mm", "distance")
    assert metadata["filled_pixels"] == 4
    assert metadata["options"]["fov"] == f"{FOCAL:.12g}px"
    assert nm.read_normal_map(out).frame.pitch_mm == pytest.approx(metadata["distance_mm"] / FOCAL)
    assert "16 bit distance, near is dark or small (preset realsense), scale" in done.err
    assert "(unit), 50 degrees across (given)" in done.err
    assert re.search(r"at the median distance of 3\.8\d m, from the field of view; --width sets another", done.err)
    assert "filled 1 hole of at most 3 px, 4 pixels; --fill none leaves them open" in done.err
    assert re.search(r"no depth: 0 \(\d+ pixels\); --empty none reads them as depths", done.err)


def test_what_is_assumed_names_the_flag(run: Any, tmp_path: Path, png: Any) -> None:
    image, out = camera_png(tmp_path, png), tmp_path / "map.exr"
    plain = run("compose", "depth", image, "-o", out).err
    assert "give --values distance or --from realsense, and if 0 is a height, --empty none" in plain
    assert re.search(r"10% of the width is assumed for the values in use, 3\d+ to 4000, 0\.46% of the codes", plain)
    words = ("--overwrite", "-o", out)
    known = run("compose", "depth", image, "--from", "realsense", *words).err
    assert "the unit of 1mm is not used, because the size of a pixel is not known: add --fov 60" in known
    assert "(see the data sheet of the camera)" in known
    given = run("compose", "depth", image, "--values", "distance", "--depth-scale", "10%", *words).err
    assert re.search(r"or give --depth-scale \d{4}px for 20 px", given)
    far = run("compose", "depth", image, "--values", "distance", *words).err
    assert "no field of view given: read as orthographic; set it with --fov 60" in far
    relative = run("compose", "depth", image, "--from", "midas", *words).err
    assert "disparities up to an unknown scale and offset are read as heights" in relative


def test_a_layer_of_distances_is_named(run: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = sphere()
    image = floats(
        np.where(scene.mask, scene.mm / 1000, 1e10), layer="Depth", orientation=6, notes=("has `invert=True` inside",)
    )
    monkeypatch.setattr(nm, "read_raster", lambda *_, **__: image)
    (tmp_path / "z.exr").write_bytes(b"")
    out = tmp_path / "map.exr"
    done = run("compose", "depth", tmp_path / "z.exr", "-o", out)
    assert done.code == 0, done.err
    assert "written by blender (found; --values height reads near as large)" in done.err
    assert "turned upright by its EXIF orientation 6" in done.err
    assert "has --invert inside" in done.err
    assert nm.read_normal_map(out).frame.shape == (200, 150)


def test_false_colours_are_refused_with_the_remedy(refused: Any, tmp_path: Path) -> None:
    import cv2

    grey = (sphere().mm % 256).astype(np.uint8)
    cv2.imwrite(str(tmp_path / "color.png"), cv2.applyColorMap(grey, cv2.COLORMAP_TURBO))
    pattern = "false colours cannot be turned back into exact depths; export the depth picture again in grey and alone"
    refused(3, pattern, "compose", "depth", tmp_path / "color.png", "-o", tmp_path / "out.exr")


@pytest.mark.parametrize(
    ("words", "code", "pattern"),
    [
        (("-o", "map.exr", "--empty", "x"), 2, "--empty x: use auto, none or numbers separated by commas"),
        (
            ("-o", "map.exr", "--unit", "3px"),
            2,
            "--unit 3px: sets the length of a stored unit; give it in mm, cm, m or in",
        ),
        (("-o", "map.exr", "--unit", "1mm"), 2, "--unit 1mm: the size of a pixel in .* give the --width"),
        (("-o", "map.exr", "--unit", "1mm", "--depth-scale", "9px"), 2, "--depth-scale and --unit: both set"),
        (("-o", "map.exr", "--invert", "--values", "height"), 2, "--invert and --values height: contradict each other"),
        (("-o", "map.exr", "--fov", "wide"), 2, "--fov wide: use degrees, such as 35, or a focal length in px"),
        (("-o", "map.exr", "--fov", "35mm"), 2, "--fov 35mm: is not in px; give degrees, or the focal length in px"),
        (("-o", "map.exr", "--from", "nothing"), 2, "nothing"),
        ((), 2, "no output given: add one"),
        (("-o", "map.jpg"), 2, "map.jpg"),
        (("-o", "map.exr", "--jumps-out", "j.exr"), 2, "the jumps picture is written as .png"),
        (("-o", "map.exr", "--jump", "x"), 2, "--jump x: use auto, none or a height, such as 2px"),
        (("-o", "map.exr", "--smooth", "-1px"), 2, "--smooth=-1px: use auto, none or a height"),
        (("-o", "map.exr", "--depth-scale", "5mm"), 2, "is not known; give px or %, or the --width of the picture"),
        (("-o", "map.exr", "--fov", "200"), 2, "--fov 200: must lie between"),
        (("-o", "map.exr", "--mask", "none.png"), 3, "none.png: no such file"),
        (("-o", "map.exr", "--max-megapixels", "0.001"), 4, "megapixels"),
    ],
)
def test_wrong_arguments_are_refused(
    refused: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, depth_png: Path, words: Any, code: int, pattern: str
) -> None:
    monkeypatch.chdir(tmp_path)
    refused(code, pattern, "compose", "depth", depth_png, *words)


def test_inputs_that_are_not_depth_images_are_refused(refused: Any, tmp_path: Path, maps: dict[str, Path]) -> None:
    out = tmp_path / "out.exr"
    refused(
        3, "is a colour picture, but depth and height pictures are grey", "compose", "depth", maps["clean"], "-o", out
    )
    refused(3, "is not a picture", "compose", "depth", maps["text"], "-o", out)
    refused(3, "truncated or damaged", "compose", "depth", maps["cut"], "-o", out)
    refused(3, "no such file", "compose", "depth", maps["missing"], "-o", out)
    refused(5, "exists", "compose", "depth", maps["one"], "-o", maps["clean"])
