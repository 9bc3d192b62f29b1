"""Formats that are not read are named, by their first bytes or their ending, with what to do instead."""

import io
import zipfile

import mesh_files as files
import pytest

from nmaptool.core.errors import InputError
from nmaptool.io.meshes.other_formats import _FORMATS, _MAGIC
from nmaptool.io.meshes.reader import read_mesh

HEADS = {
    "fbx": (b"Kaydara FBX Binary  \0\x1a\0" + bytes(99), "an FBX scene; open it in Blender and export it as GLB, STL,"),
    "fbx text": (b"; FBX 7.4.0 project file\n", "an FBX scene; open it in Blender"),
    "blend": (b"BLENDER-v300" + bytes(99), "a Blender file; open it in Blender"),
    "3ds": (b"MM\x10\0\0\0\x02\0\x0a\0\0\0\x03\0\0\0" + bytes(99), "a 3DS scene; open it in Blender"),
    "abc": (b"Ogawa\xff\0\x01" + bytes(99), "an Alembic scene; open it in Blender"),
    "x3d": (b'<?xml version="1.0"?>\n<!DOCTYPE X3D PUBLIC "a">\n<X3D>', "an X3D scene; open it in MeshLab or Blender"),
    "wrl": (b"#VRML V2.0 utf8\n", "a VRML scene; open it in MeshLab or Blender"),
    "step": (b"ISO-10303-21;\nHEADER;\n", "a STEP model; save it as STL or 3MF from a CAD program, such as FreeCAD"),
    "iges": (b" " * 72 + b"S      1\n", "an IGES model; save it as STL or 3MF from a CAD program"),
    "dxf": (b"  0\r\nSECTION\r\n", "a DXF drawing; save it as STL or 3MF from a CAD program"),
    "dwg": (b"AC1032" + bytes(99), "a DWG drawing; "),
    "skp": (b"\xff\xfe\xff\x0e" + "SketchUp Model".encode("utf-16-le"), "a SketchUp model; export it as GLB, STL, OBJ"),
    "3dm": (b"3D Geometry File Format        6", "a Rhino model; export it as GLB, STL, OBJ or PLY from Rhino"),
    "max": (
        b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(99),
        "a document of 3ds Max, SolidWorks or Inventor; export it",
    ),
    "mb": (b"FOR4\0\0\0\x08Maya" + bytes(99), "a Maya scene; export it as GLB, STL, OBJ or PLY from Maya"),
    "ma": (b"//Maya ASCII 2022 scene\n", "a Maya scene; "),
    "lwo": (b"FORM\0\0\0\x09LWO2" + bytes(99), "a LightWave object; open it in Blender"),
    "amf": (
        b'<?xml version="1.0"?>\n<amf unit="millimeter">',
        "an AMF model; open it in a slicer and save it as STL or",
    ),
    "drc": (b"DRACO\x02\x02" + bytes(99), "a bare Draco mesh; export it as GLB, STL, OBJ or PLY"),
    "vtk": (b"# vtk DataFile Version 3.0\n", "VTK data; open it in ParaView and save the surface as PLY or STL"),
    "pcd": (b"# .PCD v0.7 - Point Cloud Data\n", "a cloud of points; make a mesh of the points, such as in MeshLab or"),
    "las": (b"LASF" + bytes(99), "a cloud of points; "),
    "e57": (b"ASTM-E57" + bytes(99), "a cloud of points; "),
    "png": (
        b"\x89PNG\r\n\x1a\n" + bytes(99),
        "a picture; give a mesh; a normal map goes to nmap relief, a depth picture",
    ),
    "jpg": (b"\xff\xd8\xff\xe0" + bytes(99), "a picture; give a mesh"),
    "gz": (b"\x1f\x8b\x08" + bytes(99), "a compressed file; unpack it and use the mesh in it"),
}


def refused(path, data, pattern):
    path.write_bytes(data)
    with pytest.raises(InputError, match=pattern) as caught:
        read_mesh(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("kind", HEADS)
def test_formats_are_known_by_their_first_bytes(tmp_path, kind):
    data, said = HEADS[kind]
    for name in (f"a.{kind.partition(' ')[0]}", "a.obj", "a.bin", "a"):
        refused(tmp_path / name, data, rf": is {said}")


@pytest.mark.parametrize("kind", _FORMATS)
def test_formats_are_known_by_their_ending_if_the_bytes_do_not_say(tmp_path, kind):
    name, remedy, endings = _FORMATS[kind]
    for ending in endings:
        refused(tmp_path / f"a.{ending.upper()}", b"\x07\x07\x07 unknown", rf": is {name}; {remedy}$")


def test_every_pattern_has_its_text():
    assert set(_MAGIC) <= set(_FORMATS)


def test_meshes_that_are_read_are_not_taken_for_others():
    for data in (
        *files.good().values(),
        files.ascii_stl(),
        files.ply(kind="ascii"),
        files.stl(header=b"Exported from"),
    ):
        assert not [kind for kind, magic in _MAGIC.items() if magic.match(data)]


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (["head.obj"], "is a ZIP archive; unpack it and use 'head.obj'"),
        (["a/Head.STL", "readme.txt"], "is a ZIP archive; unpack it and use 'a/Head.STL'"),
        (["a.obj", "b.obj"], "is a ZIP archive; unpack it and use the mesh in it"),
        (["readme.txt"], "is a ZIP archive; unpack it and use the mesh in it"),
        (["Document.xml", "GuiDocument.xml"], "is a FreeCAD document; save it as STL or 3MF from FreeCAD"),
        (["3D/3dmodel.model"], r"holds 3MF data; rename it to a\.3mf"),
        (["scene.usdc", "0/texture.png"], r"holds USD data; rename it to a\.usdz"),
    ],
)
def test_archives_are_named_by_their_content(tmp_path, names, said):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name in names:
            archive.writestr(name, "x")
    for ending in ("zip", "stl", "obj"):
        refused(tmp_path / f"a.{ending}", stream.getvalue(), rf": {said}$")
