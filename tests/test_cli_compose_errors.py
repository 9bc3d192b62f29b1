"""Failures of the compose commands: the exit code, one clear line, and no changed file."""

import io
import os
import random
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from cli_cases import bad_targets, disk_that_fills, fail_with
from compose_cases import as_map, bump_map, flat_map, random_normals

import nmaptool as nm

USAGE, INPUT, LIMIT, OUTPUT, BUG, INTERRUPTED = 2, 3, 4, 5, 70, 130


@pytest.fixture
def place(tmp_path, monkeypatch, png, picture):
    """The working folder of the commands, with a base, a detail, a motif, masks and files of other kinds."""
    monkeypatch.chdir(tmp_path)
    disc = np.hypot(*(np.mgrid[0:20, 0:20] - 9.5)) < 9
    nm.write_normal_map(bump_map(30, 40), "base.exr")
    nm.write_normal_map(as_map(random_normals(30, 40, seed=1)), "detail.exr")
    nm.write_normal_map(flat_map(30, 40, pitch_mm=0.5), "plate.png")
    nm.write_normal_map(as_map(random_normals(20, 20, seed=2), disc), "motif.exr")
    nm.write_normal_map(as_map(random_normals(20, 20), np.zeros((20, 20))), "clear.exr")
    bad = random_normals(30, 40)
    bad[4, 7] = np.nan, np.inf, 1
    picture(tmp_path / "nan.exr", bad)
    picture(tmp_path / "one.exr", bad[..., 2:] * 0, names=("Y",))
    picture(tmp_path / "nan-mask.exr", np.full((30, 40, 1), np.nan, np.float32), names=("Y",))
    picture(tmp_path / "wide-mask.exr", np.full((30, 40, 1), 1.5, np.float32), names=("Y",))
    png(tmp_path / "black.png", np.zeros((30, 40), np.uint8))
    png(tmp_path / "black20.png", np.zeros((20, 20), np.uint8))
    png(tmp_path / "small.png", np.full((5, 6), 255, np.uint8))
    png(tmp_path / "color.png", np.zeros((30, 40, 3), np.uint8) + np.uint8([1, 99, 200]))
    png(tmp_path / "huge.png", np.zeros((2, 2, 3), np.uint8), size=(90_000, 90_000))
    (tmp_path / "text.png").write_text("hello", encoding="utf-8")
    (tmp_path / "empty.exr").touch()
    (tmp_path / "folder.exr").mkdir()
    (tmp_path / "file").write_text("precious", encoding="utf-8")
    (tmp_path / "old.exr").write_text("precious", encoding="utf-8")
    (tmp_path / "old.png").write_text("precious", encoding="utf-8")
    return tmp_path


