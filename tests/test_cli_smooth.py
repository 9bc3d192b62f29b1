"""The smooth and compare commands: files, output, units and failures."""

import json

import numpy as np
import pytest
import trimesh
from bake_cases import plate, write_plate
from cli_cases import bad_words
from mesh_files import FACES, VERTICES, obj

import nmaptool as nm
from nmaptool.core.errors import OutputError

USAGE, INPUT, OUTPUT = 2, 3, 5
QUICK = ("--size", "60x50", "--renderer", "numpy")


@pytest.fixture
def place(tmp_path, monkeypatch):
    """The working folder of the commands, with a plate and a file."""
    monkeypatch.chdir(tmp_path)
    write_plate(tmp_path / "plate.obj")
    (tmp_path / "file.stl").write_text("precious", encoding="utf-8")
    return tmp_path


def test_smooth_writes_every_format_and_the_report(run, place, tree):
    done = run(
        "smooth",
        "plate.obj",
        *(w for e in ("stl", "ply", "obj", "glb") for w in ("-o", f"m.{e}")),
        "--report",
        "r.json",
    )
    assert (done.code, done.out) == (0, "")
    assert {"m.stl", "m.ply", "m.obj", "m.glb", "r.json"} < set(tree())
    assert "plate.obj: 625 vertices, 1152 faces\n" in done.err
    assert "  detail gain 0, scheme gsfg-gradient: 20 steps, closeness 0.01, " in done.err
    assert "  96 vertices on open edges, held\n" in done.err
    assert "mm outwards on average" in done.err
    assert "  wrote m.stl (coordinates as in the input)\n" in done.err
    assert "  wrote m.glb (in metres, input coordinates taken as mm)\n" in done.err
    found = json.loads((place / "r.json").read_text(encoding="utf-8"))
    assert found["files"] == {"mesh": "plate.obj"}
    assert found["outputs"] == ["m.stl", "m.ply", "m.obj", "m.glb", "r.json"]
    assert (found["mm_per_unit"], found["unit_from"], found["detail_gain"]) == (1, "assumed", 0)
    assert found["reconstruction"]["boundary_vertices"] == 96
    assert found["filter"]["sigma_s"] == 3


def test_gain_one_gives_the_same_numbers_in_the_same_order(run, place):
    assert run("smooth", "plate.obj", "-o", "m.obj", "-o", "m.ply", "-o", "m.glb", "--detail-gain", "1", "-q").err == ""
    vertices, faces = nm.read_mesh("plate.obj").vertices, plate()[1]
    for name, unit, close in (("m.obj", 1, 1e-7), ("m.ply", 1, 1e-5), ("m.glb", 1e-3, 1e-8)):
        made = trimesh.load(place / name, force="mesh", process=False)
        np.testing.assert_allclose(made.vertices, vertices * unit, atol=close)
        assert np.array_equal(made.faces, faces)


def test_known_units_become_millimetres(run, place):
    done = run("smooth", "plate.obj", "--unit", "cm", "--detail-gain", "1", "-o", "m.ply", "-o", "m.glb", "--json")
    assert "wrote m.ply (in mm)\n" in done.err
    assert "wrote m.glb (in metres)\n" in done.err
    assert trimesh.load(place / "m.ply").extents[0] == pytest.approx(200)
    assert trimesh.load(place / "m.glb", force="mesh").extents[0] == pytest.approx(0.2)
    assert json.loads(done.out)["mm_per_unit"] == 10
    # and read back, they have their original size
    assert np.ptp(nm.read_mesh(place / "m.glb").vertices_mm, axis=0)[0] == pytest.approx(200)


def test_a_tiny_mesh_keeps_its_shape_as_obj(tmp_path):
    tiny = nm.Mesh(VERTICES.astype(float) * 1e-9, FACES)
    nm.write_mesh(tiny, tmp_path / "t.obj")
    np.testing.assert_allclose(nm.read_mesh(tmp_path / "t.obj").vertices, tiny.vertices, rtol=1e-6)


def test_the_volume_of_a_closed_mesh_is_reported(run, place):
    (place / "solid.obj").write_bytes(obj())
    done = run("smooth", "solid.obj", "-o", "m.stl", "-v", "--steps", "3")
    assert done.code == 0
    assert "; volume " in done.err
    assert "  rms move per step, in mean edge lengths: " in done.err
    assert "  seconds clean " in done.err


def test_warnings_are_printed(run, place):
    (place / "twice.obj").write_bytes(obj(VERTICES, [*FACES, FACES[0]]))
    done = run("smooth", "twice.obj", "-o", "m.stl")
    assert "nmap: warning: twice.obj: dropped 1 face (without area, with NaN, or duplicate)\n" in done.err


def test_values_may_begin_with_a_minus_sign(run, place):
    assert run("smooth", "plate.obj", "-o", "m.stl", "--detail-gain", "-0.5", "-q").code == 0


