"""Unusable mesh files: one line with the file, the fault and a remedy, without a traceback."""

import os
import re
import struct
import tracemalloc

import mesh_files as files
import numpy as np
import pytest
from cli_cases import LONG_NAMES
from mesh_files import FACES, LIST, VERTICES, XYZ, ply_header, tree

from nmaptool.core.errors import InputError, LimitError
from nmaptool.io.meshes import reader as mesh_reader
from nmaptool.io.meshes.reader import read_mesh

DAMAGED = r"file is truncated or damaged; export it again$"
NO_FACES = r"and no faces; make a mesh from the points first$"
ACCEPTED = "OBJ, PLY, STL, OFF, GLB, glTF, 3MF, DAE or USD"
KINDS = {"obj": "OBJ", "ply": "PLY", "stl": "STL", "off": "OFF", "glb": "GLB", "gltf": "glTF"}


@pytest.fixture
def refused(tmp_path, capfd):
    """``refused("a.obj", data, pattern)``: those bytes give an InputError of one line and no other output."""

    def call(name, data, pattern, error=InputError, **options):
        path = tmp_path / name
        path.write_bytes(data)
        with pytest.raises(error, match=pattern) as caught:
            read_mesh(path, **options)
        text = str(caught.value)
        assert text.startswith(f"{path}: ")
        assert "\n" not in text
        for word in ("trimesh", "Error", "None", "array", "['", "Traceback"):
            assert word not in text.replace(str(path), "")
        assert capfd.readouterr() == ("", "")

    return call


def test_missing_files_folders_and_devices_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"missing\.obj: no such file"):
        read_mesh(tmp_path / "missing.obj")
    (tmp_path / "folder.obj").mkdir()
    with pytest.raises(InputError, match=r"folder\.obj: is a folder; give a mesh file"):
        read_mesh(tmp_path / "folder.obj")
    with pytest.raises(InputError, match=r"is not a valid file name"):
        read_mesh("a\0.obj")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="Windows has no devices and pipes among its files")
def test_streams_and_devices_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"null: is a stream or device, not a file; save the mesh as a file"):
        read_mesh("/dev/null")
    os.mkfifo(tmp_path / "pipe.stl")
    with pytest.raises(InputError, match=r"pipe\.stl: is a stream or device, not a file"):
        read_mesh(tmp_path / "pipe.stl")


@LONG_NAMES
def test_a_name_that_is_too_long_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"cannot be read \(File name too long\)"):
        read_mesh(tmp_path / ("a" * 300 + ".obj"))


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="root may read everything")
def test_an_unreadable_file_is_refused(tmp_path):
    (tmp_path / "a.obj").write_bytes(files.obj())
    (tmp_path / "a.obj").chmod(0)
    with pytest.raises(InputError, match=r"a\.obj: cannot be read \(Permission denied\)"):
        read_mesh(tmp_path / "a.obj")


@pytest.mark.parametrize("ending", files.ENDINGS)
def test_empty_files_web_pages_and_other_texts_are_refused(refused, ending):
    refused(f"a.{ending}", b"", r"is empty; export or download it again$")
    for page in (b"<!DOCTYPE html>\n<html>", b"\n <HTML lang='de'>" + b"x" * 500):
        refused(f"a.{ending}", page, r"holds a web page instead of a mesh; download the mesh itself$")
    texts = (b"hello\n", b"version https://git-lfs.github.com/spec/v1\n" + b"oid sha256:0\n" * 9, b"\n" * 200)
    for text in texts:
        refused(f"a.{ending}", text, rf"holds no {KINDS[ending]} data; export it again as {ACCEPTED}$")
    refused(f"a.{ending}", b"PK\x03\x04" + bytes(100), r"is a ZIP archive; unpack it and use the mesh in it$")


def test_other_formats_are_refused(refused):
    refused("a.obj", b'{"name": "left-pad"}', r"holds no OBJ data")
    for name in ("a", "a.obj.txt", "a.cob"):
        refused(name, b"Caligari V00.01", rf"is not a mesh in a supported format; export it as {ACCEPTED}$")


