"""The compose commands as a designer uses them: pipes, images, reports, metadata, repeatable flags."""

import json
import os
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from compose_cases import as_map, bump_map, flat_map, random_normals

import nmaptool as nm
from nmaptool.core.vectors import mean_abs_curl
from nmaptool.io.pictures.normal_maps import normal_picture
from nmaptool.io.pictures.writer import write_pictures

NMAP = "import sys; from nmaptool_cli.main import main; sys.exit(main(sys.argv[1:]))"


@pytest.fixture
def place(tmp_path, monkeypatch, png):
    """The working folder of the commands, with a base, a detail, a plate, a round motif and masks."""
    monkeypatch.chdir(tmp_path)
    disc = np.hypot(*(np.mgrid[0:20, 0:20] - 9.5)) < 9
    nm.write_normal_map(bump_map(30, 40), "base.exr")
    nm.write_normal_map(as_map(random_normals(30, 40, seed=1, lowest=0.5)), "detail.exr")
    nm.write_normal_map(flat_map(30, 40, pitch_mm=0.5), "plate.png")
    nm.write_normal_map(as_map(random_normals(20, 20, seed=2), disc), "motif.exr")
    left = np.zeros((30, 40), np.uint8)
    left[:, :20] = 255
    png(tmp_path / "left.png", left)
    png(tmp_path / "top.png", np.uint8(255) * (np.mgrid[0:20, 0:20][0] < 10).astype(np.uint8))
    return tmp_path


@pytest.fixture
def made(run, place):
    """``made("blend", ...)``: the resulting map, stdout and stderr."""

    def make(command, *words, out="out.exr"):
        result = run("compose", command, *words, "-o", out, "--overwrite")
        assert result.code == 0, result.err
        return SimpleNamespace(**vars(result), map=nm.read_normal_map(out))

    return make


def piped(*words, given=b"", code=0):
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", NMAP, "compose", *words], input=given, capture_output=True, check=False
    )
    assert done.returncode == code, done.stderr.decode()
    return done


def test_a_pipe_of_commands_is_bit_exact(place):
    blended = piped("blend", "base.exr", "detail.exr", "-o", "-", "--mode", "pd", "-q")
    assert blended.stderr == b""
    turned = piped("transform", "-", "--rotate", "90", "--output=-", "--report", "r.json", given=blended.stdout)
    piped("paste", "plate.png", "-", "--scale=0.5", "-o", "piped.exr", given=turned.stdout)
    expected = nm.blend(*map(nm.read_normal_map, ("base.exr", "detail.exr")), nm.BlendOptions("pd")).normal_map
    expected = nm.transform(expected, nm.TransformOptions(rotate=90)).normal_map
    (place / "turned.exr").write_bytes(turned.stdout)
    assert np.array_equal(nm.read_normal_map("turned.exr").normals, expected.normals)
    layer = nm.Layer(expected, nm.LayerOptions(scale=0.5))
    pasted = nm.paste(nm.read_normal_map("plate.png"), [layer]).normal_map
    assert np.array_equal(nm.read_normal_map("piped.exr").normals, pasted.normals)
    report = json.loads((place / "r.json").read_text(encoding="utf-8"))
    assert report["files"] == {"map": "standard input"}
    assert report["outputs"] == ["standard output", "r.json"]
    assert report["inputs"][0]["name"] == "standard input"


def test_the_temporary_file_of_a_stream_is_never_mentioned(place):
    given = (place / "motif.exr").read_bytes()
    done = piped("paste", "plate.png", "-", "-o", "out.exr", "--json", "-v", given=given)
    assert json.loads(done.stdout)["layers"][0]["name"] == "standard input"
    recipe = nm.read_raster("out.exr").attributes["recipe"]
    assert json.loads(recipe)["layers"][0]["name"] == "standard input"
    assert b"  standard input: over at 10,5 px, 20 x 20, on 21% of the canvas\n" in done.stderr
    for stated in (done.stdout, done.stderr, recipe.encode()):
        assert b"tmp" not in stated


