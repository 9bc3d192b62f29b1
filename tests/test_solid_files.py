"""Solids in files: read back by other readers, and every kind of damage found by the check."""

from __future__ import annotations

import json
import re
import shutil
import struct
import subprocess
import zipfile

import lib3mf
import manifold3d
import numpy as np
import pytest
import trimesh
from solid_cases import HARD_MASKS, mask_of, random_options, random_relief

import nmaptool as nm
from nmaptool.io.solids.check import check_written
from nmaptool.io.solids.triangles import triangles_of
from nmaptool.io.solids.writer import write_solid

ENDINGS = [".stl", ".ply", ".obj", ".glb", ".3mf"]


def medal(mask=None, z_mm=1.0):
    mask = mask_of(HARD_MASKS["hole and island"]) if mask is None else mask
    rows, cols = mask.shape
    rng = np.random.default_rng(1)
    height = nm.Height(rng.random((rows + 1, cols + 1)) * z_mm, mask, nm.Frame(rows, cols, pitch_mm=0.7))
    return nm.solid(height, nm.SolidOptions(base=nm.length("2mm")))


@pytest.mark.parametrize("ending", ENDINGS)
def test_other_readers_find_the_same_solid(ending, tmp_path):
    solid, path = medal(), tmp_path / f"a{ending}"
    write_solid(solid, path)
    if ending == ".3mf":
        vertices, faces = from_lib3mf(path)
    else:
        scene = trimesh.load(path, force="scene", process=False)
        mesh = scene.to_geometry()
        vertices, faces = np.asarray(mesh.vertices) * (1000 if ending == ".glb" else 1), mesh.faces
    shape = trimesh.Trimesh(vertices, faces)
    shape.merge_vertices()
    assert shape.is_watertight
    assert len(shape.faces) == solid.face_count
    assert np.abs(shape.bounds - solid.bounds_mm).max() < 1e-5
    assert shape.volume == pytest.approx(solid.volume_mm3, rel=1e-5)


def from_lib3mf(path):
    """Vertices and faces of all objects of a 3MF file, read strictly."""
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(path))
    assert reader.GetWarningCount() == 0
    assert model.GetUnit() == lib3mf.ModelUnit.MilliMeter
    objects = model.GetMeshObjects()
    vertices, faces, first = [], [], 0
    while objects.MoveNext():
        mesh = objects.GetCurrentMeshObject()
        assert mesh.IsManifoldAndOriented()
        vertices += [tuple(vertex.Coordinates) for vertex in mesh.GetVertices()]
        faces += [[first + corner for corner in face.Indices] for face in mesh.GetTriangleIndices()]
        first = len(vertices)
    return np.array(vertices), np.array(faces)


def corners_in(path):
    """(n, 3, 3) corners of the triangles of a file in mm."""
    found = []
    for band in triangles_of(path):
        kind, count = ("<i4", 3) if len(band.points) else ("<f4", 9)
        numbers = np.ascontiguousarray(band.records[:, band.offset : band.offset + 4 * count]).view(kind)
        found.append((band.points[numbers] if len(band.points) else numbers.reshape(-1, 3, 3)) * band.unit_mm)
    return np.concatenate(found)


def test_random_solids_pass_other_programs(tmp_path, trials):
    for seed in range(trials(300)):
        solid = nm.solid(random_relief(seed), random_options(seed))
        path = tmp_path / f"{seed}{ENDINGS[seed % len(ENDINGS)]}"
        write_solid(solid, path)
        corners = corners_in(path)
        vertices, faces = np.unique(corners.reshape(-1, 3).astype(np.float32), axis=0, return_inverse=True)
        mesh = manifold3d.Mesh(vertices, faces.reshape(-1, 3).astype(np.uint32))
        assert manifold3d.Manifold(mesh).status() == manifold3d.Error.NoError, seed
        if path.suffix == ".3mf":
            from_lib3mf(path)
        path.unlink()


