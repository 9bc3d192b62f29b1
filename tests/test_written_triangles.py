"""The check of files that were just written: every kind of damage in every format is named."""

from __future__ import annotations

import json
import re
import struct
import zipfile

import numpy as np
import pytest

import nmaptool as nm
from nmaptool.io.solids.check import check_written
from nmaptool.io.solids.threemf import MODEL_PATH
from nmaptool.io.solids.writer import write_solid
from nmaptool.types.solid import Body, NumberedBody, Part, Solid

ENDINGS = [".stl", ".ply", ".obj", ".glb", ".3mf"]


def islands(base="2mm"):
    """Two motifs of 4 x 3 and 2 x 2 pixels: two bodies, or an open surface."""
    mask = np.zeros((6, 9), bool)
    mask[1:4, 1:5] = mask[3:5, 6:8] = True
    height = nm.Height(np.random.default_rng(2).random((7, 10)), mask, nm.Frame(6, 9, pitch_mm=0.7))
    return nm.solid(height, nm.SolidOptions(base=nm.length(base) if base else None))


def replaced(old, new, count=1):
    """A change of the first places where bytes stand."""

    def change(data):
        assert old in data
        return data.replace(old, new, count)

    return change


def substituted(pattern, new):
    def change(data):
        changed, count = re.subn(pattern, new, data, count=1)
        assert count == 1
        return changed

    return change


def at(place, new):
    """A change of the bytes at a place; from the end if it is negative."""

    def change(data):
        start = place % len(data)
        return data[:start] + new + data[start + len(new) :]

    return change


def without_the_end(data):
    return data[:-5]


def with_more(data):
    return data + b"\0"


def model(change):
    """A change of the model in a 3MF file."""

    def changed(path):
        with zipfile.ZipFile(path) as archive:
            entries = {name: archive.read(name) for name in archive.namelist()}
        with zipfile.ZipFile(path, "w") as archive:
            for name, data in entries.items():
                archive.writestr(name, change(data) if name == MODEL_PATH else data)

    return changed


def whole(change):
    return lambda path: path.write_bytes(change(path.read_bytes()))


def scene(change):
    """A change of the description in a GLB file, which keeps its length."""

    def changed(data):
        (size,) = struct.unpack("<I", data[12:16])
        told = json.loads(data[20 : 20 + size])
        change(told)
        text = json.dumps(told, separators=(",", ":")).encode()
        assert len(text) <= size + 8
        text += b" " * (-len(text) % 4)
        total = len(data) + len(text) - size
        return data[:8] + struct.pack("<II", total, len(text)) + b"JSON" + text + data[20 + size :]

    return changed


def other_bounds(told):
    told["accessors"][0]["max"][0] += 0.001


def other_type(told):
    told["accessors"][1]["componentType"] = 5123


def other_size(told):
    told["buffers"][0]["byteLength"] += 4


def no_mesh(told):
    del told["nodes"][0]["mesh"]


OTHER_FORM = "its header has another form"
DAMAGES = [
    (".stl", whole(at(80, b"\x01")), "it holds 98 triangles instead of 1;"),
    (".stl", whole(with_more), "it has 4985 bytes instead of 4984"),
    (".stl", whole(lambda data: data[:40]), OTHER_FORM),
    (".stl", whole(at(84 + 12, struct.pack("<f", float("nan")))), r"its size is off by nan mm"),
    (".ply", whole(replaced(b"nmaptool, mm", b"nmaptool, m")), OTHER_FORM),
    (".ply", whole(replaced(b"element vertex", b"element vertes")), OTHER_FORM),
    (".ply", whole(without_the_end), r"it has \d+ bytes instead of \d+"),
    (".ply", whole(at(-13, b"\x04")), "it has faces that are not triangles"),
    (".ply", whole(at(-12, struct.pack("<i", 9999))), "1 of its triangles have corners that do not exist"),
    (".ply", whole(at(-12, struct.pack("<i", 0))), "it is not closed"),
    (".glb", whole(replaced(b"glTF", b"glTX")), OTHER_FORM),
    (".glb", whole(without_the_end), r"it has \d+ bytes instead of \d+"),
    (".glb", whole(replaced(b"BIN\0", b"BIN ")), OTHER_FORM),
    (".glb", whole(scene(other_bounds)), "its bounds are not those of its vertices"),
    (".glb", whole(scene(other_type)), "its arrays have another form"),
    (".glb", whole(scene(other_size)), OTHER_FORM),
    (".glb", whole(scene(no_mesh)), OTHER_FORM),
    (".glb", whole(at(-4, struct.pack("<i", -2))), "1 of its triangles have corners that do not exist"),
    (".obj", whole(substituted(rb"\nv 0", rb"\nv x0")), r"it has the line 'v x0"),
    (".obj", whole(substituted(rb"\nf \d+", rb"\nf 9999")), "1 of its triangles have corners that do not exist"),
    (".obj", whole(substituted(rb"\nf \d+", rb"\nf 99999999999")), r"it has the line 'f 99999999999"),
    (".obj", whole(substituted(rb"\nf .*", b"")), r"it holds 97 triangles instead of 98"),
    (".obj", whole(lambda data: re.sub(rb"\nv .*", b"", data)), "it has triangles without vertices"),
    (".3mf", model(replaced(b'v2="', b'w2="')), r"it has the line '<triangle v1=\"\d+\" w2="),
    (".3mf", model(substituted(rb'v1="\d+"', b'v1="77777"')), "1 of its triangles have corners that do not exist"),
    (".3mf", model(substituted(rb'y="[^"]*"', b'y="0.5e-30"')), r"its size is off by 0\.7 mm"),
    (".3mf", whole(without_the_end), r"it cannot be unpacked \(File is not a zip file\)"),
    (".3mf", whole(replaced(b"3dmodel.model", b"3dmodel.modem", 3)), r"it cannot be unpacked \(.*3dmodel.model"),
]


