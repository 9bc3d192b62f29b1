"""Failures of the bake command: the exit code, one clear line, and no changed file."""

import os
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from bake_cases import QUICK, quickly, write_plate
from cli_cases import bad_targets, bad_words, disk_that_fills, fail_with
from mesh_files import FACES, VERTICES, obj, ply

from nmaptool.render import gl

USAGE, INPUT, LIMIT, OUTPUT, RENDERER, INTERRUPTED = 2, 3, 4, 5, 6, 130


@pytest.fixture
def place(tmp_path, monkeypatch):
    """The working folder of the commands, with a plate, a file and a folder."""
    monkeypatch.chdir(tmp_path)
    write_plate(tmp_path / "plate.obj")
    (tmp_path / "file").write_text("precious", encoding="utf-8")
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "detail.exr").write_text("precious", encoding="utf-8")
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "left").write_text("precious", encoding="utf-8")
    (tmp_path / "old.exr").write_text("precious", encoding="utf-8")
    return tmp_path


NUMBER = "expected a number with a unit"
BAD_WORDS = [
    ("--view up", r"--view up: use one of front, back, .*such as front,left"),
    ("--view front,", r"--view '': use one of"),
    ("--view front,front", r"--view front,front: names a view twice"),
    ("--azimuth 361", r"--azimuth 361: must lie between -360 and 360, such as 30"),
    ("--azimuth -361", r"--azimuth=-361: must lie between"),
    ("--elevation nan", r"--elevation nan: must lie between"),
    ("--roll inf", r"--roll inf: must lie between"),
    ("--roll much", r"--roll 'much': must be a number"),
    ("--up x", r"\"x\" for --up\. Choose from: \"y\", \"z\""),
    ("--size 60", r"--size 60: expected columns x rows in px, such as 1000x900"),
    ("--size 0x50", r"--size 0x50: expected"),
    ("--size 60x0", r"--size 60x0: expected"),
    ("--size -60x50", r"--size=-60x50: expected"),
    ("--size 1.5x2", r"--size 1\.5x2: expected"),
    ("--size rubbish", r"--size rubbish: expected"),
    ("--size 99999999x1", r"--size 99999999x1: expected"),
    ("--margin 3mm", r"--margin 3mm: give it in px or %, such as 4%"),
    ("--margin 3", rf"--margin 3: {NUMBER}"),
    ("--margin -1px", r"--margin=-1px: must be greater than zero"),
    ("--margin 25px", r"--margin 25px: leaves no room in 60 x 50 px; use a smaller one, such as 5px"),
    ("--margin 50%", r"--margin 50%: leaves no room in 60 x 50 px"),
    ("--width 10%", r"--width 10%: .*give it in mm, cm, m or in"),
    ("--width 0mm", r"--width 0mm: must be greater than zero"),
    ("--width -1mm", r"--width=-1mm: must be greater than zero"),
    ("--pitch 2px", r"--pitch 2px: .*give it in mm, cm, m or in"),
    ("--pitch -1mm", r"--pitch=-1mm: must be greater than zero"),
    ("--pitch 1e9mm", r"--pitch 1e9mm: must lie between 1e-06 and 1e\+06"),
    ("--width 10mm --pitch 1mm", r"--width and --pitch both set the size of a pixel"),
    ("--target 1,2", r"--target 1,2: expected three numbers, such as 0,12\.5,3"),
    ("--target 1,2,x", r"--target 1,2,x: expected three numbers"),
    ("--target 1,2,nan", r"--target nan: must lie between"),
    ("--target -1e10,0,0", r"--target=-1e\+10: must lie between"),
    ("--fov -1", r"--fov=-1: must lie between 0 and 150"),
    ("--fov 151", r"--fov 151: must lie between 0 and 150"),
    ("--fov 0.001", r"--fov 0\.001: must be 0 \(orthographic\) or at least 0\.01, such as 35"),
    ("--fov 90 --pitch 0.0001mm --target 0,0,0", r"camera is inside the mesh; use a larger --pitch or a smaller"),
    ("--shading round", r"\"round\" for --shading"),
    ("--crease 181", r"--crease 181: must lie between 0 and 180"),
    ("--crease -1", r"--crease=-1: must lie between"),
    ("--supersample 3", r"\"3\" for --supersample\. Choose from: 1, 2, 4"),
    ("--renderer metal", r"\"metal\" for --renderer"),
    ("--geometry new", r"\"new\" for --geometry"),
    ("--detail-encoding pd", r"\"pd\" for --detail-encoding"),
    ("--max-megapixels 0", r"--max-megapixels 0: must be greater than zero"),
    ("--max-megapixels nan", r"--max-megapixels nan: must be greater than zero"),
    ("--filter bilateral", r"\"bilateral\" for --filter"),
    ("--neighborhood all", r"\"all\" for --neighborhood"),
    ("--sigma-s 0", r"--sigma-s 0: must lie between 0\.1 and 1000, such as 3 or 2%"),
    ("--sigma-s -3", r"--sigma-s=-3: must lie between"),
    ("--sigma-s nan", r"--sigma-s nan: must lie between"),
    ("--sigma-s -2%", r"--sigma-s=-2%: must be greater than zero"),
    ("--sigma-s 8px", r"--sigma-s 8px: a mesh has no pixels; give edge lengths, mm or %"),
    ("--sigma-s much", rf"--sigma-s much: {NUMBER}"),
    ("--sigma-r 0", r"--sigma-r 0: must lie between 0\.01 and 10"),
    ("--sigma-r 11", r"--sigma-r 11: must lie between"),
    ("--iterations 0", r"--iterations 0: must lie between 1 and 100"),
    ("--iterations 101", r"--iterations 101: must lie between"),
    ("--iterations 1.5", r"--iterations '1\.5': must be a whole number"),
    ("--unit km", r"\"km\" for --unit"),
    ("--max-faces 0", r"--max-faces 0: must be at least 1"),
    ("--max-faces 1e3", r"--max-faces '1e3': must be a whole number"),
    ("--format tif", r"\"tif\" for --format"),
    ("--plot p.jpg", r"p\.jpg: a plot is written as \.png"),
    ("--plot -", r"layers and pictures are written to files"),
    ("--report r.txt", r"r\.txt: a report is written as \.json"),
    ("--plot m/sheet.png", r"m: two of the outputs have the same name"),
    ("--frobnicate", r"--frobnicate"),
    ("second.obj", r"second\.obj: unexpected argument \(see nmap bake --help\)$"),
]