def test_a_3mf_file_has_title_unit_bodies_and_thumbnail(tmp_path):
    relief = nm.relief(np.dstack([np.full((8, 8), 0.5), np.zeros((8, 8)), np.ones((8, 8))]))
    solid = nm.solid(relief, nm.SolidOptions(base=nm.length("20mm")))
    nm.write_relief(relief, tmp_path / "leaf & vine.3mf", solid=solid)
    with zipfile.ZipFile(tmp_path / "leaf & vine.3mf") as archive:
        model = archive.read("3D/3dmodel.model").decode()
        assert archive.read("Metadata/thumbnail.png").startswith(b"\x89PNG")
    assert 'unit="millimeter"' in model
    assert '<metadata name="Title">leaf &amp; vine</metadata>' in model
    assert '<object id="1" name="relief" type="model">' in model


def test_the_same_solid_gives_the_same_bytes(tmp_path):
    for ending in ENDINGS:
        paths = [tmp_path / f"{name}{ending}" for name in "ab"]
        for path in paths:
            write_solid(medal(), path)
        assert paths[0].read_bytes() == paths[1].read_bytes()


def damaged_stl(path, change):
    data = bytearray(path.read_bytes())
    change(data)
    path.write_bytes(data)


def corner(face, index, axis):
    """Where a coordinate of a binary STL is."""
    return 84 + 50 * face + 12 + 12 * index + 4 * axis


def cut_short(data):
    del data[-50:]


def raised_corner(data):
    data[corner(3, 0, 2) : corner(3, 0, 3)] = struct.pack("<f", 99)


def moved_corner(data):
    data[corner(3, 0, 2) : corner(3, 0, 3)] = struct.pack("<f", 0.5)


def equal_corners(data):
    data[corner(3, 0, 0) : corner(3, 1, 0)] = data[corner(3, 1, 0) : corner(3, 2, 0)]


def repeated_face(data):
    data[84:134] = data[134:184]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (cut_short, r"it holds \d+ triangles instead of \d+"),
        (raised_corner, "its size is off by"),
        (equal_corners, "1 of its triangles have two equal corners"),
        (moved_corner, "it is not closed"),
        (repeated_face, "it is not closed"),
    ],
)
def test_a_damaged_file_fails_the_check(tmp_path, change, message):
    solid, path = medal(), tmp_path / "a.stl"
    write_solid(solid, path)
    check_written(solid, path)
    damaged_stl(path, change)
    with pytest.raises(nm.OutputError, match=rf"a\.stl: failed the check after writing: {message}"):
        check_written(solid, path)


def test_a_wrong_volume_fails_the_check(tmp_path):
    import dataclasses

    solid, path = medal(), tmp_path / "a.ply"
    write_solid(solid, path)
    with pytest.raises(nm.OutputError, match=r"its volume is .* mm3 instead of"):
        check_written(dataclasses.replace(solid, volume_mm3=solid.volume_mm3 * 1.01), path)


def test_a_failed_check_leaves_no_file(tmp_path, monkeypatch):
    def fail(solid, path, progress):
        raise nm.OutputError(f"{path}: failed")

    monkeypatch.setattr("nmaptool.io.solids.writer.check_written", fail)
    relief = nm.relief(np.dstack([np.full((8, 8), 0.5), np.zeros((8, 8)), np.ones((8, 8))]))
    with pytest.raises(nm.OutputError, match=r"a\.stl: failed"):
        nm.write_relief(relief, tmp_path / "a.stl", tmp_path / "a.npy")
    assert list(tmp_path.iterdir()) == []