@pytest.mark.parametrize("kind", files.ENDINGS)
def test_a_file_with_the_ending_of_another_format_is_refused(refused, kind):
    for ending in ("txt", *files.ENDINGS):
        if ending != kind:
            for data in {files.good()[kind], files.ascii_stl() if kind == "stl" else files.good()[kind]}:
                pattern = rf"holds {KINDS[kind]} data; rename it to a\.{kind}$"
                refused(f"a.{ending}", data, pattern)


@pytest.mark.parametrize("ending", files.ENDINGS)
def test_files_truncated_at_any_byte_are_refused(tmp_path, trials, ending):
    data = files.good()[ending]
    # a text may lose its last line end and the last digit of its last number
    whole = len(data) - (2 if ending in ("obj", "off") else 1)
    for length in range(1, len(data), len(data) // trials(len(data))):
        (tmp_path / f"a.{ending}").write_bytes(data[:length])
        try:
            mesh = read_mesh(tmp_path / f"a.{ending}")
        except InputError as error:
            assert re.search("export|download|mesh from the points", str(error))
        else:
            # an OBJ does not say how many faces it has
            assert length >= whole or (ending == "obj" and len(mesh.faces) < 4), length


@pytest.mark.parametrize("cut", [1, 30, 55, 120])
def test_a_truncated_stl_is_refused(refused, cut):
    pattern = r"STL file is truncated: it declares 4 faces but holds [123]; export or download it again$"
    refused("a.stl", files.stl()[:-cut], pattern)
    refused("b.stl", files.stl(header=b"solid x")[:-cut], pattern)
    refused("c.stl", files.stl()[: 84 - cut % 80], r"STL " + DAMAGED)


def test_a_truncated_or_damaged_ascii_stl_is_refused(refused):
    data = files.ascii_stl()
    for lines in (2, 4, 7):  # without the end of the last face
        text = b"\n".join(data.split(b"\n")[: -lines - 1])
        refused("a.stl", text, r"STL file is truncated: its end is missing; export or download it again$")
    refused("a.stl", b"solid", r"its end is missing")
    refused("a.stl", data.replace(b"vertex 1 0 0", b"", 1), DAMAGED)
    refused("a.stl", data.replace(b"vertex 1 0 0", b"vertex 1 0", 1), DAMAGED)
    refused("a.stl", data.replace(b"vertex 1 0 0", b"vertex 1 x 0", 1), DAMAGED)
    refused("a.stl", data.replace(b"  endfacet\n", b"", 1), DAMAGED)
    refused("a.stl", b"solid x\nendsolid x\n", r"holds no faces; export it again as a surface")
    refused("a.stl", files.stl(faces=FACES[:0]), r"holds no faces; export it again as a surface")


def test_points_without_faces_are_refused(refused):
    none = FACES[:0]
    for name, make in (("a.obj", files.obj), ("a.ply", files.ply), ("a.off", files.off)):
        refused(name, make(VERTICES, none), rf"holds 4 points {NO_FACES}")
        refused(name, make(VERTICES, [[0, 1], [2, 3]]), rf"holds 4 points {NO_FACES}")
    refused("a.ply", files.ply(VERTICES, none, kind="ascii"), rf"holds 4 points {NO_FACES}")
    refused("a.obj", files.obj(VERTICES, none) + b"l 1 2\np 3\n", rf"holds 4 points {NO_FACES}")
    for mode in (0, 1, 2, 3):
        primitive = {"attributes": {"POSITION": 0}, "mode": mode}
        refused("a.glb", files.glb(tree(meshes=[{"primitives": [primitive]}])), rf"holds 4 points {NO_FACES}")
    refused("a.glb", files.glb(tree(scenes=[{}])), r"holds no faces; export it again as a surface$")
    refused("a.glb", files.glb(tree(meshes=[], nodes=[])), r"holds no faces; export it again as a surface$")


@pytest.mark.parametrize("index", [4, 300, 60000])
def test_a_face_with_a_missing_vertex_is_refused(refused, index):
    faces = FACES.copy()
    faces[2, 1] = index
    for ending, make in (("obj", files.obj), ("ply", files.ply), ("off", files.off)):
        stated = index + (ending == "obj")
        pattern = rf"refers to vertex {stated}, which is missing \(vertices: 4\); export it again$"
        refused(f"a.{ending}", make(VERTICES, faces), pattern)
    pattern = rf"refers to vertex {index}, which is missing \(vertices: 4\)"
    refused("a.ply", files.ply(VERTICES, faces, kind="ascii"), pattern)
    refused("a.glb", files.glb(tree(VERTICES, faces)), pattern)


def test_invalid_indices_are_refused(refused):
    data = files.obj(VERTICES, FACES[:3])
    refused("a.obj", data + b"f 1 2 0\n", r"refers to vertex 0, but OBJ files count from 1; export it again$")
    refused("a.obj", data + b"f 1/1 -0/2 3\n", r"refers to vertex 0, but OBJ files count from 1")
    refused("a.obj", data + b"f -1 -4 -5\n", r"refers to vertex -5, which is missing \(vertices: 4\); export it")
    refused("a.obj", b"f -1 -2 -3\n" + data, r"refers to vertex -1, which is missing \(vertices: 0\); export it")
    for face in (b"f 1 2 x\n", b"f 1 2 3.5\n", b"f 1 2 --3\n", b"f 1 2", b"f 1 2 %d\n" % 10**30):
        refused("a.obj", data + face, rf"OBJ {DAMAGED}|refers to vertex 1")
    refused("a.ply", files.ply(VERTICES, [[0, 1, -1]]), r"refers to vertex -1, which is missing \(vertices: 4\)")
    refused("a.off", files.off(VERTICES, [[0, 1, -1]]), r"refers to vertex -1, which is missing \(vertices: 4\)")
    refused("a.ply", files.ply(VERTICES, [[0, 1, 2.5]], kind="ascii"), rf"PLY {DAMAGED}")


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("counts", [(4, 5), (5, 4), (3, 4), (4, 3), (4, 0), (10**9, 4), (-1, 4), (4, 10**7)])
def test_a_ply_with_wrong_counts_is_refused(refused, kind, counts):
    refused("a.ply", files.ply(kind=kind, counts=counts), rf"PLY {DAMAGED}")


@pytest.mark.parametrize("counts", [(4, 5), (5, 4), (3, 4), (4, 3), (10**9, 4), (4, 10**7)])
def test_an_off_with_wrong_counts_is_refused(refused, counts):
    refused("a.off", files.off(counts=counts), rf"OFF {DAMAGED}")


def test_invalid_headers_are_refused(refused):
    data = files.ply()
    for old, new in (
        (b"float z\n", b"floaty z\n"),
        (b"property float z\n", b""),
        (b"end_header", b"end"),
        (b"element face 4", b"element face"),
        (b"element face 4", b"element face x"),
        (b"format binary_little_endian", b"format binary"),
        (b"format binary_little_endian 1.0\n", b""),
        (b"list uchar int vertex_indices", b"list int"),
        (b"element vertex 4\n", b""),
        (b"property list uchar int vertex_indices\n", b""),
    ):
        refused("a.ply", data.replace(old, new), rf"PLY {DAMAGED}")
    for text in (b"OFF", b"OFF\n", b"OFF\n4\n", b"OFF\nx y 0\n", b"OFF\n-4 4 0\n", b"COFF\n1.5 3 0\n"):
        refused("a.off", text, rf"OFF {DAMAGED}")
    refused("a.off", b"OFF BINARY\n" + bytes(100), r"holds (binary|no) OFF data; .*export it")
    refused("a.off", files.off().replace(b"3 0 2 1", b"x 0 2 1"), rf"OFF {DAMAGED}")
    refused("a.off", files.off().replace(b"3 0 2 1", b"4 0 2 1"), rf"OFF {DAMAGED}")


def test_the_face_limit_is_enforced(refused, tmp_path):
    quads = [[0, 1, 2, 3], [0, 3, 2, 1]]
    cases = {
        **{f"a.{e}": d for e, d in files.good().items()},
        "b.stl": files.ascii_stl(),
        "b.obj": files.obj(VERTICES, quads),
    }
    cases.update({"b.ply": files.ply(VERTICES, quads), "b.off": files.off(VERTICES, quads)})
    for name, data in cases.items():
        pattern = r"[34] faces, more than the limit of 3; decimate it, or raise `max_faces`$"
        refused(name, data, pattern, LimitError, max_faces=3) if len(data) else None
        assert len(read_mesh(tmp_path / name, max_faces=4).faces) == 4


def test_the_face_limit_counts_every_instance_of_a_part(refused, tmp_path):
    data = files.glb(tree(nodes=[{"mesh": 0}] * 10, scenes=[{"nodes": list(range(10))}]))
    refused("a.glb", data, r"40 faces, more than the limit of 39", LimitError, max_faces=39)
    assert len(read_mesh(tmp_path / "a.glb", max_faces=40).faces) == 40
    data = files.glb(tree(np.zeros((1000, 3)), FACES))
    refused("a.glb", data, r"1000 vertices, more than the limit of 300 for 100 faces", LimitError, max_faces=100)


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("a.stl", files.stl(count=2 * 10**7)),
        ("a.ply", ply_header("binary_little_endian", ("vertex", 4 * 10**9, XYZ), ("face", 10, LIST)) + bytes(99)),
        ("b.ply", ply_header("ascii", ("vertex", 4, XYZ), ("face", 19_000_000, LIST)) + b"0 0 0\n"),
        ("c.ply", ply_header("binary_big_endian", ("face", 1, ["list uint int vertex_index"])) + b"\xff" * 99),
        ("a.off", b"OFF\n4000000000 10 0\n0 0 0\n"),
        ("a.glb", files.glb(tree(accessors=[{"componentType": 5126, "count": 10**9, "type": "VEC3"}] * 2))),
        ("b.glb", files.glb(tree(bufferViews=[{"buffer": 0, "byteLength": 2**40}] * 2))),
    ],
)  # fmt: skip
def test_a_header_without_its_data_takes_no_memory(tmp_path, name, data):
    (tmp_path / name).write_bytes(data)
    tracemalloc.start()
    try:
        with pytest.raises(InputError, match=rf"{name}: "):
            read_mesh(tmp_path / name)
        assert tracemalloc.get_traced_memory()[1] < 2e6  # bytes at the peak
    finally:
        tracemalloc.stop()


