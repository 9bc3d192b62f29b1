"""The bake command: its files and output, the camera flags, and reliefs made from its maps."""

import json
import sys

import cv2
import numpy as np
import OpenImageIO as oiio  # noqa: N813 - its own documentation's name
import pytest
import trimesh
from bake_cases import PITCH, QUICK, SIDE, plate, quickly, write_plate
from mesh_files import obj, ply

import nmaptool as nm

MAPS = ["original", "base", "detail", "coverage"]


@pytest.fixture
def mesh(tmp_path):
    return write_plate(tmp_path / "plate.obj")


@pytest.fixture
def bake(run, mesh, tmp_path):
    """``bake(*words, out="m")`` bakes the plate, which must succeed, and returns the result."""

    def call(*words, out="m", given=mesh):
        done = run("bake", given, "-o", tmp_path / out, *quickly(*words))
        assert done.code == 0, done.err
        return done

    return call


def parts_of(path):
    source = oiio.ImageInput.open(str(path))
    names = []
    while source.seek_subimage(len(names), 0):
        names.append(source.spec().get_string_attribute("oiio:subimagename"))
    return names


@pytest.mark.parametrize("kind", ["exr", "png"])
def test_bake_writes_a_folder_of_files(bake, tree, mesh, tmp_path, kind):
    words = ("--format", kind, "--depth", "--faces", "--plot", tmp_path / "p.png", "--report", tmp_path / "r.json")
    done = bake(*words)
    files = [f"{name}.{kind}" for name in (*MAPS, "depth", "faces")] + ["sheet.png"]
    assert sorted(tree()) == sorted(["m", "p.png", "plate.obj", "r.json", *(f"m/{name}" for name in files)])
    assert done.out == ""
    assert f"wrote {tmp_path / 'm'}: {' '.join(files)}\n" in done.err
    assert f"wrote {tmp_path}: p.png r.json\n" in done.err
    assert f"{mesh}: 625 vertices, 1152 faces\n" in done.err
    assert "front: 60 x 50, 26.09 x 21.74 mm (units taken as mm), mesh covers" in done.err
    assert "rendered by numpy" in done.err


def test_bake_writes_one_file_with_parts(bake, tree, tmp_path):
    bake("--depth", "--faces", out="m.exr")
    assert sorted(tree()) == ["m.exr", "m_sheet.png", "plate.obj"]
    assert parts_of(tmp_path / "m.exr") == [*MAPS, "depth", "faces"]
    assert nm.read_normal_map(f"{tmp_path / 'm.exr'}:detail").frame.pitch_mm == pytest.approx(PITCH)


def test_several_views_get_a_folder_each(bake, tree, tmp_path):
    done = bake("--view", "Front, left", "--format", "png")
    wanted = [f"m/{view}/{name}.png" for view in ("front", "left") for name in MAPS]
    assert sorted(tree()) == sorted(["m", "m/front", "m/left", "m/sheet.png", "plate.obj", *wanted])
    told = [line.split(":")[0].strip() for line in done.err.splitlines()]
    assert [word for word in told if word in ("front", "left")] == ["front", "left"]
    assert nm.read_raster(tmp_path / "m" / "left" / "base.png").attributes["view"] == "left"
    one = cv2.imread(str(tmp_path / "m" / "sheet.png"))
    bake("--view", "front,left", "--faces", out="m.exr")
    assert parts_of(tmp_path / "m.exr") == [f"{view}.{name}" for view in ("front", "left") for name in (*MAPS, "faces")]
    bake(out="single")
    assert one.shape[0] == 2 * cv2.imread(str(tmp_path / "single" / "sheet.png")).shape[0]


@pytest.mark.parametrize("words", [("--json",), ("--report", "-"), ("--json", "--report", "-")])
def test_bake_writes_json_to_standard_output(bake, mesh, tmp_path, words):
    done = bake(*words, "--view", "front,iso", "-q")
    assert done.err == ""
    found = json.loads(done.out)
    assert found["version"] == nm.__version__
    assert found["files"] == {"mesh": str(mesh)}
    assert found["reading"] == {"unit": None, "max_faces": 20_000_000}
    assert found["outputs"][0] == str(tmp_path / "m" / "front" / "original.exr")
    assert [layers["view"] for layers in found["layers"]] == ["front", "iso"]


