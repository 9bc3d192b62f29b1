"""Reading meshes: positions, windings, transforms and units; everything else in a file is ignored."""

import json
import logging
import os
import struct
import subprocess
import sys
import threading
import time

import mesh_files as files
import numpy as np
import pytest
from mesh_files import FACES, LIST, VERTICES, XYZ, ply_header, tree, volume

from nmaptool.core.errors import UsageError
from nmaptool.io.meshes.reader import read_mesh
from nmaptool.io.meshes.writer import write_mesh
from nmaptool.meshes.clean import clean_mesh
from nmaptool.types.mesh import Mesh


@pytest.fixture
def read(tmp_path, capfd):
    """``read("a.obj", data, ...)``: the mesh in those bytes; reading prints nothing."""

    def call(name, data, **options):
        (tmp_path / name).write_bytes(data)
        mesh = read_mesh(tmp_path / name, **options)
        assert capfd.readouterr() == ("", "")
        return mesh

    return call


def in_order(corners):
    """Triangles as a sorted list, each starting at its smallest corner with its winding kept."""
    triangles = (np.round(corners, 4) + 0.0).tolist()
    return sorted(t[k:] + t[:k] for t in triangles for k in [t.index(min(t))]) if np.isfinite(corners).all() else None


def same_surface(mesh, vertices=VERTICES, faces=FACES):
    assert in_order(mesh.corners) == in_order(np.asarray(vertices, float)[np.asarray(faces)])


@pytest.mark.parametrize("ending", files.ENDINGS)
def test_every_format_is_read(read, ending):
    mesh = read(f"a.{ending}", files.good()[ending])
    same_surface(mesh)
    assert volume(mesh) == pytest.approx(1)
    assert (mesh.vertices.dtype, mesh.faces.dtype) == (np.float64, np.int32)
    assert mesh.name.endswith(f"a.{ending}")


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_every_kind_of_ply_is_read(read, kind, end):
    head, mark, body = files.ply(kind=kind).partition(b"end_header\n")
    head = (head + mark).replace(b"\n", end.encode())
    same_surface(read("a.ply", head + (body.replace(b"\n", end.encode()) if kind == "ascii" else body)))


@pytest.mark.parametrize("data", [files.ascii_stl(), files.ascii_stl(name="a vertex facet\xe9").upper()])
def test_an_ascii_stl_is_read(read, data):
    same_surface(read("a.stl", data))
    same_surface(read("cr.stl", data.replace(b"\n", b"\r\n")))


def test_two_solids_in_one_stl_are_read(read):
    data = files.ascii_stl(name="solid one") + files.ascii_stl(VERTICES + 5, name="two solid")
    same_surface(read("a.stl", data), np.concatenate([VERTICES, VERTICES + 5]), np.concatenate([FACES, FACES + 4]))


def test_a_binary_stl_whose_header_says_solid_is_read(read):
    for header in (b"solid", b"solid facet normal", b"SOLID vertex\nendsolid"):
        same_surface(read("a.stl", files.stl(header=header)))


def test_a_binary_stl_with_trailing_bytes_is_read(read):
    same_surface(read("a.stl", files.stl() + b"COLOR=whatever"))
    same_surface(read("b.stl", files.stl(header=b"solid x") + bytes(70)))


@pytest.mark.parametrize("ending", ["obj", "off", "ply", "bin.ply"])
def test_polygons_are_cut_into_triangles(read, ending):
    angle = np.arange(7) * 2 * np.pi / 7
    vertices = np.stack([np.cos(angle), np.sin(angle), angle * 0], axis=1).round(4)
    polygons = [[0, 1, 2], [0, 2, 3, 4], [0, 4, 5, 6]]
    make = {"obj": files.obj, "off": files.off, "ply": lambda *a: files.ply(*a, kind="ascii"), "bin.ply": files.ply}
    area = 7 / 2 * np.sin(2 * np.pi / 7)
    for given in (polygons, [range(7)], [*polygons[:1], [0, 2, 3, 4, 5, 6]]):
        mesh = read(f"a.{ending}", make[ending](vertices, given))
        a, b, c = mesh.corners.transpose(1, 0, 2)
        up = np.cross(b - a, c - a)[:, 2] / 2
        assert len(mesh.faces) == 5
        assert (up > 0).all()
        assert up.sum() == pytest.approx(area, abs=1e-3)


