"""Name the mesh formats that are not read, and what to do instead; and the meshes inside ZIP archives."""

from __future__ import annotations

import re
import zipfile
import zlib
from pathlib import Path

_SURFACE = "export it as GLB, STL, OBJ or PLY"
_FROM_CAD = "save it as STL or 3MF from a CAD program, such as FreeCAD"
_FROM_BLENDER = "open it in Blender and export it as GLB, STL, OBJ or PLY"
_FROM_MESHLAB = "open it in MeshLab or Blender and export it as GLB, STL, OBJ or PLY"
_FROM_POINTS = "make a mesh of the points, such as in MeshLab or CloudCompare, and save it as PLY"
_UNPACK = "unpack it and use the mesh in it"
_PICTURE = "give a mesh; a normal map goes to nmap relief, a depth picture to nmap compose depth"

# name and remedy; endings that say so if the bytes do not
_FORMATS: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "fbx": ("an FBX scene", _FROM_BLENDER, ("fbx",)),
    "blend": ("a Blender file", _FROM_BLENDER, ("blend", "blend1")),
    "3ds": ("a 3DS scene", _FROM_BLENDER, ("3ds",)),
    "abc": ("an Alembic scene", _FROM_BLENDER, ("abc",)),
    "x3d": ("an X3D scene", _FROM_MESHLAB, ("x3d", "x3db", "x3dv")),
    "vrml": ("a VRML scene", _FROM_MESHLAB, ("wrl", "vrml", "wrz")),
    "lwo": ("a LightWave object", _FROM_BLENDER, ("lwo", "lws")),
    "x": ("a DirectX scene", _FROM_BLENDER, ("x",)),
    "maya": ("a Maya scene", _SURFACE + " from Maya", ("ma", "mb")),
    "c4d": ("a Cinema 4D scene", _SURFACE + " from Cinema 4D", ("c4d",)),
    "max": ("a 3ds Max scene", _SURFACE + " from 3ds Max", ("max",)),
    "ole": ("a document of 3ds Max, SolidWorks or Inventor", _SURFACE + " from that program", ()),
    "ztl": ("a ZBrush tool", _SURFACE + " from ZBrush", ("ztl", "zpr", "zbr")),
    "skp": ("a SketchUp model", _SURFACE + " from SketchUp", ("skp",)),
    "3dm": ("a Rhino model", _SURFACE + " from Rhino", ("3dm",)),
    "step": ("a STEP model", _FROM_CAD, ("step", "stp", "stpz", "p21")),
    "iges": ("an IGES model", _FROM_CAD, ("iges", "igs")),
    "brep": ("a BREP model", _FROM_CAD, ("brep", "brp")),
    "parasolid": ("a Parasolid model", _FROM_CAD, ("x_t", "x_b", "xmt_txt")),
    "sat": ("an ACIS model", _FROM_CAD, ("sat", "sab")),
    "jt": ("a JT model", _FROM_CAD, ("jt",)),
    "solidworks": ("a SolidWorks document", "save it as STL or 3MF from SolidWorks", ("sldprt", "sldasm")),
    "inventor": ("an Inventor document", "save it as STL or 3MF from Inventor", ("ipt", "iam")),
    "fusion": ("a Fusion design", "save it as STL or 3MF from Fusion", ("f3d", "f3z")),
    "freecad": ("a FreeCAD document", "save it as STL or 3MF from FreeCAD", ("fcstd",)),
    "scad": ("an OpenSCAD program", "render it in OpenSCAD and save it as STL or 3MF", ("scad",)),
    "dxf": ("a DXF drawing", _FROM_CAD, ("dxf",)),
    "dwg": ("a DWG drawing", _FROM_CAD, ("dwg",)),
    "amf": ("an AMF model", "open it in a slicer and save it as STL or 3MF", ("amf",)),
    "gcode": ("G-code for a machine", "use the model that it was made from", ("gcode", "nc", "bgcode")),
    "drc": ("a bare Draco mesh", _SURFACE, ("drc",)),
    "ctm": ("an OpenCTM mesh", "open it in MeshLab and save it as PLY", ("ctm",)),
    "vtk": ("VTK data", "open it in ParaView and save the surface as PLY or STL", ("vtk", "vtp", "vtu")),
    "gmsh": ("a Gmsh mesh", "save it as STL or PLY from Gmsh", ("msh",)),
    "pcd": ("a cloud of points", _FROM_POINTS, ("pcd", "xyz", "pts", "asc", "ptx")),
    "las": ("a cloud of points", _FROM_POINTS, ("las", "laz")),
    "e57": ("a cloud of points", _FROM_POINTS, ("e57",)),
    "picture": ("a picture", _PICTURE, ("png", "jpg", "jpeg", "exr", "tif", "tiff", "bmp", "tga", "webp")),
    "compressed": ("a compressed file", _UNPACK, ("7z", "rar", "gz", "bz2", "xz", "zst", "tar")),
}  # fmt: skip
_MAGIC = {
    "fbx": re.compile(rb"Kaydara FBX Binary|; FBX \d"),
    "blend": re.compile(rb"BLENDER"),
    "3ds": re.compile(rb"MM....\x02\x00\x0a\x00|MM....\x3d\x3d", re.DOTALL),
    "abc": re.compile(rb"Ogawa"),
    "x3d": re.compile(rb"(?:<\?xml[^>]*>|<![^>]*>|\s)*<X3D\b|#X3D\b", re.IGNORECASE),
    "vrml": re.compile(rb"#VRML\b"),
    "lwo": re.compile(rb"FORM....LWO", re.DOTALL),
    "x": re.compile(rb"xof \d"),
    "maya": re.compile(rb"//Maya|FOR[48].{4,12}Maya", re.DOTALL),
    "c4d": re.compile(rb"QC4DC4D6|.{0,8}C4DC4D", re.DOTALL),
    "ole": re.compile(rb"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"),
    "skp": re.compile(rb"\xff\xfe\xff\x0eS\0k\0e\0t\0c\0h\0U\0p|\xe0\xbb\xbfSketchUp"),
    "3dm": re.compile(rb"3D Geometry File Format"),
    "step": re.compile(rb"\s*ISO-10303-21"),
    "iges": re.compile(rb"[^\r\n]{72}S {0,6}0*1[ \r\n]"),
    "brep": re.compile(rb"\s*DBRep_DrawableShape|CASCADE Topology"),
    "parasolid": re.compile(rb"\*\*ABCDEFGHIJKLMNOPQRSTUVWXYZ"),
    "jt": re.compile(rb"Version \d+\.\d+ JT"),
    "dxf": re.compile(rb"\s*0\s*[\r\n]+\s*SECTION\b"),
    "dwg": re.compile(rb"AC10\d\d"),
    "amf": re.compile(rb"(?:<\?xml[^>]*>|\s)*<amf\b", re.IGNORECASE),
    "drc": re.compile(rb"DRACO"),
    "ctm": re.compile(rb"OCTM"),
    "vtk": re.compile(rb"# vtk DataFile|(?:<\?xml[^>]*>|\s)*<VTKFile\b"),
    "gmsh": re.compile(rb"\$MeshFormat"),
    "pcd": re.compile(rb"# \.PCD|VERSION \.?\d[^\n]*\nFIELDS "),
    "las": re.compile(rb"LASF"),
    "e57": re.compile(rb"ASTM-E57"),
    "picture": re.compile(rb"\x89PNG|\xff\xd8\xff|\x76\x2f\x31\x01|II\*\0|MM\0\*|RIFF....WEBP", re.DOTALL),
    "compressed": re.compile(rb"\x1f\x8b|BZh|7z\xbc\xaf|Rar!|\x28\xb5\x2f\xfd|\xfd7zXZ"),
}
_ZIPPED_DOCUMENTS = {"Document.xml": "freecad", "Manifest.dat": "fusion"}
_MESHES = (".obj", ".ply", ".stl", ".off", ".glb", ".gltf", ".fbx", ".dae", ".3mf", ".usd", ".usda", ".usdc", ".usdz")
_SEVERAL = 200


