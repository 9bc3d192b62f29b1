"""Failures at the command line: the exit code, one clear line, and nothing left behind."""

import io
import json
import os
import re
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from cli_cases import LONG_NAMES

USAGE, INPUT, LIMIT, OUTPUT, NOT_CONVERGED, INTERRUPTED = 2, 3, 4, 5, 7, 130
FULL_DISK = (
    "import resource, signal, sys\n"
    "from nmaptool_cli.main import main\n"
    "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
    "resource.setrlimit(resource.RLIMIT_FSIZE, (500, 500))\n"
    "for path in sys.argv[2:]:\n"
    "    flag = '--report' if path.endswith('.json') else '-o'\n"
    "    print(main(['relief', sys.argv[1], '-q', '--overwrite', flag, path]))\n"
)
CTRL_C = (
    "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
    "from nmaptool.io.pictures import reader as images\nfrom nmaptool.io.solids import writer\n"
    "from nmaptool_cli.main import main\n"
    "def interrupted(solid, path, **more):\n"
    "    path.write_bytes(bytes(99))\n"
    "    signal.raise_signal(signal.SIGINT)\n"
    "writer.write_solid = interrupted\n"
    "sys.exit(main(sys.argv[1:]))\n"
)


def in_a_process(script, *words):
    done = subprocess.run(
        [sys.executable, "-c", script, *map(str, words)], capture_output=True, text=True, check=False, timeout=60
    )
    return SimpleNamespace(code=done.returncode, out=done.stdout, err=done.stderr)


BAD_MAPS = [
    ("missing", INPUT, r"missing\.png: no such file"),
    ("empty", INPUT, r"empty\.png: is empty"),
    ("text", INPUT, r"text\.png: is not a picture"),
    ("folder", INPUT, r"folder\.png: is a folder"),
    ("cut", INPUT, r"cut\.png: .*truncated or damaged"),
    ("wrong", INPUT, r"wrong\.png: holds EXR data; rename it to wrong\.exr"),
    ("nan", INPUT, r"nan\.exr: found 1 pixel with NaN .* x=30, y=20"),
    ("one", INPUT, r"one\.png: has 1 channel.*needs red, green and blue"),
    ("two", INPUT, r"two\.png: has 2 channel.*needs red, green and blue"),
    ("huge", LIMIT, r"huge\.png: 100000 x 100000 is 10000 megapixels.*--max-megapixels"),
    ("hollow", INPUT, r"hollow\.png: .*truncated or damaged"),
]


@pytest.mark.parametrize(("name", "code", "pattern"), BAD_MAPS, ids=[bad[0] for bad in BAD_MAPS])
def test_an_unusable_map_is_refused(refused, maps, tmp_path, name, code, pattern):
    refused(code, pattern, "inspect", maps[name])
    refused(code, pattern, "inspect", maps[name], "--json")
    refused(code, pattern, "relief", maps[name], "-o", tmp_path / "out.stl", "--preview", tmp_path / "view.png")
    refused(code, pattern, "relief", maps["clean"], "--detail", maps[name], "-o", tmp_path / "out.stl")


@pytest.mark.parametrize("name", ["flat", "clear"])
def test_a_map_that_is_all_background_is_refused(refused, maps, tmp_path, name):
    pattern = rf"{name}\.png: every pixel is background .*--background-color none"
    refused(INPUT, pattern, "relief", maps[name], "-o", tmp_path / "out.exr")


@pytest.mark.parametrize("flag", ["--detail", "--mask", "--mu-map", "--beta-map", "--delta-map", "--surface"])
def test_a_companion_map_of_another_size_is_refused(refused, maps, tmp_path, flag):
    other = maps["small" if flag in ("--detail", "--surface") else "small-mask"]
    more = {"--surface": ("--background", "surface"), "--mu-map": ("--detail", maps["clean"])}.get(flag, ())
    pattern = r"clean\.png is 96 x 96 .*80 x 64.*make them the same"
    refused(INPUT, pattern, "relief", maps["clean"], flag, other, *more, "-o", tmp_path / "out.stl")