def test_the_report_states_what_was_read_done_and_written(made, place):
    words = ("motif.exr", "motif.exr", "--at", "10px,5px", "--at", "75%,50%", "--mode", "over", "--mode", "rnm")
    more = ("--strength", "0.5", "--curl", "c.png", "--placed", "p.png", "--mask", "top.png")
    report = json.loads(made("paste", "base.exr", *words, *more, "--json").out)
    assert report["command"] == "paste" and report["version"] == nm.__version__
    assert report["files"] == {"background": "base.exr", "layers": ["motif.exr"] * 2, "masks": ["top.png"] * 2}
    assert report["outputs"] == ["out.exr", "c.png", "p.png"]
    assert [i["name"] for i in report["inputs"]] == ["base.exr", "motif.exr", "motif.exr"]
    assert [(i["cols"], i["rows"], i["background"]) for i in report["inputs"]][:2] == [
        (40, 30, "none"),
        (20, 20, "alpha"),
    ]
    assert [p["at"] for p in report["placing"]] == ["10px,5px", "75%,50%"]
    first, second = report["layers"]
    assert (first["box_px"], first["mode"], first["strength"]) == ([0, 0, 20, 15], "over", 0.5)
    assert (second["box_px"], second["mode"], second["name"]) == ([20, 5, 20, 20], "rnm", "motif.exr")
    base = nm.read_normal_map("base.exr")
    everywhere = np.ones((30, 40), bool)
    assert report["curl_before"] == mean_abs_curl(base.normals, everywhere)
    after = nm.read_normal_map("out.exr").normals
    assert report["curl_after"] == mean_abs_curl(after, everywhere) > report["curl_before"]
    assert report["reading"]["green"] == "auto"


def test_blends_and_transforms_report_their_options(made):
    report = json.loads(
        made("blend", "base.exr", "detail.exr", "--strength", "0.25", "--mask", "left.png", "--json").out
    )
    assert report["options"] == {"mode": "rnm", "strength": 0.25, "fit": False}
    assert report["layers"] == [{"name": "detail.exr", "mode": "rnm", "strength": 0.25, "share": 0.5}]
    assert report["files"] == {"base": "base.exr", "detail": "detail.exr", "mask": "left.png"}
    result = made("transform", "base.exr", "--rotate", "-30", "--crop", "-0px,0,50%,50%", "--report", "-", "-q")
    report = json.loads(result.out)
    assert result.err == ""
    assert report["options"]["rotate"] == -30 and report["options"]["crop"] == "-0px,0,50%,50%"
    assert np.allclose(report["options"]["matrix"], [[0.8660254, -0.5], [0.5, 0.8660254]])


def test_extra_images_have_the_size_of_the_map_and_the_stated_values(made, place):
    result = made("paste", "plate.png", "motif.exr", "--at", "0,0", "--curl", "c.png", "--placed", "p.png")
    placed, curl = nm.read_raster("p.png"), nm.read_raster("c.png")
    assert placed.attributes["kind"] == "mask" and (placed.channels, placed.bits) == (("Y",), 16)
    expected = np.zeros((30, 40))
    motif = nm.read_normal_map("motif.exr")
    expected[:10, :10] = motif.coverage[10:, 10:]
    assert np.array_equal(placed.pixels[..., 0], expected * 65535)
    assert (curl.attributes["kind"], curl.attributes["black"], curl.attributes["white"]) == ("curl", "0.001", "1.0")
    assert np.array_equal(curl.pixels, nm.curl_picture(result.map))
    assert (curl.pixels[12:, 12:] == curl.pixels[-1, -1]).all()  # a plate has no curl: one dark colour
    assert curl.pixels[-1, -1].max() < 10 < 200 < curl.pixels[:9, :9].max()
    assert (made("paste", "plate.png", "motif.exr", "--mask", "top.png").map.coverage == 1).all()


def test_a_placed_image_serves_as_mask_of_a_relief(made, run, place):
    nm.write_normal_map(bump_map(30, 40, height=0.2), "hill.exr")
    made("paste", "hill.exr", "motif.exr", "--placed", "p.png")
    words = ("--mask", "p.png", "--background", "surface", "--surface", "hill.exr", "-o", "r.exr")
    assert run("relief", "out.exr", *words).code == 0