def test_the_command_line_writes_a_solid_and_reports_it(tmp_path, run, clean_map):
    report = tmp_path / "r.json"
    done = run("relief", clean_map, "-o", tmp_path / "m.3mf", "--base", "2mm", "--height", "3mm", "--report", report)
    assert "1 closed body, 100 x 100 x 5 mm" in done.err
    told = json.loads(report.read_text())["solid"]
    assert told["closed"]
    assert told["options"]["base"] == "2mm"
    assert told["triangles"] == 2 * 96 * 96 + 3 * 4 * 96
    surface = run("relief", clean_map, "-o", tmp_path / "m.stl")
    assert "the mesh is an open surface; add --base 2mm for a solid" in surface.err


def test_a_dry_run_tells_the_size_and_writes_nothing(tmp_path, run, clean_map, tree):
    before = tree()
    done = run("relief", clean_map, "-o", tmp_path / "m.stl", "--base", "2mm", "--height", "3mm", "--dry-run")
    assert "19584 triangles: .stl 979 kB" in done.err
    assert "nothing written (--dry-run)" in done.err
    assert tree() == before


def test_a_base_without_a_mesh_is_refused(tmp_path, clean_map, refused):
    refused(
        2,
        "--base: is for meshes; name one, such as -o relief.3mf",
        "relief",
        clean_map,
        "-o",
        tmp_path / "m.npy",
        "--base",
        "2mm",
    )


@pytest.mark.skipif(shutil.which("prusa-slicer") is None, reason="PrusaSlicer is not installed")
def test_a_slicer_slices_without_repairs(tmp_path, trials):
    for seed in range(trials(10)):
        solid = nm.solid(random_relief(100 + seed), random_options(100 + seed))
        path = tmp_path / f"{seed}.stl"
        write_solid(solid, path)
        told = slicer("--info", path)
        assert "manifold = yes" in told
        for sign in ("facets_removed", "edges_fixed", "facets_reversed", "backwards_edges", "degenerate_facets"):
            assert sign not in told
        sliced = slicer(
            "--export-gcode", "--scale", "10", "--center", "100,100", "--output", tmp_path / "a.gcode", path
        )
        assert "Slicing result exported" in sliced
        for sign in ("repair", "open edge", "error", "warning"):
            assert sign not in sliced.lower()


def slicer(*words):
    """What the slicer says."""
    command = ["prusa-slicer", *map(str, words)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120)
    return done.stdout + done.stderr


def test_corners_that_are_separated_are_told(tmp_path, run, codes, png):
    normals = np.zeros((20, 20, 3))
    normals[..., 2] = 1
    mask = np.zeros((20, 20), np.uint8)
    mask[4:10, 4:10] = mask[10:16, 10:16] = 255
    png(tmp_path / "map.png", np.dstack([codes(normals), mask]))
    words = ("relief", tmp_path / "map.png", "-o", tmp_path / "m.stl", "--background", "cut", "--base", "2mm")
    told = run(*words)
    assert "2 closed bodies" in told.err
    assert "separated 1 corner where pixels of the mask only touch; fill a pixel there to join them" in told.err
    refused_ = run(*words, "--one-piece", "--overwrite")
    assert refused_.code == 3
    assert "--one-piece: the relief has 2 separate pieces, the largest of 36 px" in refused_.err


def test_what_was_hollowed_is_told(tmp_path, run, clean_map):
    words = ("relief", clean_map, "-o", tmp_path / "m.stl", "--base", "4mm", "--height", "3mm", "--overwrite")
    assert re.search(r"hollowed by \d\d\.\d+ cm3", run(*words, "--hollow", "1.5mm").err)
    assert "warning: nothing to hollow: no part is thicker than" in run(*words, "--hollow", "50mm").err


@pytest.mark.parametrize("ending", ENDINGS)
def test_progress_of_writing_and_checking_ends_at_one(ending, tmp_path):
    told = []
    write_solid(medal(), tmp_path / f"a{ending}", progress=lambda word, share: told.append((word, share)))
    for word in ("writing", "checking"):
        shares = [share for each, share in told if each == word]
        assert shares == sorted(shares)
        assert shares[-1] == 1.0
    assert [word for word, _ in told] == sorted((word for word, _ in told), reverse=True)