def test_headers_over_the_limit_are_refused_first(refused):
    head = ply_header("ascii", ("vertex", 4, XYZ), ("face", 10**9, LIST))
    refused("a.ply", head, r"1000000000 faces, more than the limit of 20000000; decimate it, or", LimitError)
    refused("a.off", b"OFF\n4 1000000000 0\n", r"1000000000 faces, more than the limit of 20000000", LimitError)


def test_running_out_of_memory_is_a_limit_error(refused, monkeypatch):
    def full(*_):
        raise MemoryError

    monkeypatch.setitem(mesh_reader._READERS, "stl", full)
    refused("a.stl", files.stl(), r"does not fit in memory; decimate it$", LimitError)


def test_unforeseen_parser_errors_become_one_clear_line(refused, monkeypatch):
    def stumble(*_):
        raise AssertionError("unforeseen\nin two lines")

    monkeypatch.setitem(mesh_reader._READERS, "stl", stumble)
    refused("a.stl", files.stl(), rf"STL {DAMAGED}")


def test_a_damaged_glb_header_is_refused(refused):
    data = files.glb()
    refused("a.glb", data[:4] + struct.pack("<I", 1) + data[8:], r"is not glTF version 2; export it as glTF 2\.0$")
    refused("a.glb", data[:-4], r"GLB file is truncated: it declares \d+ bytes but holds \d+; export or download")