def other_format(ending: str, head: bytes) -> str | None:
    """Name a file by its first bytes, otherwise by its extension, as ``is an FBX scene; REMEDY``; None if unknown."""
    found = next((kind for kind, magic in _MAGIC.items() if magic.match(head)), None)
    if found is None:
        found = next((kind for kind, (_, _, endings) in _FORMATS.items() if ending in endings), None)
    if found is None:
        return None
    name, remedy, _ = _FORMATS[found]
    return f"is {name}; {remedy}"


def zip_content(path: Path) -> tuple[str | None, str]:
    """The format of a ZIP archive that is read as it is, ``3mf`` or ``usd``, or None; and what else to say of it."""
    try:
        with zipfile.ZipFile(path) as archive:
            names = archive.namelist()
    except (zipfile.BadZipFile, zlib.error, OSError, ValueError, NotImplementedError, UnicodeError):
        return None, f"is a ZIP archive; {_UNPACK}"
    if any(name.lower().endswith(".model") for name in names):
        return "3mf", ""
    if names and names[0].lower().endswith((".usd", ".usda", ".usdc")):
        return "usd", ""
    for name, kind in _ZIPPED_DOCUMENTS.items():
        if name in names:
            return None, "is {}; {}".format(*_FORMATS[kind][:2])
    meshes = [name for name in names[:_SEVERAL] if name.lower().endswith(_MESHES)]
    wanted = repr(meshes[0]) if len(meshes) == 1 and len(meshes[0]) < _SEVERAL else "the mesh in it"
    return None, f"is a ZIP archive; unpack it and use {wanted}"