@bad_words(BAD_WORDS)
def test_wrong_arguments_are_refused(refused, place, words, pattern):
    refused(USAGE, pattern, "bake", "plate.obj", "-o", "m", *quickly(*words))


BAD_TARGETS = {
    USAGE: {
        "x.png": r"x\.png: layers are written into a folder, such as maps, with --format png .*, or into one .exr",
        "plate.obj": r"plate\.obj: layers are written into a folder",
        "-": r"-: layers and pictures are written to files, such as -o maps",
    },
    OUTPUT: {
        "file": r"file: is a file; layers are written into a folder; give another name",
        "file/m": r"file/m: file is a file, not a folder",
        "file/m.exr": r"file/m\.exr: file is a file, not a folder",
        "none/m": r"none/m: the folder none does not exist; create it first",
        "none/m.exr": r"none/m\.exr: the folder none does not exist",
        "full": r"full/detail\.exr: already exists; give another name, or --overwrite",
        "old.exr": r"old\.exr: already exists",
        "deep --view front,left": r"deep/left: is a file; layers are written into a folder",
        "m --report none/r.json": r"none/r\.json: the folder none does not exist",
        "m --plot full.png/p.png": r"full\.png/p\.png: the folder full\.png does not exist",
        "n" * 300: r"(?i)too long",
        "n" * 300 + ".exr": r"(?i)too long",
    },
}


@bad_targets(BAD_TARGETS)
def test_a_target_that_cannot_be_written_is_refused(refused, place, code, target, pattern):
    refused(code, pattern, "bake", "plate.obj", *QUICK, "-o", *target.split())


