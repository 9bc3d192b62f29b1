"""Text meshes as other programs write them, compared with trimesh where it reads them as well."""

import io
import struct

import mesh_files as files
import numpy as np
import pytest
import trimesh
from mesh_files import FACES, LIST, VERTICES, XYZ, ply_header, volume

from nmaptool.core.errors import InputError
from nmaptool.io.meshes.reader import read_mesh
from nmaptool.meshes.clean import clean_mesh


@pytest.fixture
def read(tmp_path):
    """``read("a.obj", data)``: the mesh in those bytes."""

    def call(name, data):
        (tmp_path / name).write_bytes(data)
        return read_mesh(tmp_path / name)

    return call


@pytest.fixture
def same(read):
    """``same("a.obj", data)``: the tetrahedron, for us and, unless said otherwise, for trimesh."""

    def call(name, data, with_trimesh=True, notes=()):
        mesh = read(name, data)
        assert mesh.notes == notes
        corners = mesh.corners
        assert np.allclose(corners, VERTICES[FACES])
        if with_trimesh:
            kind = name.rpartition(".")[2]
            theirs = trimesh.load(io.BytesIO(data), file_type=kind, force="mesh", process=False)
            assert np.allclose(theirs.triangles, corners)

    return call


TEXTS = {
    "a.obj": files.obj(),
    "a.off": files.off(),
    "a.ply": files.ply(kind="ascii"),
    "a.stl": files.ascii_stl(),
    "a.gltf": files.gltf(),
}


@pytest.mark.parametrize("code", ["utf-8-sig", "utf-16", "utf-16-le", "utf-16-be"])
@pytest.mark.parametrize("name", TEXTS)
def test_texts_with_a_byte_order_mark_are_read(same, name, code):
    mark = "\ufeff" if code in ("utf-16-le", "utf-16-be") else ""
    text = TEXTS[name].decode()
    same(name, (mark + text).encode(code), with_trimesh=False)
    same(name, (mark + text.replace("\n", "\r\n")).encode(code), with_trimesh=False)


@pytest.mark.parametrize("name", ["a.obj", "a.off", "a.ply", "a.stl"])
@pytest.mark.parametrize("end", [b"\r\n", b"\r"])
def test_line_ends_of_every_system_are_read(same, name, end):
    same(name, TEXTS[name].replace(b"\n", end), with_trimesh=False)
    same(name, TEXTS[name].rstrip(b"\n").replace(b"\n", end), with_trimesh=False)
    if name in ("a.obj", "a.off"):
        same(name, (b"# made by hand\n" + TEXTS[name]).replace(b"\n", end), with_trimesh=False)


@pytest.mark.parametrize("name", ["a.obj", "a.off", "a.ply", "a.stl"])
def test_odd_white_space_is_read(same, name):
    head, mark, body = TEXTS[name].partition(b"end_header\n") if name == "a.ply" else (b"", b"", TEXTS[name])
    lines = [b"\t" + line.replace(b" ", b" \t ") + b"  \t" for line in body.split(b"\n")]
    if name == "a.off":
        lines[0] = b"OFF"
    same(name, head + mark + b"\n".join(lines), with_trimesh=name in ("a.off", "a.stl"))


@pytest.mark.parametrize("name", TEXTS)
def test_latin_letters_in_comments_and_names_are_read(same, name):
    data = {
        "a.obj": b"# caf\xe9\no t\xeate\n" + TEXTS["a.obj"] + b"# \xff\xfe\n",
        "a.off": b"OFF # caf\xe9\n" + TEXTS["a.off"][4:],
        "a.ply": TEXTS["a.ply"].replace(b"made by hand", b"made by Ren\xe9"),
        "a.stl": TEXTS["a.stl"].replace(b"thing", b"t\xeate vertex 1"),
        "a.gltf": TEXTS["a.gltf"].replace(b'"asset"', '"extras": "tête", "asset"'.encode()),
    }
    same(name, data[name], with_trimesh=False)