@pytest.mark.parametrize("out", ["out.png", "out.exr", "out.tif"])
@pytest.mark.parametrize("command", ["blend", "paste", "transform"])
def test_every_file_holds_its_recipe(made, command, out):
    words = {
        "blend": ("plate.png", "detail.exr", "--strength", "0.5"),
        "paste": ("plate.png", "motif.exr", "--rotate", "-30", "--feather", "2px"),
        "transform": ("plate.png", "--rotate", "-90", "--height-factor", "-1"),
    }[command]
    report = json.loads(made(command, *words, "--json", out=out).out)
    attributes = nm.read_raster(out).attributes
    recipe = json.loads(attributes["recipe"])
    assert recipe == {key: report[key] for key in ("command", "options", "layers")}
    assert recipe["command"] == command
    assert (attributes["kind"], attributes["green"], attributes["pitch_mm"]) == ("normal", "up", "0.5")
    assert attributes["version"] == nm.__version__


def test_a_map_is_read_back_as_it_was_written(made):
    whole = made("blend", "base.exr", "detail.exr").map.normals
    for words, out, step in (
        (("--write-green", "down"), "a.exr", 0),
        (("--bits", "half"), "b.exr", 2**-11),
        (("--bits", "float"), "c.tif", 0),
        (("--write-green", "down"), "d.png", 2 / 65535),
        (("--bits", "8", "--write-zero-code", "128"), "e.png", 2 / 255),
    ):
        made("blend", "base.exr", "detail.exr", *words, out=out)
        assert np.abs(nm.read_normal_map(out).normals - whole).max() <= 2 * step, out


def test_a_flag_of_paste_applies_to_all_layers_or_to_one_each(made):
    def laid(*words):
        report = json.loads(made("paste", "plate.png", "motif.exr", "motif.exr", "--json", *words).out)
        return report["placing"]

    once = laid("--rotate", "-30", "--flip-h", "--at", "-2px,5px", "--scale", "0.5,0.7", "--clip", "yes")
    assert once[0] == once[1]
    assert (once[0]["rotate"], once[0]["flip_h"], once[0]["flip_v"], once[0]["at"]) == (-30, True, False, "-2px,5px")
    assert (once[0]["scale"], once[0]["clip"], once[0]["feather"]) == ("0.5,0.7", "yes", None)
    each = laid("--rotate=-30", "--rotate", "-1e1", "--feather", "2px", "--feather", "5%", "--anchor", "top")
    assert [layer["rotate"] for layer in each] == [-30, -10]
    assert [layer["feather"] for layer in each] == ["2px", "5%"]
    assert [layer["anchor"] for layer in each] == ["top", "top"]
    # layers and flags in any order
    assert laid("--strength", "0.25", "--height-factor", "-1")[1]["height_factor"] == -1
    mixed = json.loads(
        made("paste", "--at", "0,0", "plate.png", "--at", "10px,0", "motif.exr", "motif.exr", "--json").out
    )
    assert [layer["at"] for layer in mixed["placing"]] == ["0,0", "10px,0"]


def test_the_paste_command_gives_the_result_of_the_library(made):
    words = (
        "--at",
        "-2px,12px",
        "--at",
        "30mm,50%",
        "--rotate",
        "-30",
        "--mask",
        "top.png",
        "--mode",
        "over",
        "--mode",
        "pd",
    )
    result = made("paste", "plate.png", "motif.exr", "motif.exr", *words, "--width", "40mm")
    motif, mask = nm.read_normal_map("motif.exr"), nm.read_grey("top.png")
    how = ({"at": "-2px,12px"}, {"at": "30mm,50%", "mode": "pd"})
    layers = [nm.Layer(motif, nm.LayerOptions(rotate=-30, **each), mask) for each in how]
    expected = nm.paste(nm.read_normal_map("plate.png"), layers, width=nm.length("40mm")).normal_map
    assert np.array_equal(result.map.normals, expected.normals)
    assert result.map.frame.pitch_mm == 1.0