BLEND, PASTE, TRANSFORM = "blend base.exr detail.exr", "paste base.exr motif.exr", "transform base.exr"
NUMBER = "expected a number with a unit"
BAD_WORDS = [
    (BLEND, "--mode screen", r'"screen" for --mode\. Choose from: "rnm", "pd"'),
    (BLEND, "--mode over", r'"over" for --mode'),
    (BLEND, "--strength -1", r"--strength=-1: must be zero or more"),
    (BLEND, "--strength nan", r"--strength nan: must be zero or more"),
    (BLEND, "--strength much", r"--strength 'much': must be a number"),
    (BLEND, "--fit=perhaps", r'--fit: unable to convert "perhaps"'),
    (BLEND, "third.exr", r"third\.exr: unexpected argument \(see nmap compose blend --help\)$"),
    (BLEND, "--frobnicate", r"--frobnicate"),
    (BLEND, "--bits 12", r'"12" for --bits'),
    (BLEND, "--bits 8", r"out\.exr: --bits 8 is not supported for \.exr; use float or half"),
    (BLEND, "--write-green left", r'"left" for --write-green'),
    (BLEND, "--curl c.jpg", r"c\.jpg: the curl picture is written as \.png"),
    (BLEND, "--curl -", r"-: pictures are written to files, such as --curl curl\.png"),
    (BLEND, "--report r.txt", r"r\.txt: a report is written as \.json"),
    (BLEND, "--max-megapixels 0", r"--max-megapixels 0: must be greater than zero"),
    (BLEND, "--background-color pink", r"--background-color pink: use one of"),
    (PASTE, "--mode screen", r"--mode screen: use one of over, rnm, pd, whiteout, udn, linear, overlay"),
    (PASTE, "--anchor middle", r"--anchor middle: use one of center, top-left"),
    (PASTE, "--clip perhaps", r"--clip perhaps: use one of auto, yes, no"),
    (PASTE, "--at 5px", r"--at 5px: expected 2 distances separated by commas, such as 30%,12mm"),
    (PASTE, "--at 5,6", rf"--at 5,6: distance '5': {NUMBER}"),
    (PASTE, "--at -5px,x", rf"--at=-5px,x: distance 'x': {NUMBER}"),
    (PASTE, "--at 1e9px,0", r"--at .*: distance 1000000000px: must be a number of at most 1e\+06"),
    (PASTE, "--at 0,0 --at 0,0", r"--at: given 2 times for 1 layers; give it once, or once for each layer"),
    (PASTE, "motif.exr motif.exr --mask a --mask b", r"--mask: given 2 times for 3 layers"),
    (PASTE, "--scale 0", r"--scale 0: expected one or two factors between 0\.001 and 1000"),
    (PASTE, "--scale -2", r"--scale=-2: expected one or two factors"),
    (PASTE, "--scale 1,2,3", r"--scale 1,2,3: expected one or two"),
    (PASTE, "--scale wide", r"--scale wide: expected one factor, two separated by a comma, or a width such as 30mm"),
    (PASTE, "--scale 1e6px", r"--scale 1000000px: is 5e\+04 times the layer's size; use 0\.001 to 1000 times"),
    (PASTE, "--scale 5mm", r"--scale 5mm: the size of .* not known; give --width 100mm"),
    (PASTE, "--at 5mm,0", r"motif\.exr: 5mm: the size of a pixel is not known; give --width 100mm, or use px or %"),
    (PASTE, "--feather 5mm", r"motif\.exr: 5mm: the size of a pixel is not known"),
    (PASTE, "--feather -5px", r"--feather=-5px: must be zero or more, such as 6px"),
    (PASTE, "--feather soft", rf"--feather soft: {NUMBER}"),
    (PASTE, "--rotate inf", r"--rotate inf: must lie between -3600 and 3600, such as 30"),
    (PASTE, "--rotate 10,20", r"--rotate '10,20': must be a number"),
    (PASTE, "--strength 1.5", r'--strength 1\.5: must lie between 0 and 1 for the mode "over"'),
    (PASTE, "--height-factor nan", r"--height-factor nan: must lie between -1000 and 1000"),
    (PASTE, "--width 10%", r"--width 10%: .*give it in mm, cm, m or in"),
    (PASTE, "--placed p.exr", r"p\.exr: the placed picture is written as \.png"),
    (PASTE, "--curl a.png --placed ./a.png", r"a\.png: is named twice as an output"),
    (PASTE, "--name foo", r"Unknown option: --name"),
    (TRANSFORM, "--crop 1,2", r"--crop 1,2: expected 4 distances"),
    (TRANSFORM, "--crop 0,0,-5px,5px", r"--crop 0,0,-5px,5px: width and height must be greater than zero"),
    (TRANSFORM, "--crop 3mm,0,3mm,3mm", r"3mm: the size of a pixel is not known; give --width 100mm"),
    (TRANSFORM, "--pad -3px", r"--pad=-3px: must be zero or more; cut with --crop"),
    (TRANSFORM, "--resize 10", r"--resize 10: expected columns x rows in px, such as 1000x900"),
    (TRANSFORM, "--resize -9x9", r"--resize=-9x9: expected columns x rows"),
    (TRANSFORM, "--resize 9x9 --scale 2", r"--resize and --scale both set the size of the result"),
    (TRANSFORM, "--affine -1,0,0", r"--affine=-1,0,0: expected four numbers"),
    (TRANSFORM, "--affine 1,2,2,4", r"--affine 1,2,2,4: is singular"),
    (TRANSFORM, "--scale 0.000001px", r"--scale 1e-06px: is 2\.5e-08 times the layer's size; use 0\.001 to 1000 times"),
    (TRANSFORM, "--ground stone", r'"stone" for --ground'),
    (TRANSFORM, "--vectors-only --pad 1px", r"--vectors-only does not move pixels"),
    (TRANSFORM, "--width -3mm", r"--width=-3mm: must be greater than zero"),
    (TRANSFORM, "second.exr", r"second\.exr: unexpected argument \(see nmap compose transform --help\)$"),
]