def test_the_report_states_how_layers_were_made(bake, tmp_path):
    bake("--report", tmp_path / "r.json", "--fov", "30", "--filter", "grnf", "--sigma-s", "2%")
    report = json.loads((tmp_path / "r.json").read_text(encoding="utf-8"))
    (found,) = report["layers"]
    mixture = found["mixture"]
    bins = mixture["histogram"]["density"]
    assert len(bins) == 100
    assert sum(bins) * mixture["histogram"]["to"] / 100 == pytest.approx(1, abs=1e-3)
    low, high = mixture["low"], mixture["high"]
    assert set(low) == set(high) == {"weight", "mean", "sigma"}
    assert low["weight"] + high["weight"] == pytest.approx(1)
    assert low["mean"] < mixture["theta"] < high["mean"]
    assert mixture["form"] in ("weighted", "unweighted", "midpoint")
    assert 0 < found["detail_share"] < 1
    assert found["findings"]["faces"] == found["faces"] == 1152
    assert list(report["seconds"]) == ["reading", "writing"]
    assert set(found["seconds"]) == {"clean", "filter", "draw", "layers"}
    assert found["renderer"] == "numpy"
    assert np.array_equal(found["camera"]["rotation"], np.eye(3))
    assert found["camera"]["distance"] > SIDE
    assert (found["options"]["sigma_s"], found["options"]["filter"], found["options"]["fov"]) == ("2%", "grnf", 30)


def test_dropped_faces_are_reported(run, tmp_path):
    vertices, faces = plate(4)
    vertices = np.append(vertices, [[np.nan] * 3, [5, 5, 5]], axis=0)
    (tmp_path / "odd.ply").write_bytes(ply(vertices, [*faces, [0, 0, 1], [0, 1, 25]], "ascii"))
    done = run("bake", tmp_path / "odd.ply", "-o", tmp_path / "m", *QUICK)
    assert done.code == 0
    assert "27 vertices, 34 faces; 1 face without area, 1 face with NaN, 1 vertex unused" in done.err
    assert "nmap: warning: " in done.err
    assert run("bake", tmp_path / "odd.ply", "-o", tmp_path / "n", *QUICK, "-q").err == ""


def test_existing_outputs_are_replaced_only_with_overwrite(bake, tree, tmp_path):
    bake("--depth")
    (tmp_path / "m" / "mine.txt").write_text("mine", encoding="utf-8")
    (tmp_path / "m" / "base.exr").write_text("old", encoding="utf-8")
    before = tree()
    bake("--overwrite", "--sigma-s", "5")
    after = tree()
    assert set(before) == set(after)
    assert {name for name in after if before[name] != after[name]} >= {"m/base.exr", "m/detail.exr"}
    assert after["m/base.exr"].startswith(b"\x76\x2f\x31\x01")


def extents(path):
    return trimesh.load(path, force="mesh").extents


@pytest.mark.parametrize("form", ["exr", "png", "parts"])
def test_the_relief_command_reads_the_baked_maps(bake, run, tmp_path, form):
    if form == "parts":
        bake(out="m.exr")
        original, base, detail = (f"{tmp_path / 'm.exr'}:{name}" for name in MAPS[:3])
    else:
        bake("--format", form)
        original, base, detail = (tmp_path / "m" / f"{name}.{form}" for name in MAPS[:3])
    relief, view = tmp_path / "x.stl", tmp_path / "x.png"
    done = run("relief", original, "--detail", detail, "-o", relief, "--preview", view)
    assert done.code == 0, done.err
    assert "pitch 0.4348 mm (file)" in done.err
    assert "warning" not in done.err
    assert done.err.count("green up (file)") == 2
    assert np.allclose(extents(relief)[:2], (60 * PITCH, 50 * PITCH), rtol=1e-6)
    assert 0.5 < extents(relief)[2] < 10
    assert np.ptp(cv2.imread(str(view))) > 100
    done = run("relief", base, "-o", relief, "--overwrite")
    assert done.code == 0
    assert "warning" not in done.err


def maps_at(folder):
    return [nm.read_normal_map(folder / f"{name}.exr") for name in MAPS[:3]]


@pytest.mark.parametrize(
    ("words", "pitch", "told"),
    [
        (("--width", "120mm"), 2.0, "120 x 100 mm (as given)"),
        (("--width", "3in"), 76.2 / 60, "(as given)"),
        (("--unit", "in"), 25.4 * PITCH, "(as given)"),
        (("--unit", "mm"), PITCH, "(as given)"),
    ],
)
def test_the_physical_size_changes_only_the_pitch(bake, tmp_path, words, pitch, told):
    bake("--depth", out="a")
    done = bake(*words, "--depth", out="b")
    assert told in done.err
    for one, other in zip(maps_at(tmp_path / "a"), maps_at(tmp_path / "b"), strict=True):
        assert np.array_equal(one.normals, other.normals)
        assert one.frame.pitch_mm == pytest.approx(PITCH)
        assert other.frame.pitch_mm == pytest.approx(pitch)
    depths = [nm.read_raster(tmp_path / name / "depth.exr").pixels.max() for name in "ab"]
    assert depths[1] / depths[0] == pytest.approx(pitch / (PITCH), rel=1e-5)


def test_a_pitch_renders_a_part_at_that_scale(bake, tmp_path):
    bake("--pitch", "0.1mm", "--target", "0,0,0")
    found = maps_at(tmp_path / "m")[0]
    assert found.frame.pitch_mm == 0.1
    assert found.foreground.all()