def test_a_report_may_be_in_the_new_folder(run, place):
    words = ("--report", "m/r.json", "--plot", "m/p.png")
    assert run("bake", "plate.obj", *QUICK, "-o", "m", *words).code == 0
    assert {"r.json", "p.png", "sheet.png"} < {path.name for path in (place / "m").iterdir()}


def test_missing_arguments_are_named(refused, place):
    refused(USAGE, r"no output given: add one, such as -o maps or -o maps\.exr", "bake", "plate.obj")
    refused(USAGE, r"no output given: add one", "bake", "plate.obj", "--report", "r.json")
    refused(USAGE, "MESH is missing", "bake", "-o", "m")
    refused(USAGE, r"-: a mesh is read from a file, because its ending names the format", "bake", "-", "-o", "m")


@pytest.mark.parametrize(
    ("words", "pattern"),
    [
        ("--size 19999x9999", r"19999x9999: needs 200 megapixels of layers .*limit of 100; .*--max-megapixels"),
        ("--size 9999999x9999999", r"--size 9999999x9999999: needs 1e\+08 megapixels"),
        ("--size 60x50 --view front,left --max-megapixels 0.005", r"needs 0\.006 megapixels .* the limit of 0\.005"),
        ("--size 60x50 --supersample 4 --max-megapixels 0.004", r"needs 0\.0048 megapixels .* limit of 0\.004"),
        ("--max-faces 1151", r"plate\.obj: 1152 faces, more than the limit of 1151; .*raise --max-faces"),
    ],
)
def test_sizes_beyond_the_limits_are_refused(refused, place, words, pattern):
    refused(LIMIT, pattern, "bake", "plate.obj", "-o", "m", *quickly(*words.split()))


LINE = np.array([[0, 0, 0], [1, 1, 1], [2, 2, 2]])
POINT = np.ones((3, 3))
WALL = np.array([[0, 0, 0], [0, 1, 0], [0, 0, 1]])
BAD_MESHES = {
    "empty.obj": (b"", r"empty\.obj: is empty"),
    "text.ply": (b"hello\n", r"text\.ply: "),
    "points.obj": (obj(VERTICES, []), r"points\.obj: .*4 points and no faces"),
    "line.obj": (obj(LINE, [[0, 1, 2]]), r"line\.obj: no face has an area \(faces: 1\)"),
    "point.obj": (obj(POINT, [[0, 1, 2]]), r"point\.obj: all vertices are at one point"),
    "nan.ply": (ply(VERTICES * np.nan, FACES, "ascii"), r"nan\.ply: every face has a vertex that is NaN or infinite"),
    "wall.obj": (obj(WALL, [[0, 1, 2]]), r"wall\.obj: is not visible in the front view; choose another --view"),
    "mesh.fbx": (b"Kaydara FBX Binary", r"mesh\.fbx: "),
}


@pytest.mark.parametrize("name", BAD_MESHES)
def test_an_unusable_mesh_is_refused(refused, place, name):
    data, pattern = BAD_MESHES[name]
    (place / name).write_bytes(data)
    refused(INPUT, pattern, "bake", name, "-o", "m", *QUICK, "--report", "r.json")
    refused(INPUT, pattern, "bake", name, "-o", "m.exr", *QUICK, "--json")


def test_a_missing_mesh_is_named(refused, place):
    refused(INPUT, r"none\.obj: no such file", "bake", "none.obj", "-o", "m", *QUICK)
    refused(INPUT, r"full: is a folder", "bake", "full", "-o", "m", *QUICK)


@pytest.mark.parametrize("words", ["--target 1000,0,0", "--pitch 1000mm --target 500,0,0", "--target 1e9,0,0 --fov 20"])
def test_a_mesh_out_of_view_is_refused(refused, place, words):
    pattern = r"plate\.obj: is not visible in the front view; choose another --view, --pitch or --target"
    refused(INPUT, pattern, "bake", "plate.obj", "-o", "m", *QUICK, *words.split())