@pytest.mark.parametrize(("start", "words", "pattern"), BAD_WORDS, ids=[f"{b[0][:5]} {b[1]}" for b in BAD_WORDS])
def test_wrong_arguments_are_refused(refused, place, start, words, pattern):
    refused(USAGE, pattern, "compose", *start.split(), "-o", "out.exr", *words.split())


def test_missing_arguments_are_named(refused, place):
    refused(USAGE, "DETAIL is missing", "compose", "blend", "base.exr", "-o", "out.exr")
    no_layers = "no layers given: add one or more after the background"
    refused(USAGE, no_layers, "compose", "paste", "base.exr", "-o", "out.exr")
    refused(USAGE, "MAP is missing", "compose", "transform", "-o", "out.exr")
    refused(USAGE, "frobnicate", "compose", "frobnicate")
    for start in (BLEND, PASTE, TRANSFORM):
        refused(USAGE, r"no output given: add one, such as -o map\.exr", "compose", *start.split())
    one_stream = r"-: the map and the report cannot both go to standard output; write one of them to a file"
    refused(USAGE, one_stream, "compose", *BLEND.split(), "-o", "-", "--json")
    refused(USAGE, one_stream, "compose", *BLEND.split(), "--output=-", "--report=-")


BAD_INPUTS = {
    (INPUT, "blend"): [
        ("missing.exr detail.exr", r"missing\.exr: no such file"),
        ("base.exr folder.exr", r"folder\.exr: is a folder"),
        ("base.exr empty.exr", r"empty\.exr: is empty"),
        ("text.png detail.exr", r"text\.png: is not a picture"),
        ("base.exr nan.exr", r"nan\.exr: found 1 pixel with NaN .* x=7, y=4; repair them or make"),
        ("one.exr detail.exr", r"one\.exr: has 1 channel \(Y\); a normal map needs red, green and blue"),
        ("base.exr motif.exr", r"motif\.exr is 20 x 20, but base\.exr is 40 x 30; stretch it with --fit, or"),
        ("base.exr detail.exr:fine", r"detail\.exr: has no layer 'fine'; it holds: "),
        ("base.exr detail.exr --layer fine", r"base\.exr: has no layer 'fine'"),
    ],
    (LIMIT, "blend"): [("huge.png detail.exr", r"huge\.png: 90000 x 90000 is 8100 megapixels")],
    (INPUT, BLEND): [
        ("--mask missing.png", r"missing\.png: no such file"),
        ("--mask color.png", r"color\.png: is a colour picture; a mask .* must be grey"),
        ("--mask small.png", r"small\.png: the mask of detail\.exr is 6 x 5, expected 40 x 30.*resize it"),
        ("--mask black.png", r"black\.png: the mask of detail\.exr is entirely black"),
        ("--mask nan-mask.exr", r"nan-mask\.exr: holds NaN or infinite values; repair them"),
        ("--mask wide-mask.exr", r"wide-mask\.exr: the mask of detail\.exr must .*0 and 1, but .*1\.5"),
    ],
    (INPUT, "paste"): [
        ("base.exr missing.exr", r"missing\.exr: no such file"),
        ("one.exr motif.exr", r"one\.exr: has 1 channel"),
        ("base.exr clear.exr", r"clear\.exr: covers no pixel of the canvas; .*alpha"),
        ("motif.exr detail.exr --at 0,0 --scale .1 --mode rnm", r"detail\.exr: mode \"rnm\" needs a surface below it"),
    ],
    (INPUT, PASTE): [
        ("nan.exr", r"nan\.exr: found 1 pixel with NaN"),
        ("--mask black20.png", r"black20\.png: the mask of motif\.exr is entirely black"),
        ("--mask black.png", r"black\.png: the mask of motif\.exr is 40 x 30, expected 20 x 20"),
        ("--at 100px,0", r"motif\.exr: its area from 90,-10 to 110,10 px is outside the canvas of 40 x 30 px"),
        ("--at=-9px,-9px --anchor right", r"motif\.exr: its area from .* is outside the canvas"),
        ("--scale 0.001", r"motif\.exr: covers no pixel of the canvas; .*scale"),
    ],
    (LIMIT, PASTE): [("--max-megapixels 0.001", r"base\.exr: 40 x 30 is 0\.0012 megapixels, more than the limit")],
    (INPUT, "transform"): [("missing.exr", r"missing\.exr: no such file")],
    (INPUT, TRANSFORM): [
        ("--crop 0,0,50px,9px", r"base\.exr: --crop 0,0,50px,9px is 50 x 9 px at 0,0, .*40 x 30 px"),
        ("--crop -1px,0,9px,9px", r"base\.exr: --crop=.* is 9 x 9 px at -1,0, .*; to enlarge a picture, use --pad"),
    ],
    (LIMIT, TRANSFORM): [
        ("--scale 1000", r"base\.exr: the result of 40000 x 30000 px exceeds .*--max-megapixels"),
        ("--pad 1e6%", r"base\.exr: the result of \d+ x \d+ px exceeds the limit of 270"),
        ("--resize 40000x2", r"base\.exr: has a side of more than 32000 px, the limit for rotating and"),
        ("--affine 1e6,0,0,1e6", r"base\.exr: the result of 40000000 x 30000000 px"),
    ],
}


