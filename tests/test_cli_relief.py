"""The relief command with layers, detail, curved backgrounds and masks, and what it reports."""

import json

import numpy as np
import pytest

import nmaptool as nm
from nmaptool.core.grid import height_slopes


def rolled(side=96):
    row, col = np.mgrid[0 : side + 1, 0 : side + 1]
    return 5 * np.sin(col / 15) + 2 * np.cos(row / 11)


def codes_of(z, green):
    p, q = height_slopes(z)
    normals = np.dstack([-p, -q * green, np.ones_like(p)])
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    return np.floor((normals + 1) / 2 * 65535 + 0.5).astype(np.uint16)


@pytest.mark.parametrize("green", [1, -1])
def test_a_curved_background_is_read_like_the_map_on_it(run, tmp_path, png, green):
    row, col = np.mgrid[0:97, 0:97]
    roll = rolled()
    bumps = 0.4 * np.cos(col / 2 + row / 3) * np.cos(row / 2 - col / 5) * (np.hypot(row - 48, col - 48) < 30)
    motif = png(tmp_path / "motif.png", codes_of(roll + bumps, green))
    ground = png(tmp_path / "ground.png", codes_of(roll, green))
    mask = png(tmp_path / "mask.png", (255 * (np.hypot(*(np.mgrid[0:96, 0:96] - 47.5)) < 32)).astype(np.uint8))
    words = ("--background", "surface", "--surface", ground, "--mask", mask, "--delta", "0", "-o", tmp_path / "z.npy")
    done = run("relief", motif, *words, "--report", tmp_path / "r.json")
    assert done.code == 0
    assert f"{ground}: 96 x 96" in done.err
    z = np.load(tmp_path / "z.npy") / (100 / 96)
    expected = (roll[:-1, :-1] + roll[1:, 1:]) / 2
    outside = np.hypot(*(np.mgrid[0:96, 0:96] - 47.5)) > 34
    off = (z - expected)[outside]
    assert np.ptp(off) < 0.02 * np.ptp(roll)
    report = json.loads((tmp_path / "r.json").read_text(encoding="utf-8"))
    assert report["files"] == {"original": str(motif), "mask": str(mask), "surface": str(ground)}
    assert {each["green"] for each in report["inputs"]} == {"up" if green > 0 else "down"}
    assert report["reading"]["max_megapixels"] == 270


def test_layer_selects_in_the_map_not_in_its_detail(run, tmp_path, picture, png):
    original = codes_of(rolled(), 1).astype(np.float32) / 65535 * 2 - 1
    layers = np.dstack([original * 0 + np.array([0, 0, 1]), original]).astype(np.float32)
    names = ("base.X", "base.Y", "base.Z", "top.X", "top.Y", "top.Z")
    maps = picture(tmp_path / "maps.exr", layers, names)
    detail = png(tmp_path / "detail.png", codes_of(0 * rolled(), 1))
    for first in ((maps, "--layer", "top"), (f"{maps}:top",)):
        done = run("relief", *first, "--detail", detail, "--background-color", "none", "--json", "-q")
        assert done.code == 0
        assert json.loads(done.out)["inputs"][0]["name"].endswith("maps.exr:top")
    done = run("relief", f"{maps}:top", "--detail", f"{maps}:base", "--background-color", "none", "--json", "-q")
    assert [each["name"][-12:] for each in json.loads(done.out)["inputs"]] == ["maps.exr:top", "aps.exr:base"]


def test_the_fitted_value_is_reported(run, tmp_path, clean_map):
    done = run("relief", clean_map, "--height", "15mm", "--fit", "delta", "--json")
    report = json.loads(done.out)
    assert report["height_range_mm"] == pytest.approx(15, abs=1e-6)
    assert f"delta {report['delta_px'] / report['px_per_delta']:.4g} (fitted)" in done.err
    done = run("relief", clean_map, "--height", "15mm", "--fit", "slope", "--json")
    assert f"slopes times {json.loads(done.out)['scale']:.3g}" in done.err


def test_the_image_holds_its_recipe(run, tmp_path, clean_map):
    assert run("relief", clean_map, "-o", tmp_path / "h.exr", "--beta", "0.01", "--swizzle=r,g,b").code == 0
    own = nm.read_raster(tmp_path / "h.exr").attributes
    assert json.loads(own["options"])["beta"] == 0.01
    assert json.loads(own["reading"])["swizzle"] == "r,g,b"
    assert json.loads(own["files"]) == {"original": str(clean_map)}


def test_a_height_png_states_what_its_codes_mean(run, tmp_path, clean_map):
    done = run("relief", clean_map, "-o", tmp_path / "h.png", "--height", "5mm")
    own = nm.read_raster(tmp_path / "h.png").attributes
    low, high = float(own["height_min_mm"]), float(own["height_max_mm"])
    assert high - low == pytest.approx(5)
    assert f"(black {low:.3f} mm, white {high:.3f} mm)" in done.err


def test_an_output_that_is_an_input_is_refused(run, clean_map):
    before = clean_map.read_bytes()
    done = run("relief", clean_map, "-o", clean_map, "--overwrite")
    assert done.code == 2
    assert "is also an input; give another name" in done.err
    assert clean_map.read_bytes() == before


def test_only_reports_go_to_standard_output(run, clean_map):
    done = run("relief", clean_map, "-o", "-")
    assert done.code == 2
    assert "a relief or a preview is written to a file" in done.err


def test_the_report_states_iterations_memory_and_times(run, tmp_path, clean_map):
    done = run("relief", clean_map, "-o", tmp_path / "z.npy", "--report", tmp_path / "r.json", "--json", "-v")
    report = json.loads(done.out)
    assert report == json.loads((tmp_path / "r.json").read_text(encoding="utf-8"))
    assert report["solver"] == "multigrid"
    assert report["planned_bytes"] > 57 * 97 * 97
    assert report["iterations"] == len(report["history"]) > 1
    assert report["residual"] <= 1e-8
    assert report["history"][-1] == pytest.approx(report["residual"])
    assert list(report["seconds"]) == ["reading", "inputs", "setup", "solve", "finish", "writing"]
    assert all(seconds > 0 for seconds in report["seconds"].values())
    memory, residuals = "memory planned for the solver 1", "residual of each iteration: "
    for words in (memory, residuals, "seconds reading ", ", inputs ", ", finish "):
        assert words in done.err


def test_a_memory_limit_is_respected(run, refused, tmp_path, clean_map):
    refused(4, r"86 x 86 px to solve: the multigrid solver needs about \d+MB of memory, --memory-limit allows 1MB",
            "relief", clean_map, "-o", tmp_path / "z.npy", "--memory-limit", "1MB")  # fmt: skip
    assert run("relief", clean_map, "-o", tmp_path / "z.npy", "--memory-limit", "1GB").code == 0