def test_up_z_renders_a_z_up_mesh_like_its_y_up_twin(bake, run, tmp_path):
    vertices, faces = plate()
    turned = vertices @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])  # (x, y, z) to (x, -z, y)
    (tmp_path / "z.obj").write_bytes(obj(turned, faces))
    bake(out="y")
    bake("--up", "z", out="z", given=tmp_path / "z.obj")
    # the filter's bins follow the mesh axes
    for one, other, within in zip(maps_at(tmp_path / "y"), maps_at(tmp_path / "z"), (0, 0.02, 0.02), strict=True):
        assert np.abs(one.normals - other.normals).max() <= within


@pytest.mark.parametrize(
    ("size", "told"),
    [("3", "3 edges = "), ("2%", "2% = 0.9 px"), ("1.5mm", "1.5mm = 3.5 px"), ("0.15cm", "0.15cm = 3.5 px")],
)
def test_sigma_s_is_reported_in_every_unit(bake, tmp_path, size, told):
    assert told in bake("--sigma-s", size).err


def test_negative_values_do_not_need_an_equals_sign(bake, tmp_path):
    words = ("--azimuth", "-30", "--elevation", "-10", "--roll", "-5", "--target", "-1,2,3")
    bake(*words, out="a")
    joined = [f"{flag}={value}" for flag, value in zip(words[::2], words[1::2], strict=True)]
    bake(*joined, out="b")
    for one, other in zip(maps_at(tmp_path / "a"), maps_at(tmp_path / "b"), strict=True):
        assert np.array_equal(one.normals, other.normals)
    options = nm.BakeOptions(
        size="60x50", margin="2px", renderer="numpy", azimuth=-30, elevation=-10, roll=-5, target="-1,2,3"
    )
    expected = nm.bake(nm.read_mesh(tmp_path / "plate.obj"), options).original
    assert np.array_equal(maps_at(tmp_path / "a")[0].normals, expected.normals)


def test_renderers_agree(bake, run, mesh, tmp_path):
    words = ("--view", "iso", "--supersample", "1", "--size", "240x200", "--faces")
    bake(*words, out="a")
    done = run("bake", mesh, "-o", tmp_path / "b", *quickly(*words, "--renderer", "egl"))
    if done.code == 6 and sys.platform != "linux":
        pytest.skip("no EGL on this machine")
    assert "rendered by egl" in done.err
    a, b = (nm.read_raster(tmp_path / name / "faces.exr").pixels[..., 0] for name in "ab")
    assert (a != b).mean() < 0.01
    for one, other in zip(maps_at(tmp_path / "a"), maps_at(tmp_path / "b"), strict=True):
        assert np.abs(one.normals - other.normals)[a == b].max() < 1e-6


@pytest.mark.parametrize("words", [("--sigma-r", "0.01"), ("--sigma-r", "0.1"), ("--neighborhood", "ring")])
@pytest.mark.parametrize("scale", [1e-20, 1.0, 1e20])
def test_results_stay_finite_at_every_scale(run, tmp_path, words, scale):
    box = trimesh.creation.box().subdivide().subdivide().subdivide()
    vertices = box.vertices * (1 + 0.01 * np.sin(50 * box.vertices[:, :1]))
    (tmp_path / "box.ply").write_bytes(ply(vertices * scale, box.faces, "ascii"))
    done = run("bake", tmp_path / "box.ply", "-o", tmp_path / "m", *QUICK, *words, "--view", "iso", "--depth")
    assert done.code == 0, done.err
    for found in maps_at(tmp_path / "m"):
        assert np.isfinite(found.normals).all()
        assert 0.2 < found.foreground.mean() < 0.9
    base = maps_at(tmp_path / "m")[1]
    middle = base.normals[25, [20, 40]]
    assert (middle[0] * middle[1]).sum() < 0.7  # the edge between two sides is kept


def test_a_perspective_camera_stays_outside_a_spike(run, tmp_path):
    spike = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [0, 0, 9]])
    (tmp_path / "spike.obj").write_bytes(obj(spike, [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]))
    done = run("bake", tmp_path / "spike.obj", "-o", tmp_path / "m", *QUICK, "--fov", "90", "--depth")
    assert done.code == 0, done.err
    own = nm.read_raster(tmp_path / "m" / "depth.exr").attributes
    assert 0 < float(own["near_mm"]) < float(own["far_mm"]) < 10


@pytest.mark.parametrize("size", ["1x1", "3x1", "1x400", "900x2"])
def test_tiny_and_elongated_images_are_rendered(bake, tmp_path, size):
    bake("--size", size, "--margin", "0.2px", "--supersample", "4", "--depth", "--faces")
    cols, rows = map(int, size.split("x"))
    found = maps_at(tmp_path / "m")[0]
    assert (found.frame.rows, found.frame.cols) == (rows, cols)
    assert found.coverage.any()
    assert max(cv2.imread(str(tmp_path / "m" / "sheet.png")).shape) < 6000
