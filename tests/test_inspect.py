"""``nmap inspect``: its measurements, every finding on a map made for it, and remedies that work."""

import dataclasses
import itertools
import json
import os
import re
import subprocess
import sys

import cv2
import numpy as np
import pytest
from faulty_maps import FAULTY, FAULTY_FILES, on_flat

import nmaptool as nm
from nmaptool.maps.inspection_rules import CODES
from nmaptool_cli.mentions import in_flags


def found(path, **options):
    return {finding.code for finding in nm.inspect_map(nm.read_raster(path), nm.ReadOptions(**options)).findings}


@pytest.fixture
def faulty(tmp_path, dome, codes, png):
    """``faulty(code)``: the file of a map made to give that finding, and the options for reading it."""

    def make(code):
        if code in FAULTY_FILES:
            FAULTY_FILES[code](tmp_path / f"{code}.png", dome(), codes)
            return tmp_path / f"{code}.png", {}
        made = FAULTY[code](dome(), codes)
        return png(tmp_path / f"{code}.png", made.pixels, made.chunks), made.options

    return make


@pytest.mark.parametrize("code", CODES)
def test_each_finding_appears_for_its_map_and_gives_a_remedy(faulty, run, code):
    path, options = faulty(code)
    flags = [f"--{name}={value}" for name, value in options.items()]
    told = run("inspect", path, *flags)
    assert (told.code, told.err) == (1, "")
    exact = run("inspect", path, *flags, "--json")
    assert exact.code == 1
    (finding,) = [f for f in json.loads(exact.out)["findings"] if f["code"] == code]
    assert finding["message"] in told.out
    assert in_flags(finding["remedy"]) in told.out
    assert len(finding["remedy"]) > 10


@pytest.mark.parametrize("code", CODES)
def test_each_finding_appears_alone_if_nothing_else_is_wrong(faulty, code):
    path, options = faulty(code)
    assert found(path, **options) == {code}


def test_a_clean_map_has_no_finding_and_exit_code_0(run, clean_map):
    result = run("inspect", clean_map)
    assert (result.code, result.err) == (0, "")
    assert "clean: no findings" in result.out
    assert "96 x 96, 16 bit integer, channels R G B A" in result.out
    assert found(clean_map) == set()


@pytest.mark.parametrize("kind", ["white", "grey", "black", "flat"])
@pytest.mark.parametrize("bits", [8, 16])
@pytest.mark.parametrize("smooth", [False, True])
def test_backgrounds_give_no_finding(tmp_path, dome, codes, png, kind, bits, smooth):
    d = dome(128, 128, smooth=smooth)
    assert found(png(tmp_path / "map.png", codes(d.normals, bits, kind, d.cover))) == set()


def test_formats_give_no_finding(tmp_path, dome, codes, picture):
    d = dome(128, 128)
    names = ("R", "G", "B", "A")
    black = np.where(d.inside[..., None], d.normals, 0)
    assert found(picture(tmp_path / "a.exr", np.dstack([black, d.inside]), names)) == set()
    assert found(picture(tmp_path / "b.exr", np.dstack([black, d.inside]), names, stored="half")) == set()
    assert found(picture(tmp_path / "c.exr", (d.normals + 1) / 2)) == set()
    assert found(picture(tmp_path / "d.tif", codes(d.normals, 16))) == set()
    assert found(picture(tmp_path / "e.bmp", codes(d.normals, 8, "white", d.cover))) == set()
    assert found(picture(tmp_path / "f.jpg", codes(d.normals, 8, "white", d.cover), CompressionQuality=97)) == set()


def test_written_maps_are_clean(tmp_path, clean_map):
    for name, how in (("a.png", {}), ("b.png", {"bits": "8"}), ("c.exr", {}), ("d.tif", {"bits": "float"})):
        nm.write_normal_map(nm.read_normal_map(clean_map), tmp_path / name, nm.WriteOptions(**how))
        assert found(tmp_path / name) == set()