@pytest.mark.parametrize(
    ("code", "words", "pattern"),
    [
        pytest.param(code, f"{start} {words}", pattern, id=f"{start} {words}")
        for (code, start), table in BAD_INPUTS.items()
        for words, pattern in table
    ],
)
def test_unusable_inputs_are_refused(refused, place, code, words, pattern):
    refused(code, pattern, "compose", *words.split(), "-o", "out.exr", "--curl", "c.png", "--report", "r.json")
    refused(code, pattern, "compose", *words.split(), "-o", "old.exr", "--overwrite", "--json")


def test_messages_call_it_standard_input(run, fails, place, monkeypatch):
    files = {"good": (place / "motif.exr").read_bytes(), "bad": b"hello", "none": b""}
    for given, words, pattern in (
        ("good", "blend base.exr -", r"standard input is 20 x 20, but base\.exr is 40 x 30"),
        ("good", "paste base.exr - --at 100px,0", r"standard input: its area from .* is outside the canvas"),
        ("good", "paste base.exr - --mask black20.png", r"black20\.png: the mask of standard input is entirely black"),
        ("good", "transform - --pad 9mm", r"9mm: the size of a pixel is not known"),
        ("good", "transform - --scale 1000 --max-megapixels 1", r"standard input: the result of 20000 x 20000"),
        ("bad", "transform -", r"standard input: is not a picture"),
        ("none", "paste - motif.exr", r"standard input: is empty"),
        ("good", "paste - -", r"standard input: can be read only once"),
        ("good", "blend base.exr detail.exr --mask -", r"standard input: is a colour picture"),
        ("good", "blend base.exr detail.exr --mask=-", r"standard input: is a colour picture"),
    ):
        monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=io.BytesIO(files[given])))
        code = USAGE if "9mm" in words else LIMIT if "1000" in words else INPUT
        fails(run("compose", *words.split(), "-o", "out.exr"), code, pattern)
    assert not (place / "out.exr").exists()


BAD_TARGETS = {
    USAGE: {
        "out.jpg": r"out\.jpg: ends in \.jpg; normal maps are written as \.png, \.exr, \.tif, \.tiff",
        "out": r"out: has no ending; normal maps are written as",
        "./base.exr --overwrite": r"base\.exr: is also an input; give another name for the output",
        "link.exr --overwrite": r"link\.exr: is also an input",
        "out.exr --report out.exr": r"out\.exr: a report is written as \.json",
        "a.png --curl a.png": r"a\.png: is named twice",
    },
    OUTPUT: {
        "base.exr": r"base\.exr: already exists",
        "old.exr": r"old\.exr: already exists; give another name, or --overwrite",
        "out.exr --curl old.png": r"old\.png: already exists",
        "none/out.exr": r"none/out\.exr: the folder none does not exist; create it first",
        "file/out.exr": r"file/out\.exr: file is a file, not a folder",
        "folder.exr --overwrite": r"folder\.exr: is a folder; give a file name",
        "out.exr --report none/r.json": r"none/r\.json: the folder none does not exist",
        "n" * 300 + ".exr": r"(?i)too long",
    },
}