def test_a_missing_renderer_is_reported_with_a_remedy(refused, place, monkeypatch):
    monkeypatch.setattr(gl, "Offscreen", fail_with(OSError("no libEGL\nhere")))
    monkeypatch.delenv("PYOPENGL_PLATFORM", raising=False)
    words = ("bake", "plate.obj", "-o", "m", "--size", "60x50")
    why = "no libEGL here"
    remedy = r"libegl1 .*mesa-libEGL .*slower: --renderer numpy"
    refused(RENDERER, rf"\(egl: {why}; osmesa: {why}; window: {why}\).*{remedy}", *words)
    refused(RENDERER, rf"\(osmesa: {why}\).*{remedy}", *words, "--renderer", "osmesa")
    monkeypatch.setenv("PYOPENGL_PLATFORM", "window")
    refused(RENDERER, rf"\(window: {why}\).*{remedy}", *words)


def test_a_renderer_that_is_really_missing_is_reported(place, tree, fails):
    before = tree()
    script = "import sys; from nmaptool_cli.main import main; sys.exit(main(sys.argv[1:]))"
    words = [sys.executable, "-W", "error", "-c", script, "bake", "plate.obj", "-q", "-o", "m", "--size", "60x50"]
    surroundings = {**os.environ, "PYOPENGL_PLATFORM": "osmesa"}
    done = subprocess.run(words, capture_output=True, text=True, check=False, timeout=100, env=surroundings)
    if done.returncode == 0:
        pytest.skip("this machine has OSMesa")
    result = SimpleNamespace(code=done.returncode, out=done.stdout, err=done.stderr)
    fails(result, RENDERER, "osmesa: .*--renderer numpy")
    assert tree() == before


PLACES = [
    "nmaptool.filters.prepared.decompose_clean",
    "nmaptool.baking.bake.draw_face_buffer",
    "nmaptool.io.output.layers.contact_sheet",
    "nmaptool.io.output.layers.mixture_plot",
]


@pytest.mark.parametrize("where", PLACES)
@pytest.mark.parametrize("out", ["m", "m.exr", "full"])
def test_ctrl_c_at_any_stage_leaves_no_file(refused, place, monkeypatch, where, out):
    monkeypatch.setattr(where, fail_with(KeyboardInterrupt))
    words = ("--overwrite", "--plot", "p.png", "--report", "r.json", "--view", "front,left", "--depth")
    refused(INTERRUPTED, "interrupted; nothing was written", "bake", "-q", "plate.obj", "-o", out, *QUICK, *words)


@pytest.mark.parametrize("out", ["m", "full", "m.exr"])
@pytest.mark.parametrize("late", [False, True])
def test_a_full_disk_leaves_no_file(refused, place, monkeypatch, out, late):
    from nmaptool.io.output import layers as layer_files

    begun = disk_that_fills(monkeypatch, layer_files, good=2 if late and out != "m.exr" else 0)
    target = "m.exr" if out == "m.exr" else f"{out}/{'detail' if late else 'original'}.exr"
    words = ("bake", "plate.obj", "-o", out, *QUICK, "--overwrite", "-q")
    refused(OUTPUT, rf"error: {target}: cannot be written \(is the disk full\?\)", *words)
    assert len(begun) == (3 if late and out != "m.exr" else 1)


def test_a_folder_that_cannot_be_written_to_is_refused(refused, place, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode, **_: not mode & os.W_OK)
    refused(OUTPUT, r"the folder full cannot be written to", "bake", "plate.obj", "-o", "full", *QUICK, "--overwrite")
    refused(OUTPUT, r"the folder \. cannot be written to", "bake", "plate.obj", "-o", "m.exr", *QUICK)


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="the superuser may write anywhere")
def test_a_read_only_folder_is_refused(refused, place):
    (place / "full").chmod(0o500)
    refused(OUTPUT, r"full/m: cannot be created", "bake", "plate.obj", "-o", "full/m", *QUICK)
    (place / "full").chmod(0o700)


def test_a_folder_that_cannot_be_created_is_refused(refused, place, monkeypatch):
    monkeypatch.setattr("pathlib.Path.mkdir", fail_with(PermissionError(13, "Permission denied")))
    refused(OUTPUT, r"m: cannot be created \(Permission denied\)", "bake", "-q", "plate.obj", "-o", "m", *QUICK)