@pytest.mark.parametrize(("ending", "damage", "message"), DAMAGES)
def test_damage_is_named(tmp_path, ending, damage, message):
    solid, path = islands(), tmp_path / f"a{ending}"
    write_solid(solid, path)
    assert solid.face_count == 98
    damage(path)
    with pytest.raises(nm.OutputError, match=rf"a\{ending}: failed the check after writing: {message}"):
        check_written(solid, path)


def test_a_damaged_stream_of_a_3mf_is_named(tmp_path):
    solid, path = islands(), tmp_path / "a.3mf"
    write_solid(solid, path)
    data = bytearray(path.read_bytes())
    middle = len(data) // 2
    data[middle : middle + 20] = bytes(20)
    path.write_bytes(data)
    with pytest.raises(nm.OutputError, match=r"it cannot be unpacked \("):
        check_written(solid, path)


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("base", ["2mm", None])
def test_files_of_several_bodies_pass(tmp_path, ending, base):
    solid, path = islands(base), tmp_path / f"a{ending}"
    write_solid(solid, path)
    assert len(solid.bodies) == (2 if base else 1)
    back = nm.read_mesh(path)
    assert len(back.faces) == solid.face_count
    if ending != ".stl":
        expected = solid.to_mesh()
        assert np.abs(back.vertices_mm - expected.vertices).max() < 1e-6
        assert np.array_equal(back.faces, expected.faces)


@pytest.mark.parametrize("ending", [".obj", ".3mf"])
@pytest.mark.parametrize("size_mm", [1e-13, 3e-4, 4e11])
def test_numbers_of_any_size_pass(tmp_path, ending, size_mm):
    mask = np.ones((3, 4), bool)
    z_mm = np.random.default_rng(3).random((4, 5)) * size_mm
    solid = nm.solid(nm.Height(z_mm, mask, nm.Frame(3, 4, pitch_mm=size_mm)), nm.SolidOptions(outline="exact"))
    path = tmp_path / f"a{ending}"
    write_solid(solid, path)
    assert np.allclose(nm.read_mesh(path).vertices, solid.to_mesh().vertices, rtol=1e-8, atol=1e-9 * size_mm)


def test_vertices_that_later_parts_use_are_numbered_then():
    points = np.arange(15.0).reshape(5, 3)
    nodes = np.arange(5)
    parts = [
        Part(points, np.array([[0, 1, 3]], np.int32), nodes),
        Part(points, np.array([[3, 4, 0]], np.int32), nodes),
        Part(points[:2], np.zeros((0, 3), np.int32), nodes[:2]),
    ]
    body = Body("three parts", lambda: iter(parts), 2, 5)
    numbered = NumberedBody.of(body, is_measured=True)
    assert numbered.numbers.tolist() == [0, 1, -1, 2, 3]
    assert numbered.vertex_count == 4
    assert np.concatenate(list(numbered.vertices())).tolist() == points[[0, 1, 3, 4]].tolist()
    assert np.concatenate(list(numbered.faces())).tolist() == [[0, 1, 2], [2, 3, 0]]
    assert numbered.bounds_mm.tolist() == [[0, 1, 2], [12, 13, 14]]
    mesh = Solid((body,), False, numbered.bounds_mm).to_mesh()
    assert mesh.faces.tolist() == [[0, 1, 2], [2, 3, 0]]