def test_everything_but_the_surface_of_an_obj_is_ignored(read, tmp_path):
    data = (
        b"\xef\xbb\xbf# caf\xe9\nmtllib missing.mtl\no one\nv 0 0 0 1 0 0\nvt 0 0\nv 1 0 0 0.5 1 0\nvn 0 0 1\r\n"
        b"usemtl x\n\tv  0 2\t0 # a comment\nv 0 \\\n0 3\nl 1 2\np 3\ns off\ng a\n"
        b"f 1/1/1 3//1 2/1 # f 9 9 9\nf 1 2 4\n  f 1 4 \\\n3\nf 1 2\nf 2/1 3 4//1\nfoo 1 2 3"
    )
    (tmp_path / "missing.mtl").mkdir()  # cannot be opened
    same_surface(read("a.obj", data))
    same_surface(read("mac.obj", files.obj().replace(b"\n", b"\r")))
    same_surface(read("long.obj", b"# long\n" * 20_000 + files.obj()))


def test_relative_indices_of_an_obj_count_back_from_their_line(read):
    one = b"v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf -4 -2 -3\nf -4/-1 -3 -1\nf -4 -1 -2//-7\nf -3 -2 -1\n"
    data = one + one.replace(b"v 0 0 0", b"v 0 0 -9")
    moved = VERTICES.copy()
    moved[0, 2] = -9
    same_surface(read("a.obj", data), np.concatenate([VERTICES, moved]), np.concatenate([FACES, FACES + 4]))


def test_an_off_with_colours_normals_and_comments_is_read(read):
    data = b"# first\nCNOFF 4 4 0 # counts\n\n"
    data += b"".join(b"%g %g %g 0 0 1 255 0 0 255\n" % tuple(v) for v in VERTICES) + b"# faces\n"
    data += b"".join(b"3 %d %d %d 0.5 0.5 0.5\r\n" % tuple(f) for f in FACES)
    same_surface(read("a.off", data))


def test_a_ply_with_other_elements_in_between_is_read(read):
    vertex = ("uchar red", *XYZ, "float nx")
    face = ("uchar flags", "list uchar float texcoord", "list int uint vertex_index", "short y")
    head = ply_header(
        "binary_big_endian", ("edge", 1, LIST), ("vertex", 4, vertex), ("face", 4, face), ("more", 9, ["int q"])
    )
    body = struct.pack(">B2i", 2, 0, 1) + b"".join(struct.pack(">B4f", 9, *v, 7) for v in VERTICES)
    body += b"".join(
        struct.pack(f">BB{k}fi3Ih", 1, k, *[0.5] * k, 3, *f, 5) for k, f in zip((6, 0, 6, 2), FACES, strict=True)
    )
    same_surface(read("a.ply", head + body))


def test_triangle_strips_are_read(read):
    y, x = np.mgrid[0:3, 0:4]
    vertices = np.stack([x, y, x * 0], axis=-1).reshape(-1, 3)
    rows = [[i for col in range(4) for i in (4 * row + 4 + col, 4 * row + col)] for row in range(2)]
    joined = [*rows[0], rows[0][-1], rows[1][0], *rows[1]]  # joined by triangles without area
    split = [*rows[0], -1, *rows[1]]
    for strip in (joined, split):
        head = ply_header(
            "binary_little_endian", ("vertex", 12, XYZ), ("tristrips", 1, ["list int int vertex_indices"])
        )
        body = vertices.astype("<f4").tobytes() + struct.pack(f"<{len(strip) + 1}i", len(strip), *strip)
        mesh = read("a.ply", head + body)
        a, b, c = mesh.corners.transpose(1, 0, 2)
        assert np.allclose(np.cross(b - a, c - a), [0, 0, 1])
        assert len(mesh.faces) == 12