def test_extra_columns_of_an_obj_are_ignored(same):
    for more in (b" 1", b" 0.5 0.5 0.5", b" 1 0.5 0.5 0.5", b" 0.5 0.5 0.5 1"):
        lines = [line + more if line.startswith(b"v ") else line for line in files.obj().split(b"\n")]
        same("a.obj", b"\n".join(lines), with_trimesh=more != b" 0.5 0.5 0.5 1")


def test_a_line_of_an_obj_may_go_on_in_the_next(same):
    data = files.obj().replace(b"v 1 0 0", b"v 1 \\\n0 \\\r\n0").replace(b"f 1 2 4", b"f 1 \\  \n2\\\n 4")
    same("a.obj", data, with_trimesh=False)


@pytest.mark.parametrize("word", [b"1.0D+00", b"1d0", b"1.0D0", b"10.0D-01", b"+.1E+01", b"1.e0"])
def test_exponents_of_fortran_are_read(same, word):
    same("a.obj", files.obj().replace(b"v 1 0 0", b"v %b 0 0" % word), with_trimesh=b"E" in word)
    same("a.off", files.off().replace(b"\n1 0 0\n", b"\n%b 0 0\n" % word), with_trimesh=b"E" in word)
    same("a.ply", files.ply(kind="ascii").replace(b"\n1 0 0\n", b"\n%b 0 0\n" % word), with_trimesh=b"E" in word)
    same("a.stl", files.ascii_stl().replace(b"vertex 1 0 0", b"vertex %b 0 0" % word), with_trimesh=b"E" in word)


@pytest.mark.parametrize("word", [b"nan", b"-nan", b"NaN", b"1.#QNAN", b"-1.#IND00", b"1.#INF", b"nan(ind)", b"inf"])
def test_unused_vertices_without_a_position_are_no_fault(read, word):
    mesh = read("a.obj", files.obj().replace(b"f 1", b"v 0 %b 0\nf 1" % word, 1))
    assert len(mesh.vertices) == 5
    _, _, findings = clean_mesh(mesh)
    assert (findings.nonfinite_vertices, findings.nonfinite_faces) == (1, 0)
    data = ply_header("ascii", ("vertex", 5, XYZ), ("face", 4, LIST))
    body = files.ply(kind="ascii").partition(b"end_header\n")[2]
    mesh = read("a.ply", data + body.replace(b"0 0 3\n", b"0 0 3\n%b 0 0\n" % word))
    assert clean_mesh(mesh)[2].nonfinite_faces == 0


@pytest.mark.parametrize(
    "header", [b"OFF\n4 4 0\n", b"OFF\n4 4\n", b"OFF 4 4 0\n", b"OFF\n\n# x\n4 4 0 # y\n\n", b"4 4 0\n"]
)
def test_headers_of_off_files_are_read(same, header):
    body = files.off().partition(b"4 4 0\n")[2]
    same("a.off", header + body, with_trimesh=header == b"OFF\n4 4 0\n")


@pytest.mark.parametrize(
    ("word", "more"),
    [(b"COFF", b" 255 0 0 255"), (b"NOFF", b" 0 0 1"), (b"STOFF", b" 0.5 0.5"), (b"CNOFF", b" 0 0 1 9 9 9 1")],
)
def test_colours_and_normals_of_off_files_are_ignored(same, word, more):
    lines = files.off().split(b"\n")
    lines[0] = word
    lines[2:6] = [line + more for line in lines[2:6]]
    lines[6:10] = [line + b" 200 100 0" for line in lines[6:10]]
    same("a.off", b"\n".join(lines), with_trimesh=word in (b"COFF",))


@pytest.mark.parametrize("word", [b"4OFF", b"nOFF"])
def test_off_files_of_other_dimensions_are_refused(read, word):
    with pytest.raises(
        InputError, match=r"holds OFF data of other than three dimensions; export it as OBJ, PLY or STL$"
    ):
        read("a.off", files.off().replace(b"OFF", word))