@pytest.mark.parametrize("flag", ["--mask", "--mu-map", "--beta-map", "--delta-map", "--surface"])
@pytest.mark.parametrize("name", ["missing", "cut", "text", "folder", "huge"])
def test_a_companion_map_that_cannot_be_read_is_refused(refused, maps, tmp_path, flag, name):
    more = ("--background", "surface") if flag == "--surface" else ()
    code = LIMIT if name == "huge" else INPUT
    refused(code, rf"{name}\.png: ", "relief", maps["clean"], flag, maps[name], *more, "-o", tmp_path / "out.stl")


def test_a_mask_that_selects_nothing_is_refused(refused, maps, tmp_path):
    words = ("relief", maps["clean"], "-o", tmp_path / "out.stl", "--mask")
    refused(INPUT, r"mask.* selects nothing: paint the motif white", *words, maps["black"])
    refused(INPUT, r"mask.* selects only background \(alpha\) of .*clean\.png", *words, maps["corner"])
    refused(INPUT, r"mask.* selects nothing", "inspect", maps["clean"], "--mask", maps["black"])
    refused(INPUT, r"96 x 96 .*80 x 64", "inspect", maps["clean"], "--mask", maps["small-mask"])


@pytest.mark.parametrize("data", [b"PK\3\4....", b"hello", b"", b"\x93NUMPY\1\0", b"\x93NUMPY\1\0\x76\0{'a"])
def test_a_file_that_is_not_a_height_file_is_refused(refused, maps, tmp_path, data):
    (tmp_path / "ground.npy").write_bytes(data)
    words = ("relief", maps["clean"], "--background", "surface", "-o", tmp_path / "out.stl")
    refused(INPUT, r"ground\.npy: ", *words, "--surface", tmp_path / "ground.npy")


def test_a_height_file_that_claims_too_many_pixels_is_refused(refused, maps, tmp_path):
    head = b"{'descr': '<f8', 'fortran_order': False, 'shape': (100000, 100000), }".ljust(117) + b"\n"
    (tmp_path / "ground.npy").write_bytes(b"\x93NUMPY\1\0\x76\0" + head + bytes(64))
    words = ("relief", maps["clean"], "--background", "surface", "-o", tmp_path / "out.stl")
    refused(LIMIT, r"ground\.npy: 100000 x 100000 .*--max-meg", *words, "--surface", tmp_path / "ground.npy")


def test_the_size_limit_applies_to_a_curved_background(refused, clean_map, tmp_path, png):
    hollow = png(tmp_path / "ground.png", np.zeros((2, 2), np.uint8), size=(16_700, 16_700))
    words = ("relief", clean_map, "--background", "surface", "-o", tmp_path / "out.stl", "--surface", hollow)
    refused(LIMIT, r"ground\.png: 16700 x 16700 is 279 megapixels, more than the limit of 270", *words)
    refused(INPUT, r"ground\.png: .*truncated or damaged", *words, "--max-megapixels", "300")


BAD_WORDS = [
    (("--height", "0mm"), r"0mm.*greater than zero"),
    (("--height", "-3mm"), r"-3mm.*greater than zero"),
    (("--height=-3mm",), r"-3mm.*greater than zero"),
    (("--height", "3"), r"--height 3: expected a number with a unit .*such as 12mm or 3%"),
    (("--height", "mm"), r"--height mm: expected a number with a unit"),
    (("--height", "3 furlongs"), r"expected a number with a unit"),
    (("--height", "1e999mm"), r"1e999mm"),
    (("--height", "1e40mm"), r"1e\+?40mm"),
    (("--width", "0mm"), r"0mm.*greater than zero"),
    (("--width", "100"), r"--width 100: expected a number with a unit"),
    (("--width", "50%"), r"--width 50%: .*give it in mm, cm, m or in"),
    (("--width", "400px"), r"--width 400px: .*give it in mm, cm, m or in"),
    (("--mu", "-1"), r"--mu=-1: must be zero or more"),
    (("--beta", "nan"), r"--beta nan: must be"),
    (("--delta", "inf"), r"--delta inf: must be"),
    (("--mu", "much"), r"--mu.*much"),
    (("--slope-cap", "0"), r"--slope-cap 0: must be greater than zero"),
    (("--tolerance", "0"), r"--tolerance 0: must lie between"),
    (("--max-iterations", "0"), r"--max-iterations 0: must be at least 1"),
    (("--max-megapixels", "0"), r"--max-megapixels 0: must be greater than zero"),
    (("--background", "round"), r"round.*--background.*plane"),
    (("--background", "surface"), r"--background surface: needs .*--surface"),
    (("--surface", "clean.png"), r"--surface: needs --background surface"),
    (("--background-color", "pink"), r"--background-color pink: use one of auto, none"),
    (("--swizzle", "r,g"), r"--swizzle r,g: give the channels"),
    (("--swizzle", "-g,r"), r"--swizzle=-g,r: give the channels"),
    (("--green", "left"), r"left.*--green.*up"),
    (("--solver", "dct"), r"--solver dct: needs a map without background"),
    (("--fit", "slope"), r"--fit slope: needs --height"),
    (("--frobnicate",), r"--frobnicate"),
    (("second.png",), r"second\.png"),
    (("-o", "out.jpg"), r"out\.jpg: ends in \.jpg; a relief is written as .*\.stl"),
    (("-o", "out"), r"out: has no ending; a relief is written as"),
    (("--preview", "view.jpg"), r"view\.jpg: a preview is written as \.png"),
    (("-o", "./out.stl"), r"out\.stl: is named twice"),
    (("--report", "out.stl"), r"out\.stl: is named twice"),
    (("--preview", "x.png", "-o", "x.png"), r"x\.png: is named twice"),
]
BAD_TARGETS = [
    ("none/out.exr", r"none/out\.exr: the folder none does not exist"),
    ("clean.png/out.exr", r"clean\.png/out\.exr: .*clean\.png"),
    ("folder.npy", r"folder\.npy: is a folder"),
    ("clean.png", r"clean\.png: already exists; give another name, or --overwrite"),
    pytest.param("n" * 300 + ".exr", r"(?i)too long", marks=LONG_NAMES, id="nnn"),
]