def test_nonfinite_vertices_are_read(read):
    vertices = np.append(VERTICES, [[np.nan, 0, np.inf]], axis=0)
    faces = np.append(FACES, [[0, 1, 4]], axis=0)
    for name, make in (("a.obj", files.obj), ("a.ply", files.ply), ("a.stl", files.stl), ("a.off", files.off)):
        mesh = read(name, make(vertices, faces))
        assert len(mesh.faces) == 5
        assert np.isnan(mesh.vertices).any()
        assert clean_mesh(mesh)[2].nonfinite_faces == 1


def test_transforms_in_a_scene_are_applied(read):
    quarter = [0, 0, np.sqrt(0.5), np.sqrt(0.5)]
    nodes = [
        {"children": [1, 2], "translation": [10, 0, 0], "camera": 0},
        {"mesh": 0, "rotation": quarter, "scale": [2, 1, 1], "translation": [0, 0, 5]},
        {"mesh": 0, "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1], "children": [3]},
        {"mesh": 0, "scale": [1, -1, 1], "name": "world"},
        {"mesh": 0, "name": "in no scene"},
    ]
    x, y, z = VERTICES.T
    parts = [
        np.stack([10 - y, 2 * x, 5 + z], axis=1),
        np.stack([11 - x, 2 + y, 3 + z], axis=1),
        np.stack([11 - x, 2 - y, 3 + z], axis=1),
    ]
    turned = FACES[:, ::-1]  # mirrored once; mirroring twice restores the winding
    faces = np.concatenate([FACES, turned + 4, FACES + 8])
    for scenes in ({"scenes": [{"nodes": [4]}, {"nodes": [0]}], "scene": 1}, {"scenes": [{"nodes": [0]}]}):
        mesh = read("a.glb", files.glb(tree(nodes=nodes, cameras=[{}], **scenes)))
        same_surface(mesh, np.concatenate(parts), faces)
        assert volume(mesh) == pytest.approx(2 + 1 + 1)


def test_a_file_without_scenes_or_nodes_is_read(read):
    content, data = tree(nodes=[{"children": [1]}, {"mesh": 0, "translation": [0, 0, 1]}])
    del content["scenes"], content["scene"]
    same_surface(read("a.glb", files.glb((content, data))), VERTICES + np.float32([0, 0, 1]))
    del content["nodes"]
    same_surface(read("b.glb", files.glb((content, data))))


def test_a_very_deep_scene_is_read_quickly(read):
    nodes = [{"children": [i + 1], "translation": [1, 0, 0]} for i in range(3000)] + [{"mesh": 0}]
    began = time.perf_counter()
    same_surface(read("a.gltf", files.gltf(tree(nodes=nodes))), VERTICES + np.float32([3000, 0, 0]))
    assert time.perf_counter() - began < 10


def test_everything_but_the_surface_of_a_scene_is_ignored(read):
    content, data = tree()
    surface = {"attributes": {"POSITION": 0, "TEXCOORD_0": 99, "COLOR_0": -1}, "indices": 1, "material": 7}
    points = {"attributes": {"POSITION": 0}, "mode": 0, "material": 3}
    content["meshes"] = [{"primitives": [points, surface, {"attributes": {}}]}, {"primitives": [points]}]
    content["nodes"] = [{"mesh": 1, "translation": [0, 0, 4], "children": [1], "skin": 5}, {"mesh": 0, "camera": 9}]
    content["images"] = [{"uri": "../../secret.png"}, {"uri": "http://example.org/a.png"}]
    content["textures"] = content["materials"] = content["samplers"] = content["animations"] = [{"source": 0}]
    content["extensionsRequired"] = ["KHR_texture_transform"]
    content["accessors"][0]["max"] = [float("nan")] * 3
    content["bufferViews"].append({"buffer": 77})
    content["accessors"].append({"count": 10**12, "componentType": 5126, "type": "MAT4"})
    same_surface(read("a.glb", files.glb((content, data))), VERTICES + np.float32([0, 0, 4]))


def test_strips_and_interleaved_positions_in_a_scene_are_read(read):
    rows = np.zeros((4, 6), "<f4")
    rows[:, :3] = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]
    content, _ = tree(meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "mode": 5}]}])
    content["buffers"] = [{"byteLength": rows.nbytes}]
    content["bufferViews"] = [{"buffer": 0, "byteLength": rows.nbytes, "byteStride": 24}]
    mesh = read("a.glb", files.glb((content, rows.tobytes())))
    same_surface(mesh, rows[:, :3], [[0, 1, 2], [2, 1, 3]])