@pytest.mark.parametrize("counts", [(4, 5), (5, 5), (4, 3)])
def test_lines_missing_from_an_off_file_are_counted(read, counts):
    pattern = (
        rf"declares {counts[0]} vertices and {counts[1]} faces but holds 8 lines of them: the OFF file is truncated"
    )
    with pytest.raises(InputError, match=pattern):
        read("a.off", files.off(counts=counts))


def test_an_stl_without_its_last_line_is_read_with_a_warning(same):
    data = files.ascii_stl()
    note = ("its last line, 'endsolid', is missing: faces may be lost; export or download it again if so",)
    same("a.stl", data[: data.rfind(b"endsolid")], notes=note, with_trimesh=False)
    same("a.stl", data[: data.rfind(b"\nendsolid")].upper(), notes=note, with_trimesh=False)


def test_an_stl_of_several_solids_in_capitals_is_read(read):
    one, two = files.ascii_stl(name="A b"), files.ascii_stl(VERTICES + 5, name="")
    mesh = read("a.stl", (one + two).upper())
    assert len(mesh.faces) == 8
    assert volume(mesh) == pytest.approx(2)
    assert mesh.notes == ()


def test_rows_of_a_ply_with_more_values_than_declared_are_read(same):
    head = ply_header("ascii", ("vertex", 4, XYZ), ("face", 4, [*LIST, "uchar red"]))
    points = b"".join(b"%g %g %g\n" % tuple(v) for v in VERTICES)
    wide = b"".join(b"%g %g %g 7 7\n" % tuple(v) for v in VERTICES)
    plain = b"".join(b"3 %d %d %d 255\n" % tuple(f) for f in FACES)
    longer = [b"3 %d %d %d 255 9 1 1 1\n" % tuple(f) for f in FACES]
    ignored = "more than the header declares, first in line"
    note = f"rows of its element face hold up to 4 values {ignored} 16; they were ignored"
    same("a.ply", head + points + b"".join(longer), notes=(note,), with_trimesh=False)
    mixed = b"".join([plain.split(b"\n")[0] + b"\n\n", *longer[1:]])  # after a blank line
    same("a.ply", head + points + mixed, notes=(note.replace("16", "18"),), with_trimesh=False)
    both = (f"rows of its element vertex hold up to 2 values {ignored} 12; they were ignored", note)
    same("a.ply", head + wide + b"".join(longer), notes=both, with_trimesh=False)
    with pytest.raises(InputError, match=r"the PLY file is truncated or damaged; export it again$"):
        same("a.ply", head + points + b"".join(longer[:-1]), with_trimesh=False)


@pytest.mark.parametrize("count", ["char", "uchar", "short", "ushort", "int", "uint", "int8", "uint16", "uint64"])
@pytest.mark.parametrize("index", ["short", "ushort", "int", "uint", "uint8", "int64"])
@pytest.mark.parametrize("order", ["<", ">"])
def test_lists_of_any_whole_numbers_are_read(same, count, index, order):
    code = {"char": "b", "int8": "b", "uchar": "B", "uint8": "B", "short": "h", "ushort": "H", "uint16": "H"}
    code |= {"int": "i", "uint": "I", "int64": "q", "uint64": "Q"}
    kind = "binary_little_endian" if order == "<" else "binary_big_endian"
    doubles = ("double x", "double y", "float64 z")
    head = ply_header(kind, ("vertex", 4, doubles), ("face", 4, [f"list {count} {index} vertex_index"]))
    body = b"".join(struct.pack(f"{order}3d", *v) for v in VERTICES)
    body += b"".join(struct.pack(f"{order}{code[count]}3{code[index]}", 3, *f) for f in FACES)
    same("a.ply", head + body, with_trimesh="64" not in count + index)


def test_strips_in_a_text_ply_are_read(read):
    head = ply_header("ascii", ("vertex", 4, XYZ), ("tristrips", 1, ["list int int vertex_indices"]))
    points = b"0 0 0\n1 0 0\n0 1 0\n1 1 0\n"
    mesh = read("a.ply", head + points + b"6 0 1 2 3 -1 0\n")
    assert mesh.faces.tolist() == [[0, 1, 2], [2, 1, 3]]