WAYS = [(order, signs) for order in ((0, 1), (1, 0)) for signs in itertools.product((1, -1), repeat=2)]


@pytest.mark.parametrize(("order", "signs"), WAYS)
def test_remedies_restore_the_true_normals(tmp_path, dome, codes, png, run, order, signs):
    """For every rotation, mirroring and inversion of a raised motif, reading with the remedy corrects it."""
    d = dome(128, 128)
    stored = np.dstack([signs[0] * d.normals[..., order[0]], signs[1] * d.normals[..., order[1]], d.normals[..., 2]])
    path = png(tmp_path / "map.png", np.dstack([codes(stored, 16), (d.inside * 65535).astype(np.uint16)]))
    seen = nm.inspect_map(nm.read_raster(path))
    swizzles = [m.group(1) for f in seen.findings if (m := re.search(r"`swizzle='(\S+)'`", f.remedy))]
    if order == (0, 1) and signs != (-1, -1):  # correct, or with green down or red left, which reading corrects
        assert swizzles == []
        options = {}
    else:
        assert len(swizzles) == 1
        options = {"swizzle": swizzles[0]}
        assert run("inspect", path, f"--swizzle={swizzles[0]}").code == 0
        assert run("inspect", path, "--swizzle", swizzles[0]).code == 0
    back = nm.read_normal_map(path, nm.ReadOptions(**options))
    assert np.abs(back.normals - d.normals)[d.inside].max() < 1e-4


@pytest.mark.parametrize("swizzle", ["R, G, B", "+r,+g,+b"])
def test_remedies_are_valid_for_any_spelling_of_the_swizzle(faulty, swizzle):
    path, _ = faulty("inverted")
    seen = nm.inspect_map(nm.read_raster(path), nm.ReadOptions(swizzle=swizzle))
    (remedy,) = [f.remedy for f in seen.findings if f.code == "inverted"]
    nm.inspect_map(nm.read_raster(path), nm.ReadOptions(swizzle=remedy.partition("`swizzle='")[2].rstrip("'`")))


def test_the_remedy_corrects_a_wrong_green(faulty):
    path, options = faulty("green-wrong")
    (finding,) = nm.inspect_map(nm.read_raster(path), nm.ReadOptions(**options)).findings
    assert "`green='up'`" in finding.remedy
    assert found(path, green="up") == set()


def test_the_measurements_match_the_map(tmp_path, dome, codes, png):
    d = dome()
    rng = np.random.default_rng(32)
    shorter, behind = rng.uniform(size=(96, 96)) < 0.2, rng.uniform(size=(96, 96)) < 0.1
    vectors = d.normals.copy()
    vectors[shorter] *= 0.75
    vectors[behind] *= (1, 1, -1)
    seen = nm.inspect_map(nm.read_raster(png(tmp_path / "map.png", codes(vectors, 16))))
    assert (seen.cols, seen.rows, seen.bits, seen.channels) == (96, 96, 16, ("R", "G", "B"))
    assert (seen.foreground_share, seen.coverage_mean) == (1, 1)
    assert seen.off_length_share == pytest.approx(shorter.mean(), abs=1e-9)
    assert seen.away_share == pytest.approx(behind.mean(), abs=1e-9)
    assert seen.unit_length_error == pytest.approx(0.25 * shorter.mean(), abs=1e-4)
    assert seen.outline_sign is None


def test_the_foreground_and_the_outline_are_measured(clean_map, dome):
    seen = nm.inspect_map(nm.read_raster(clean_map))
    assert seen.foreground_share == pytest.approx(dome().inside.mean(), abs=1e-9)
    assert seen.outline_sign > 0.5
    assert seen.decoding.curl_ratio > 1.5
    assert seen.unit_length_error < 1e-4


