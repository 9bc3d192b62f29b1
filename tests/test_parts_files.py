"""Files of parts: names, formats, the assembly, the command and its messages."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
import trimesh
from cli_cases import bad_words
from part_cases import PITCH_MM, cap, height_of, plane, relief_of
from solid_cases import options

import nmaptool as nm
from nmaptool.figures.assembly import assembly_picture
from nmaptool.io.output.parts import earlier_parts

MAP = "samples/medal_original.png"
PARTS = "{row}_{col}"


@pytest.mark.parametrize("ending", [".stl", ".ply", ".obj", ".glb", ".3mf"])
def test_every_mesh_format_holds_parts(ending, tmp_path):
    height, given = plane(), options(base="2mm")
    made = nm.write_parts(height, tmp_path / f"{PARTS}{ending}", nm.PartOptions(parts="2x2"), given)
    assert sorted(file.name for file in tmp_path.iterdir()) == [
        f"{row}_{col}{ending}" for row in (0, 1) for col in (0, 1)
    ]
    meshes = [nm.read_mesh(tmp_path / part.files[0]) for part in made.parts]
    bounds = np.array([[mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)] for mesh in meshes])
    unit = 1000 if ending == ".glb" else 1
    if ending != ".glb":  # which stands upright
        assert bounds[:, 0].min(axis=0) * unit == pytest.approx([0, 0, -2], abs=1e-4)
    assert [part.triangles for part in made.parts] == [len(mesh.faces) for mesh in meshes]


def test_the_assembly_says_which_part_goes_where(tmp_path):
    domain = np.zeros((24, 36), bool)
    domain[2:12, 3:33] = domain[2:22, 3:7] = True  # the plan divides the box around it
    height = height_of(np.ones((25, 37)), domain)
    given = nm.PartOptions(part="4mm", part_origin="own")
    index, picture = tmp_path / "parts.json", tmp_path / "parts.png"
    made = nm.write_parts(height, tmp_path / f"p{PARTS}.stl", given, options(base="1mm"), assembly=[index, picture])
    assert (made.rows, made.cols, made.size_mm) == (2, 2, (9.0, 6.0))
    assert made.left_out == ((1, 1),)
    assert (made.cuts_x_mm, made.cuts_y_mm) == ((0.75, 4.5, 8.25), (0.5, 3.0, 5.5))
    second = made.parts[1]
    assert (second.row, second.col, second.files) == (0, 1, ("p0_1.stl",))
    assert (second.low_mm, second.high_mm, second.size_mm) == ((4.5, 3.0, -1), (8.25, 5.5, 1), (3.75, 2.5, 2))
    assert made.volume_mm3 == pytest.approx((7.5 * 2.5 + 1 * 2.5) * 2)
    found = json.loads(index.read_text())
    assert found["parts"][1]["files"] == ["p0_1.stl"]
    assert (found["left_out"], found["origin"], found["unit"]) == ([[1, 1]], "own", "mm")
    assert found["parts"][1]["size_mm"] == [3.75, 2.5, 2]
    assert nm.read_raster(picture).attributes["kind"] == "assembly"


def test_the_picture_of_an_assembly_shows_the_lines_and_what_is_left_out(tmp_path):
    domain = np.zeros((40, 60), bool)
    domain[:, :20] = domain[:, 50:] = True
    height = height_of(np.ones((41, 61)), domain)
    made = nm.write_parts(height, tmp_path / f"{PARTS}.stl", nm.PartOptions(parts="3x1"))
    assert made.left_out == ((0, 1),)
    blank = np.full((40, 60, 3), 200, np.uint8)
    drawn = assembly_picture(made, blank, 800).astype(int)
    assert max(drawn.shape[:2]) == 800
    is_line = drawn[..., 0] - drawn[..., 2] > 60
    middle = np.flatnonzero(is_line.sum(axis=0) > drawn.shape[0] / 2)
    (gap,) = np.flatnonzero(np.diff(middle) > 5)  # two lines
    left, right = drawn[:, 90 : middle[0] - 5], drawn[:, middle[gap] + 5 : middle[gap + 1] - 5]
    hatched = [(np.abs(side - [0x8D, 0x87, 0x7D]) < 30).all(axis=2).mean() for side in (left, right)]
    assert hatched[1] > 0.02 > hatched[0]


def test_the_volume_of_open_parts_is_not_known(tmp_path):
    made = nm.write_parts(plane(), tmp_path / f"{PARTS}.ply", nm.PartOptions(parts="2x1"))
    assert made.volume_mm3 is None
    assert made.to_dict()["volume_mm3"] is None


@pytest.mark.parametrize(
    ("name", "error", "pattern"),
    [
        ("{row}.stl", nm.UsageError, r"\{row\}\.stl: does not name \{col\}, so parts would share a file"),
        ("a.stl", nm.UsageError, r"a\.stl: does not name \{row\} and \{col\}"),
        ("{row}/{col}.stl", nm.UsageError, "into the file name, not into the folder's"),
        ("{row}_{col}.tif", nm.UsageError, r"ends in \.tif; parts are written as \.stl"),
        ("no/such/{row}_{col}.stl", nm.OutputError, "the folder no does not exist; create it first"),
        ("earlier/{row}_{col}.stl", nm.OutputError, r"0_7\.stl: already exists; give another name, or `overwrite`"),
    ],
)
def test_names_of_parts_are_checked_before_the_work(name, error, pattern, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "earlier").mkdir()
    (tmp_path / "earlier" / "0_7.stl").write_text("")
    with pytest.raises(error, match=pattern):
        nm.write_parts(plane(), name, nm.PartOptions(parts="2x1"))
    assert [file.name for file in tmp_path.rglob("*.*")] == ["0_7.stl"]


def test_parts_of_an_earlier_run_are_found_in_order(tmp_path):
    for name in ("10_2.stl", "9_0.stl", "a_b.stl", "1_1.obj", "9_10.stl"):
        (tmp_path / name).write_text("")
    found = earlier_parts(tmp_path / "{row}_{col}.stl")
    assert [file.name for file in found] == ["9_0.stl", "9_10.stl", "10_2.stl"]


def test_all_parts_appear_or_none(tmp_path, monkeypatch):
    from nmaptool.io.solids import writer

    write, count = writer.check_written, []

    def failing(solid, path, progress=None):
        count.append(path)
        if len(count) == 3:
            raise nm.OutputError(f"{path}: failed the check after writing")
        write(solid, path, progress)

    monkeypatch.setattr(writer, "check_written", failing)
    with pytest.raises(nm.OutputError, match=r"1_0\.stl: failed the check after writing"):
        nm.write_parts(plane(), tmp_path / "new" / f"{PARTS}.stl", nm.PartOptions(parts="2x2"))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("given", "error", "pattern"),
    [
        ({"part": "400px"}, nm.UsageError, "`part='400px'`: sets the size of a part; give it in mm, cm, m or in"),
        ({"part": "wide"}, nm.UsageError, "`part='wide'`: expected a length, such as 400mm, or width and height"),
        ({"part": "3x4"}, nm.UsageError, "`part='3x4'`: expected a length"),
        ({"parts": "3"}, nm.UsageError, "`parts='3'`: expected numbers across x down, such as 3x4"),
        ({"parts": "0x4"}, nm.UsageError, "`parts='0x4'`: expected numbers across x down"),
        ({"part": "9mm", "parts": "2x2"}, nm.UsageError, "`part` and `parts` both set how large the parts are"),
        ({"part_origin": "own"}, nm.UsageError, "`part_origin='own'`: needs parts, such as `part='400mm'`"),
        ({}, nm.UsageError, "no parts are asked for; give `part`, such as `part='400mm'`, or `parts`"),
        ({"part": "0.1mm"}, nm.InputError, r"`part='0\.1mm'`: is smaller than a pixel of the relief, 0\.25 mm"),
        (
            {"part": "0.25mm"},
            nm.InputError,
            r"makes 120 x 100 parts of a relief of 30 x 25 mm; at most 10,000 are",
        ),
        ({"parts": "121x2"}, nm.InputError, "`parts='121x2'`: the relief has only 120 x 100 px; use fewer .*'120x2'`"),
    ],
)
def test_wrong_sizes_of_parts_are_refused(given, error, pattern):
    with pytest.raises(error, match=pattern):
        nm.plan_parts(100, 120, PITCH_MM, nm.PartOptions(**given))


def test_parts_are_equal_and_no_larger_than_asked_for():
    for rows, cols, part in ((1000, 777, "50mm"), (401, 400, "100mm"), (1600, 1600, "400mm"), (90, 7, "1.9mm")):
        plan = nm.plan_parts(rows, cols, PITCH_MM, nm.PartOptions(part=part))
        side_mm = float(part.removesuffix("mm"))
        heights, widths = {p.shape[0] for p in plan}, {p.shape[1] for p in plan}
        assert max(*heights, *widths) * PITCH_MM <= side_mm
        assert max(heights) - min(heights) <= 1
        assert max(widths) - min(widths) <= 1
        assert sum(p.shape[0] * p.shape[1] for p in plan) == rows * cols
    whole = nm.plan_parts(1600, 1600, PITCH_MM, nm.PartOptions(part="400mm"))
    assert [part.size_mm(PITCH_MM) for part in whole] == [(400, 400)]
    assert len(nm.plan_parts(1600, 3200, PITCH_MM, nm.PartOptions(part="400mm"))) == 2
    assert len(nm.plan_parts(100, 200, 0.1, nm.PartOptions(part="2x1cm"))) == 1
    assert len(nm.plan_parts(100, 200, 0.1, nm.PartOptions(part="10mm x 0.5 cm"))) == 4


def test_what_cannot_be_cut_is_refused():
    with pytest.raises(nm.UsageError, match="the height field must be a Height or a Relief, found ndarray"):
        list(nm.parts(np.ones((3, 3)), nm.PartOptions(parts="2x2")))
    mask = np.zeros((20, 20), bool)
    mask[:, 2:5] = mask[:, 7:9] = mask[15:, 2:9] = True
    bridge = height_of(np.ones((21, 21)), mask)
    assert len(list(nm.parts(bridge, nm.PartOptions(parts="1x1"), options(base="1mm", one_piece=True)))) == 1
    with pytest.raises(nm.InputError, match="`one_piece`: part 0, 0 has 2 separate pieces; use other parts"):
        list(nm.parts(bridge, nm.PartOptions(parts="1x2"), options(base="1mm", one_piece=True)))
    raised = np.zeros((20, 20), bool)
    raised[5:15, 5:15] = True
    z_mm = np.zeros((21, 21))
    z_mm[5:16, 5:16] = 1
    stands = height_of(z_mm, None, raised)
    for name, thin in (("max_error", "0.1mm"), ("triangles", "2k")):
        with pytest.raises(nm.UsageError, match=f"`{name}` and `shell` do not go together with a raised motif"):
            list(nm.parts(stands, nm.PartOptions(parts="2x2"), options(shell="0.5mm", **{name: thin})))


def test_the_command_writes_parts_that_join_without_a_seam(run, tmp_path):
    words = ("--width", "60mm", "--height", "3mm", "--base", "2mm", "--outline", "exact", "--part", "25mm")
    done = run(
        *("relief", MAP, "-o", tmp_path / "p" / f"{PARTS}.stl", *words, "--report", tmp_path / "r.json"),
        *("--assembly", tmp_path / "a.json", "--assembly", tmp_path / "a.png"),
    )
    assert done.code == 0
    assert "9 parts in 3 x 3, at most 20.081 x 20.081 x " in done.err
    assert f"{PARTS}.stl: 9 parts" in done.err
    meshes = [trimesh.load(file) for file in sorted((tmp_path / "p").iterdir())]
    assert len(meshes) == 9
    assert all(mesh.is_watertight for mesh in meshes)
    report = json.loads((tmp_path / "r.json").read_text())
    assert len(report["outputs"]) == 12
    assert report["parts"]["options"]["part"] == "25mm"
    assert report["parts"]["volume_mm3"] == pytest.approx(sum(mesh.volume for mesh in meshes), rel=1e-5)
    done = run("relief", MAP, "-o", tmp_path / "whole.stl", *words[:-2])
    assert done.code == 0
    whole = trimesh.load(tmp_path / "whole.stl")
    assert sum(mesh.volume for mesh in meshes) == pytest.approx(whole.volume, rel=1e-6)
    # all vertices of the fronts are those of the whole, and together they are all of them
    fronts = [{tuple(v) for v in mesh.vertices[mesh.vertices[:, 2] > -2].tolist()} for mesh in (*meshes, whole)]
    assert set.union(*fronts[:-1]) == fronts[-1]


def test_the_command_names_what_is_left_out_and_left_over(run, tmp_path):
    (tmp_path / "7_7.stl").write_text("")
    words = ("--background", "cut", "--shell", "1mm", "--width", "60mm", "--parts", "8x8", "--overwrite")
    done = run("relief", MAP, "-o", tmp_path / f"{PARTS}.stl", *words)
    assert done.code == 0
    assert re.search(r"\d+ parts in 8 x 8", done.err)
    assert "left out, because nothing of the relief lies there: 0_0 " in done.err
    assert re.search(r"warning: .*7_7\.stl: left from an earlier run and not among these parts", done.err)
    assert not (tmp_path / "0_0.stl").exists()
    done = run("relief", MAP, "-o", tmp_path / "q" / f"{PARTS}.stl", *words, "--dry-run")
    assert done.code == 0
    assert not (tmp_path / "q").exists()


@bad_words(
    [
        (
            "-o x.stl --part 30mm",
            r"is one file, but --part makes several; name them such as x_\{row\}_\{col\}\.stl",
        ),
        ("-o x.stl --parts 2x2", "is one file, but --parts makes several"),
        ("-o {row}_{col}.stl", r"\{row\}_\{col\}\.stl: is for parts; give --part, such as --part 400mm"),
        ("-o x.stl --assembly a.json", r"a\.json: is for parts; give --part, such as --part 400mm"),
        ("-o x.tif --part 30mm", r"--part: is for meshes; name their files, such as -o 'parts/\{row\}_\{col\}\.stl'"),
        (
            "-o {row}_{col}.stl --part 30mm --assembly a.txt",
            r"an assembly is written as \.json, \.png",
        ),
        ("--part 30mm --assembly -", "an assembly is written to files, such as --assembly parts.json"),
        (
            "-o {row}_{col}.stl --part 30mm --shape round --base 3mm --hollow 1mm",
            "--hollow 1mm: parts of a plate with an exact outline would be open where they are cut",
        ),
    ]
)
def test_the_command_refuses_wrong_names_of_parts(run, words, pattern, tmp_path, monkeypatch):
    source = nm.__file__.replace("nmaptool/__init__.py", MAP)
    monkeypatch.chdir(tmp_path)
    done = run("relief", source, "--width", "60mm", *words)
    assert done.code == 2
    assert re.search(pattern, done.err)
    assert list(tmp_path.iterdir()) == []


def test_a_relief_of_a_smooth_cap_in_parts_has_one_bottom(tmp_path):
    made = nm.write_parts(relief_of(cap()), tmp_path / f"{PARTS}.stl", nm.PartOptions(parts="3x3"), options(base="2mm"))
    assert {part.low_mm[2] for part in made.parts} == {-2.0}