@pytest.mark.parametrize(("words", "pattern"), BAD_WORDS, ids=[" ".join(bad[0]) for bad in BAD_WORDS])
def test_wrong_arguments_are_refused(refused, clean_map, tmp_path, monkeypatch, words, pattern):
    monkeypatch.chdir(tmp_path)
    refused(USAGE, pattern, "relief", "clean.png", "-o", "out.stl", *words)


@pytest.mark.parametrize(("target", "pattern"), BAD_TARGETS, ids=lambda word: word[:20])
def test_a_target_that_cannot_be_written_is_refused(refused, clean_map, tmp_path, monkeypatch, target, pattern):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.npy").mkdir()
    for flag in ("-o", "--report", *(["--preview"] if target == "clean.png" else [])):
        refused(OUTPUT, pattern, "relief", "clean.png", "-o", "out.stl", flag, target)


def test_a_solve_that_does_not_converge_is_an_error(refused, clean_map, tmp_path):
    words = (
        "relief",
        clean_map,
        "-o",
        tmp_path / "out.stl",
        "--report",
        tmp_path / "out.json",
        "--max-iterations",
        "1",
    )
    refused(NOT_CONVERGED, r"residual of .* after 1 iteration.*raise --max-iterations.*history: ", *words)


def test_missing_arguments_are_named(run, refused, clean_map, tmp_path):
    assert "relief" in run().out
    refused(USAGE, "frobnicate", "frobnicate")
    refused(USAGE, "MAP is missing", "inspect")
    refused(USAGE, "MAP is missing", "relief", "-o", tmp_path / "out.stl")
    refused(USAGE, "no output given: add one, such as -o", "relief", clean_map)


def test_existing_outputs_are_kept_without_overwrite(refused, run, tree, clean_map, tmp_path):
    old = tmp_path / "old.exr"
    old.write_text("precious", encoding="utf-8")
    words = ("relief", clean_map, "-o", tmp_path / "new.stl", "-o", old)
    refused(OUTPUT, r"old\.exr: already exists; give another name, or --overwrite", *words)
    assert run(*words, "--overwrite").code == 0
    assert sorted(tree()) == ["clean.png", "new.stl", "old.exr"]
    assert old.read_bytes().startswith(b"\x76\x2f\x31\x01")


def test_an_output_that_appears_meanwhile_is_kept_and_none_is_written(refused, clean_map, tmp_path, monkeypatch):
    (tmp_path / "view.png").write_text("hers", encoding="utf-8")
    monkeypatch.setattr("nmaptool.io.output.targets.check_place", lambda *_: None)
    words = ("relief", "-q", clean_map, "-o", tmp_path / "out.exr", "--preview", tmp_path / "view.png")
    refused(OUTPUT, r"view\.png: already exists", *words)