@pytest.mark.parametrize(("code", "bias"), [(127, -0.5), (128, 0.5)])
def test_the_neutral_bias_is_the_height_error_across_the_map(tmp_path, dome, codes, png, code, bias):
    pixels = codes(on_flat(dome(80, 120)))
    pixels[(pixels == (128, 128, 255)).all(axis=-1)] = (code, code, 255)
    seen = nm.inspect_map(nm.read_raster(png(tmp_path / "map.png", pixels)))
    assert seen.neutral_bias_px == pytest.approx(bias / 127.5 * 120, rel=1e-6)


def test_json_is_complete_and_strict(run, clean_map, tmp_path, dome, picture):
    def refuse(word):
        raise AssertionError(f"{word} is not JSON")

    huge = dome().normals.copy()
    huge[10, 10] *= 1e30
    for path in (clean_map, picture(tmp_path / "huge.exr", huge)):
        seen = json.loads(run("inspect", path, "--json").out, parse_constant=refuse)
        assert set(seen) == {field.name for field in dataclasses.fields(nm.Inspection)}
        assert set(seen["decoding"]) == {field.name for field in dataclasses.fields(nm.Decoding)}
        assert seen["name"] == str(path)


def test_a_mask_restricts_the_measurements(tmp_path, faulty, png):
    path, _ = faulty("off-length")
    mask = np.zeros((96, 96), np.float32)
    mask[40:56, 40:56] = 1
    seen = nm.inspect_map(nm.read_raster(path), mask=mask)
    assert seen.foreground_share == pytest.approx(256 / 9216)


def test_quiet_prints_nothing_and_keeps_the_exit_code(run, faulty, clean_map):
    path, _ = faulty("turned")
    for file, code in ((path, 1), (clean_map, 0)):
        result = run("inspect", file, "--quiet")
        assert (result.code, result.out, result.err) == (code, "", "")


@pytest.mark.parametrize("shape", [(1, 1), (1, 60), (60, 1), (2, 2), (3, 70)])
@pytest.mark.parametrize("half_clear", [False, True])
def test_the_smallest_maps_are_inspected(run, tmp_path, dome, codes, png, shape, half_clear):
    pixels = codes(dome().normals, 16)[20 : 20 + shape[0], 10 : 10 + shape[1]]
    if half_clear:
        alpha = np.full(shape, 65535, np.uint16)
        alpha.ravel()[: alpha.size // 2] = 0
        pixels = np.dstack([pixels, alpha])
    result = run("inspect", png(tmp_path / "map.png", pixels))
    assert (result.code in (0, 1), result.err) == (True, "")
    assert f"{shape[1]} x {shape[0]}" in result.out


def test_a_name_that_standard_output_cannot_encode_is_escaped(clean_map):
    path = clean_map.rename(clean_map.with_name("größe 頭.png"))
    script = "import sys; sys.argv[0] = 'nmap'; from nmaptool_cli.start import run; run()"
    for encoding, shown in (("cp1252", "größe \\u982d.png: 96 x 96"), ("utf-8", "größe 頭.png: 96 x 96")):
        env = {**os.environ, "PYTHONIOENCODING": encoding, "PYTHONUTF8": "0"}
        words = [sys.executable, "-c", script, "inspect", path]
        done = subprocess.run(words, capture_output=True, check=False, env=env)
        assert (done.returncode, done.stderr) == (0, b"")
        assert shown in done.stdout.decode(encoding)


def test_edges_of_a_motif_at_eighth_pixels_are_no_blocks(tmp_path, png):
    """A facade whose steps lie at every eighth pixel; `was_jpeg` of faulty_maps has blocks everywhere."""
    steps = np.zeros((400, 400), np.float32)
    steps[60:340, 60:340] = 10
    steps[100:300, 140:260] = 20
    down, across = np.gradient(cv2.GaussianBlur(steps, (0, 0), 1.5))
    vectors = np.dstack([-across, down, np.ones_like(steps)])
    vectors /= np.linalg.norm(vectors, axis=2, keepdims=True)
    pixels = np.floor((vectors + 1) / 2 * 255 + 0.5).astype(np.uint8)
    assert "lossy-blocks" not in found(png(tmp_path / "facade.png", pixels))