BAD_WORDS = [
    ("--detail-gain 11", r"--detail-gain 11: must lie between -10 and 10, such as 0 or 2"),
    ("--detail-gain much", r"--detail-gain 'much': must be a number"),
    ("--steps 0", r"--steps 0: must lie between 1 and 10000"),
    ("--steps 1.5", r"--steps '1\.5': must be a whole number"),
    ("--closeness 0", r"--closeness 0: must lie between"),
    ("--closeness=-1", r"--closeness=-1: must lie between"),
    ("--scheme sfg", r"\"sfg\" for --scheme"),
    ("--boundary cut", r"\"cut\" for --boundary"),
    ("--sigma-s 0", r"--sigma-s 0: must lie between"),
    ("-o m.off", r"m\.off: ends in \.off; a mesh is written as \.stl, \.ply, \.obj, \.glb"),
    ("-o m", r"m: has no ending; a mesh is written as"),
    ("-o -", r"-: a mesh is written to a file, such as -o smooth\.stl"),
    ("-o n.stl", r"n\.stl: is named twice as an output"),
    ("--report r.txt", r"r\.txt: a report is written as \.json"),
    ("-o plate.obj --overwrite", r"plate\.obj: is also an input; give another name for the output"),
    ("second.obj", r"second\.obj: unexpected argument"),
]


@bad_words(BAD_WORDS)
def test_wrong_arguments_are_refused(refused, place, words, pattern):
    refused(USAGE, pattern, "smooth", "plate.obj", "-o", "n.stl", *words)


def test_impossible_inputs_and_outputs_are_refused(refused, place):
    refused(USAGE, r"no output given: add one, such as -o smooth\.stl", "smooth", "plate.obj")
    refused(USAGE, r"-: a mesh is read from a file", "smooth", "-", "-o", "m.stl")
    refused(INPUT, r"none\.obj: no such file|none\.obj", "smooth", "none.obj", "-o", "m.stl")
    refused(
        OUTPUT, r"file\.stl: already exists; give another name, or --overwrite", "smooth", "plate.obj", "-o", "file.stl"
    )
    refused(OUTPUT, r"deep/m\.stl: the folder deep does not exist", "smooth", "plate.obj", "-o", "deep/m.stl")
    (place / "flat.obj").write_bytes(obj(VERTICES, [[0, 0, 1]]))
    refused(INPUT, r"flat\.obj: no face has an area \(faces: 1\)", "smooth", "flat.obj", "-o", "m.stl")


def test_a_full_disk_leaves_nothing(refused, place, monkeypatch):
    def full(mesh, path):
        path.write_text("half", encoding="utf-8")
        raise OutputError(f"{path}: cannot be written (No space left on device)")

    monkeypatch.setattr("nmaptool.io.meshes.writer.write_mesh", full)
    pattern = r"^nmap: error: m\.stl: cannot be written \(No space left on device\)"
    refused(OUTPUT, pattern, "smooth", "plate.obj", "-o", "m.stl", "-q")


@pytest.mark.parametrize("where", ["filters.prepared.decompose_clean", "reconstruction.smooth.reconstruct"])
def test_ctrl_c_leaves_nothing(refused, place, monkeypatch, where):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(f"nmaptool.{where}", interrupted)
    refused(130, "interrupted; nothing was written", "smooth", "plate.obj", "-o", "m.stl", "-q")


def test_compare_writes_a_figure_and_prints_the_verdict(run, place, tree):
    done = run("compare", "plate.obj", "-o", "f.png", "--report", "f.json", "-v", *QUICK)
    assert (done.code, done.out) == (0, "")
    assert {"f.png", "f.json"} < set(tree())
    stated = [line for line in done.err.splitlines() if line.startswith("  the paper's claim ")]
    found = json.loads((place / "f.json").read_text(encoding="utf-8"))
    assert stated == [f"  the paper's claim {verdict['summary']}" for verdict in found["verdicts"]]
    assert len(stated) == 3
    assert "  gsfg-gradient, 20 steps, closeness 0.01: normals " in done.err
    assert "  poisson, 20 solves: 20 steps, closeness 0.01: " in done.err
    assert found["unit_from"] == "assumed"


def test_compare_writes_json_to_standard_output(run, place):
    done = run("compare", "plate.obj", "--json", "-q", "--scheme", "gsfg", *QUICK)
    assert done.err == ""
    assert json.loads(done.out)["contenders"]["gsfg"]["options"]["scheme"] == "gsfg"


@pytest.mark.parametrize(
    ("words", "pattern"),
    [
        ("-o f.jpg", r"f\.jpg: a figure is written as \.png"),
        ("-o -", r"-: a figure is written to a file, such as -o figure\.png"),
        ("", r"no output given: add one, such as -o figure\.png"),
        ("-o f.png --report r.txt", r"r\.txt: a report is written as \.json"),
        ("-o f.png --scheme poisson", r"--scheme poisson: Poisson is always compared; choose"),
        ("-o f.png --view up", r"--view up: use one of front, back"),
        ("-o f.png --size 3", r"--size 3: expected columns x rows"),
    ],
)
def test_compare_refuses_wrong_arguments(refused, place, words, pattern):
    refused(USAGE, pattern, "compare", "plate.obj", *words.split())
    refused(USAGE, r"-: a mesh is read from a file", "compare", "-", "-o", "f.png")