def test_a_folder_that_cannot_be_written_to_is_refused(refused, clean_map, tmp_path, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode, **_: not mode & os.W_OK)
    refused(OUTPUT, r"out\.stl: the folder .* cannot be written to", "relief", clean_map, "-o", tmp_path / "out.stl")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no limit to a file's size")
def test_a_full_disk_leaves_no_file(tree, clean_map, tmp_path):
    paths = [tmp_path / f"old.{ending}" for ending in ["exr", "tif", "npy", "png", "stl", "ply", "obj", "glb", "json"]]
    for path in paths:
        path.write_text("precious", encoding="utf-8")
    before = tree()
    done = in_a_process(FULL_DISK, clean_map, *paths)
    assert done.out.split() == [str(OUTPUT)] * len(paths)
    stated = done.err.splitlines()
    assert len(stated) == len(paths)
    for path, line in zip(paths, stated, strict=True):
        assert re.fullmatch(rf"nmap: error: {path}: cannot be written \(.+\)", line)
        assert "None" not in line
    assert tree() == before


def test_ctrl_c_while_writing_leaves_no_file(tree, fails, clean_map, tmp_path):
    before = tree()
    words = ("-o", tmp_path / "a.exr", "-o", tmp_path / "b.stl", "--report", tmp_path / "c.json")
    result = in_a_process(CTRL_C, "relief", "-q", clean_map, *words)
    assert tree() == before
    fails(result, INTERRUPTED, "interrupted; nothing was written")


@pytest.mark.parametrize("place", ["nmaptool.figures.preview.preview", "nmaptool.reliefs.session.prepare"])
def test_ctrl_c_at_any_stage_leaves_no_file(refused, clean_map, tmp_path, monkeypatch, place):
    monkeypatch.setattr(place, lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
    words = ("-q", "-o", tmp_path / "a.exr", "--preview", tmp_path / "b.png")
    refused(INTERRUPTED, "interrupted; nothing was written", "relief", clean_map, *words)


def test_standard_input_is_read_like_a_file(run, tree, fails, clean_map, tmp_path, monkeypatch):
    before = tree()

    def given(data):
        monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=io.BytesIO(data)))

    given(clean_map.read_bytes())
    result = run("inspect", "-")
    assert (result.code, result.err) == (0, "")
    assert "96 x 96, 16 bit" in result.out
    given(clean_map.read_bytes())
    assert run("relief", "-", "-o", tmp_path / "out.stl").code == 0
    (tmp_path / "out.stl").unlink()
    for data, pattern in ((b"", r"standard input.* is empty"), (b"hello", r"(-|standard input): is not a picture")):
        given(data)
        fails(run("inspect", "-"), INPUT, pattern)
    given(clean_map.read_bytes())
    fails(run("relief", "-", "--mask", "-", "-o", tmp_path / "out.stl"), INPUT, r"standard input.* read only once")
    monkeypatch.setattr(sys, "stdin", None)  # closed, as "<&-" leaves it
    fails(run("inspect", "-"), INPUT, r"standard input.* is (empty|closed)")
    assert tree() == before


def test_the_report_goes_to_standard_output(run, tree, clean_map, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run("relief", clean_map, "--report", "-", "-q")
    assert sorted(tree()) == ["clean.png"]
    assert (result.code, result.err) == (0, "")
    assert json.loads(result.out)["solver"] == "multigrid"


def test_names_outside_ascii_are_accepted(run, refused, clean_map, tmp_path):
    path = clean_map.rename(tmp_path / "größe 頭.png")
    assert run("inspect", path).code == 0
    assert run("relief", path, "-o", tmp_path / "höhe.exr", "-o", tmp_path / "höhe.stl").code == 0
    latin = (tmp_path / "höhe.exr").rename(tmp_path / os.fsdecode(b"caf\xe9.exr"))  # not even text
    for words in (("inspect", latin), ("relief", path, "--overwrite", "-o", latin)):
        result = run(*words)
        assert "bug" not in result.err
        assert result.code in (0, INPUT, OUTPUT)


def test_an_output_may_have_the_longest_name_allowed(run, tree, clean_map, tmp_path):
    name = "n" * 251 + ".stl"
    assert run("relief", clean_map, "-o", tmp_path / name).code == 0
    assert sorted(tree()) == ["clean.png", name]