def test_units_are_assumed_stated_or_given(read):
    assert {e: read(f"a.{e}", d).mm_per_unit for e, d in files.good().items()} == {
        "obj": 1, "ply": 1, "stl": 1, "off": 1, "glb": 1000, "gltf": 1000,
    }  # fmt: skip
    stated = {e: read(f"a.{e}", d).unit_from for e, d in files.good().items()}
    assert [stated[e] for e in files.ENDINGS] == ["assumed"] * 4 + ["file"] * 2
    for unit, mm in (("mm", 1), ("cm", 10), ("in", 25.4), ("m", 1000)):
        for ending in ("stl", "glb"):
            mesh = read(f"a.{ending}", files.good()[ending], unit=unit)
            assert (mesh.mm_per_unit, mesh.unit_from) == (mm, "given")
            assert mesh.vertices.max() == 3
            assert mesh.vertices_mm.max() == pytest.approx(3 * mm)


def test_invalid_options_are_refused(tmp_path):
    with pytest.raises(UsageError, match=r"`unit='ft'`: use one of mm, cm, in, m$"):
        read_mesh(tmp_path / "missing.obj", unit="ft")
    with pytest.raises(UsageError, match="`max_faces=0`: must be at least 1"):
        read_mesh(tmp_path / "missing.obj", max_faces=0)


@pytest.mark.parametrize("ending", ["stl", "ply", "obj", "glb"])
def test_written_meshes_are_read_back(tmp_path, ending):
    write_mesh(Mesh(VERTICES.astype(float), FACES), tmp_path / f"a.{ending}")
    mesh = read_mesh(str(tmp_path / f"a.{ending}"))
    assert mesh.mm_per_unit == (1000 if ending == "glb" else 1)
    same_surface(Mesh(mesh.vertices_mm.round(6), mesh.faces))  # 0.003 m are 3.0000000001 mm


def test_file_names_of_every_kind_are_accepted(tmp_path):
    for name in ("größe 頭.OBJ", "%s {0}.obj", os.fsdecode(b"caf\xe9.obj")):
        (tmp_path / name).write_bytes(files.obj())
        mesh = read_mesh(tmp_path / name)
        assert len(mesh.faces) == 4
        assert mesh.name == str(tmp_path / name)


def test_the_state_of_trimesh_is_not_changed(read):
    log, level = logging.getLogger("trimesh"), logging.getLogger("trimesh").level
    read("a.glb", files.glb())
    assert log.level == level
    done = []
    worker = threading.Thread(target=lambda: done.append(read("b.stl", files.stl())))
    worker.start()
    worker.join()
    assert len(done[0].faces) == 4


def test_importing_the_reader_loads_nothing_heavy():
    script = "import sys, nmaptool.io.meshes.reader; print('trimesh' in sys.modules, 'scipy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "False"]


def test_seventy_thousand_faces_are_read_quickly(read):
    y, x = np.mgrid[0:190, 0:190]
    vertices = np.stack([x, y, np.sin(x)], axis=-1).reshape(-1, 3)
    i = (y[:-1, :-1] * 190 + x[:-1, :-1]).ravel()
    data = files.obj(vertices, np.stack([i, i + 1, i + 191, i + 190], axis=1))
    read("warm.obj", files.obj())
    began = time.perf_counter()
    mesh = read("a.obj", data)
    assert time.perf_counter() - began < 5
    assert len(mesh.faces) == 2 * 189**2


def test_a_gltf_may_begin_with_a_byte_order_mark(read):
    same_surface(read("a.gltf", b"\xef\xbb\xbf" + files.gltf()))
    same_surface(read("b.gltf", json.dumps(json.loads(files.gltf()), indent=4).encode()))