@pytest.mark.parametrize("start", [BLEND, PASTE, TRANSFORM])
@bad_targets(BAD_TARGETS)
def test_a_target_that_cannot_be_written_is_refused(refused, place, symlink, start, code, target, pattern):
    if target.startswith("link"):
        symlink(place / "link.exr", place / "base.exr")
    refused(code, pattern, "compose", *start.split(), "-o", *target.split())


def test_a_file_given_by_its_layer_is_an_input_too(refused, place):
    also = r"base\.exr: is also an input"
    refused(USAGE, also, "compose", "blend", "base.exr:RGB", "detail.exr", "-o", "base.exr", "--overwrite")
    refused(USAGE, also, "compose", "paste", "plate.png", "base.exr:RGB", "-o", "base.exr", "--overwrite")
    refused(USAGE, also, "relief", "base.exr:RGB", "-o", "base.exr", "--overwrite")
    words = ("compose", *PASTE.split(), "--mask", "black20.png", "-o", "black20.png", "--overwrite")
    refused(USAGE, r"black20\.png: is also an input", *words)


@pytest.mark.parametrize("where", ["nmaptool.io.output.map_pictures.curl_picture", "nmaptool.core.vectors.curl"])
@pytest.mark.parametrize("start", [BLEND, PASTE, TRANSFORM])
@pytest.mark.parametrize("out", ["out.exr", "old.exr", "-"])
def test_ctrl_c_at_any_stage_leaves_no_file(refused, place, monkeypatch, where, start, out):
    monkeypatch.setattr(where, fail_with(KeyboardInterrupt))
    words = (*start.split(), "-o", out, "--overwrite", "-q", "--curl", "c.png", "--report", "r.json")
    refused(INTERRUPTED, "interrupted; nothing was written", "compose", *words)


@pytest.mark.parametrize(
    ("out", "stated"), [("out.exr", r"out\.exr"), ("old.exr", r"old\.exr"), ("-", "standard output")]
)
@pytest.mark.parametrize("count", [1, 2])
def test_a_full_disk_leaves_no_file(refused, place, monkeypatch, out, stated, count):
    from nmaptool.io.output import normal_map as map_files

    disk_that_fills(monkeypatch, map_files, good=count - 1)
    stated = stated if count == 1 else r"c\.png"
    words = (*BLEND.split(), "-o", out, "--overwrite", "-q", "--curl", "c.png")
    refused(OUTPUT, rf"error: {stated}: cannot be written \(is the disk full\?\)", "compose", *words)


def test_a_folder_that_cannot_be_written_to_is_refused(refused, place, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode, **_: not mode & os.W_OK)
    refused(OUTPUT, r"out\.exr: the folder \. cannot be written to", "compose", *BLEND.split(), "-o", "out.exr")


WORDS = (
    "0 1 -1 2 0.5 -30 90 1e3 1e9 -1e-9 nan inf 5px -5px 50% 3mm -3mm 0,0 1,1 50%,50% -9px,9px 0,0,9px,9px 9x7 1,0,0,1 "
    "-1,0,0.5,1 0,0,0,0 , ,, x - -- --= = yes no over rnm pd udn top left auto clear flat ü \0 "
)
FLAGS = {
    BLEND: "mode strength mask fit layer green swizzle",
    PASTE: "at anchor scale rotate flip-h feather mode strength height-factor clip mask width",
    TRANSFORM: "crop resize scale rotate affine keep-size pad height-factor vectors-only ground width",
}


@pytest.mark.parametrize("start", FLAGS)
def test_random_arguments_give_a_map_or_one_clear_line(run, place, trials, start, monkeypatch):
    pick = random.Random(start)
    flags, values = FLAGS[start].split(), WORDS.split(" ")
    for _ in range(trials(150)):
        words = [w for _ in range(pick.randint(1, 3)) for w in (f"--{pick.choice(flags)}", pick.choice(values))]
        monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=io.BytesIO(b"")))
        result = run("compose", *start.split(), *words, "-o", "fuzz.exr", "--overwrite", "-q", "--max-megapixels", "1")
        assert result.code in (0, USAGE, INPUT, LIMIT), (words, result.err)
        assert result.err.count("\n") == (result.code != 0), (words, result.err)
        assert result.err.startswith("nmap: error: ") or result.code == 0