def test_layers_of_an_exr_are_given_by_name(made, place):
    names = ("original", "base", "detail")
    maps = [as_map(random_normals(30, 40, seed=seed)) for seed in range(3)]
    write_pictures([normal_picture(m, 32, name=n) for m, n in zip(maps, names, strict=True)], place / "maps.exr")
    result = made("blend", "maps.exr:base", "maps.exr:detail", "--report", "r.json")
    assert np.array_equal(result.map.normals, nm.blend(maps[1], maps[2]).normal_map.normals)
    assert json.loads((place / "r.json").read_text(encoding="utf-8"))["layers"][0]["name"] == "maps.exr:detail"
    assert np.array_equal(
        made("blend", "maps.exr", "detail.exr", "--layer", "base", "--strength", "0").map.normals, maps[1].normals
    )
    pasted = made("paste", "maps.exr", "motif.exr", "--layer", "base", "--at", "0,0").map
    assert np.array_equal(pasted.normals[20:], maps[1].normals[20:])
    assert np.array_equal(
        made("transform", "maps.exr:DETAIL", "--flip-v").map.normals[..., 0], maps[2].normals[::-1, :, 0]
    )


def test_a_detail_map_of_another_size_is_stretched_with_fit(made, place):
    nm.write_normal_map(bump_map(15, 20), "small.exr")
    fitted = made("blend", "base.exr", "small.exr", "--fit").map
    assert np.array_equal(
        fitted.normals,
        nm.blend(*map(nm.read_normal_map, ("base.exr", "small.exr")), nm.BlendOptions(fit=True)).normal_map.normals,
    )


def test_stderr_reports_sizes_curl_and_times(made, run, place):
    stated = made("paste", "plate.png", "motif.exr", "-v").err.splitlines()
    assert stated[0].startswith("plate.png: 40 x 30, background flat (found), motif 0%")
    assert stated[2] == "  motif.exr: over at 10,5 px, 20 x 20, on 21% of the canvas"
    assert stated[3].startswith("  paste: 40 x 30, pitch 0.5 mm, mean |curl| ") and stated[3].endswith(
        "(before 0.0000)"
    )
    assert stated[4].startswith("  seconds compose ")
    assert stated[5] == "  wrote out.exr"
    assert "seconds" not in made("paste", "plate.png", "motif.exr").err
    quiet = made("paste", "plate.png", "motif.exr", "-q", "-v")
    assert (quiet.out, quiet.err) == ("", "")
    nm.write_normal_map(as_map(random_normals(10, 10), pitch_mm=1.0), "coarse.exr")
    warned = made("paste", "plate.png", "coarse.exr").err
    assert "nmap: warning: coarse.exr: its pixels are 1 mm, those of the canvas 0.5 mm" in warned


def test_a_file_is_replaced_only_with_overwrite(run, place):
    (place / "out.exr").write_text("old", encoding="utf-8")
    for command, words in (("blend", ("base.exr", "detail.exr")), ("transform", ("base.exr",))):
        assert run("compose", command, *words, "-o", "out.exr").code == 5
        assert run("compose", command, *words, "-o", "out.exr", "--overwrite").code == 0
    assert sorted(p.name for p in place.iterdir() if p.name.startswith((".", "out"))) == ["out.exr"]


def test_the_same_command_writes_the_same_normals(made):
    first = made("paste", "base.exr", "motif.exr", "--rotate", "33", "--feather", "3px", "--scale", "1.3").map
    second = made("paste", "base.exr", "motif.exr", "--rotate", "33", "--feather", "3px", "--scale", "1.3").map
    assert np.array_equal(first.normals, second.normals)


@pytest.mark.skipif(sys.platform == "win32", reason="quotes for a POSIX shell, and a pipe that breaks as POSIX says")
def test_a_reader_that_closes_the_pipe_causes_no_message(place):
    script = f"{sys.executable} -c '{NMAP}' compose blend base.exr detail.exr -o - -q | head -c 4"
    done = subprocess.run(["bash", "-c", script], capture_output=True, check=False)
    assert (done.stdout, done.stderr) == (b"\x76\x2f\x31\x01", b"")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full")  # noqa: PTH110
@pytest.mark.parametrize(
    "words",
    [
        "compose blend base.exr detail.exr -q -o -",
        "compose blend base.exr detail.exr -q -o x.exr --json",
        "inspect base.exr",
        "relief --help",
        "--version",
    ],
)
def test_a_full_standard_output_is_an_error(place, words):
    script = f"{sys.executable} -c '{NMAP}' {words} > /dev/full"
    done = subprocess.run(["bash", "-c", script], capture_output=True, check=False)
    assert done.returncode == 5
    assert done.stderr == b"nmap: error: standard output: cannot be written (No space left on device)\n"
