"""Reading USD with usd-core: transforms, units, layers of the same folder; and faults."""

import sys
from pathlib import Path

import numpy as np
import pytest
from mesh_files import VERTICES, volume
from pxr import Usd, UsdUtils

from nmaptool.core.errors import InputError, LimitError
from nmaptool.io.meshes.reader import read_mesh

TETRAHEDRON = """
    point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 2, 0), (0, 0, 3)]
    int[] faceVertexCounts = [3, 3, 3, 3]
    int[] faceVertexIndices = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]
    uniform token subdivisionScheme = "none"
"""
HEAD = '#usda 1.0\n(\n    metersPerUnit = 0.01\n    upAxis = "Y"\n)\n'
MESH = f'def Mesh "m"\n{{{TETRAHEDRON}}}\n'
OUTSIDE = r", but only files in its own folder are opened; flatten it to one file, such as with usdcat$"


@pytest.fixture
def read(tmp_path, capfd):
    """``read(text)``: the mesh in a USD text; reading prints nothing."""
    (tmp_path / "in").mkdir()

    def call(text, name="a.usda", **options):
        path = tmp_path / "in" / name
        if text is not None:
            path.write_text(text, encoding="utf-8")
        try:
            return read_mesh(path, **options)
        finally:
            assert capfd.readouterr() == ("", "")

    call.folder = tmp_path / "in"
    return call


def test_every_ending_is_read(read):
    text = read(HEAD + MESH)
    assert text.vertices.tolist() == VERTICES.tolist()
    assert (text.mm_per_unit, text.unit_from, text.up_from, text.notes) == (10, "file", "file", ())
    path = read.folder / "a.usda"
    for name in ("b.usdc", "c.usd"):
        Usd.Stage.Open(str(path)).Export(str(read.folder / name))
        assert read(None, name).vertices.tolist() == VERTICES.tolist()
    UsdUtils.CreateNewUsdzPackage(str(path), str(read.folder / "d.usdz"))
    assert read(None, "d.usdz").vertices.tolist() == VERTICES.tolist()
    (read.folder / "d.zip").write_bytes((read.folder / "d.usdz").read_bytes())
    with pytest.raises(InputError, match=r"holds USD data; rename it to d\.usdz$"):
        read(None, "d.zip")


def test_transforms_and_the_axis_that_points_up_are_applied(read):
    order = 'uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"]'
    placed = f"double3 xformOp:translate = (1, 2, 3)\nfloat3 xformOp:scale = (1, 1, -2)\n{order}\n"
    outer = f'def Xform "w" {{\n{placed}{MESH}}}\n'
    mesh = read(HEAD.replace('"Y"', '"Z"') + outer)
    x, y, z = VERTICES.T
    assert np.allclose(mesh.vertices, np.stack([1 + x, 3 - 2 * z, -2 - y], 1))
    assert volume(mesh) == pytest.approx(2)
    left = MESH.replace('"none"', '"none"\n    uniform token orientation = "leftHanded"')
    assert volume(read(HEAD + left)) == pytest.approx(-1)


def test_polygons_are_cut_and_invisible_meshes_ignored(read):
    quad = 'def Mesh "q" {\npoint3f[] points = [(0,0,0), (4,1,0), (0,2,0), (1,1,0)]\nint[] faceVertexCounts = [4]\n'
    quad += "int[] faceVertexIndices = [0, 1, 2, 3]\n}\n"
    hidden = MESH.replace('"m"', '"h"').replace("{", '{\n    token visibility = "invisible"', 1)
    guide = MESH.replace('"m"', '"p"').replace("{", '{\n    uniform token purpose = "guide"', 1)
    mesh = read(HEAD + quad + hidden + guide + 'def Sphere "s" {}\n')
    a, b, c = mesh.corners.transpose(1, 0, 2)
    area = np.cross(b - a, c - a)[:, 2] / 2
    assert (area > 0).all()
    assert area.sum() == pytest.approx(3)
    assert mesh.notes == ("took 1 subdivision mesh as polygons", "ignored prims of the types Sphere")


def test_layers_of_the_same_folder_are_read_and_no_others(read):
    (read.folder / "part.usda").write_text(HEAD + 'def Xform "x"\n{\n' + MESH + "}\n", encoding="utf-8")
    (read.folder.parent / "part.usda").write_text(HEAD + MESH, encoding="utf-8")
    reference = '#usda 1.0\ndef "w" (references = @{}@</x>)\n{{\n}}\n'
    assert len(read(reference.format("part.usda")).faces) == 4
    sublayers = "#usda 1.0\n(\n    subLayers = [@part.usda@]\n)\n"
    assert len(read(sublayers).faces) == 4
    for name in ("../part.usda", str(read.folder.parent / "part.usda"), "/etc/passwd", "http://127.0.0.1:1/a.usda"):
        with pytest.raises(InputError, match=OUTSIDE):
            read(reference.format(name))
    with pytest.raises(
        InputError, match=r"needs the file 'gone\.usda' beside it, which is missing; put it there, or fl"
    ):
        read(reference.format("gone.usda"))


def test_what_is_wrong_is_said(read):
    damaged = r"the USD file is truncated or damaged; export it again$"
    for text in (HEAD + "garbage {}", HEAD + MESH[:-5], HEAD + MESH.replace("[3, 3, 3, 3]", "[3, 3, 3, 9]")):
        with pytest.raises(InputError, match=damaged):
            read(text)
    with pytest.raises(InputError, match=r"refers to vertex 3, which is missing \(vertices: 3\); export it again$"):
        read(HEAD + MESH.replace(", (0, 0, 3)", ""))
    with pytest.raises(InputError, match=r"holds no faces; export it again as a surface$"):
        read(HEAD + 'def Sphere "s" {}\n')
    with pytest.raises(LimitError, match=r"4 faces, more than the limit of 3; decimate it, or raise `max_faces`$"):
        read(HEAD + MESH, max_faces=3)
    Usd.Stage.Open(str(Path(read.folder / "a.usda")))
    for size in (9, 40, 200, 400):
        (read.folder / "b.usdc").write_bytes(b"PXR-USDC" + bytes(size))
        with pytest.raises(InputError, match=damaged):
            read(None, "b.usdc")


def test_without_the_package_the_way_to_it_is_named(read, monkeypatch):
    monkeypatch.setitem(sys.modules, "pxr", None)
    pattern = r'reading USD needs usd-core; pip install "nmaptool-relief\[usd\]", or export it as GLB, STL, OBJ or PLY$'
    with pytest.raises(InputError, match=pattern):
        read(HEAD + MESH)
