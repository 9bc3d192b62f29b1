"""Reading DAE (COLLADA) with pycollada: transforms, units, polygons; and faults."""

import io
import sys

import mesh_files as files
import numpy as np
import pytest
import trimesh
from mesh_files import FACES, VERTICES, volume
from trimesh.exchange.dae import export_collada

from nmaptool.core.errors import InputError, LimitError
from nmaptool.io.meshes.reader import read_mesh

INDICES = " ".join(map(str, FACES.ravel()))
TRIANGLES = f'<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>{INDICES}</p></triangles>'
NODE = '<node><instance_geometry url="#g"/></node>'
POINTS = " ".join(f"{number:g}" for number in VERTICES.ravel())


def dae(primitives=TRIANGLES, nodes=NODE, asset="", points=POINTS, more="", head=""):
    """A DAE with one geometry."""
    count = len(points.split())
    return (
        f'<?xml version="1.0" encoding="utf-8"?>{head}\n<!-- a comment -->\n'
        '<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">'
        f"<asset><created>2020-01-01T00:00:00</created><modified>2020-01-01T00:00:00</modified>{asset}</asset>"
        f'<library_geometries><geometry id="g"><mesh><source id="s"><float_array id="f" count="{count}">{points}'
        f'</float_array><technique_common><accessor source="#f" count="{count // 3}" stride="3"><param name="X" '
        'type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common>'
        f'</source><vertices id="v"><input semantic="POSITION" source="#s"/></vertices>{primitives}</mesh></geometry>'
        f'</library_geometries>{more}<library_visual_scenes><visual_scene id="w">{nodes}</visual_scene>'
        '</library_visual_scenes><scene><instance_visual_scene url="#w"/></scene></COLLADA>'
    ).encode()


@pytest.fixture
def read(tmp_path, capfd):
    """``read(data)``: the mesh in a DAE; reading prints nothing."""

    def call(data, **options):
        (tmp_path / "a.dae").write_bytes(data)
        mesh = read_mesh(tmp_path / "a.dae", **options)
        assert capfd.readouterr() == ("", "")
        return mesh

    return call


def test_files_of_trimesh_are_read(read):
    mesh = read(export_collada(trimesh.Trimesh(VERTICES, FACES, process=False)))
    assert mesh.vertices.tolist() == VERTICES.tolist()
    assert mesh.faces.tolist() == FACES.tolist()
    assert (mesh.unit_from, mesh.up_from) == ("file", "file")


@pytest.mark.parametrize(("up", "signs"), [("Y_UP", "xyz"), ("Z_UP", "xz-y"), ("X_UP", "-yxz")])
def test_units_and_the_axis_that_points_up_are_those_of_the_file(read, up, signs):
    mesh = read(dae(asset=f'<unit name="inch" meter="0.0254"/><up_axis>{up}</up_axis>'))
    assert mesh.mm_per_unit == pytest.approx(25.4)
    x, y, z = VERTICES.T
    expected = {"xyz": [x, y, z], "xz-y": [x, z, -y], "-yxz": [-y, x, z]}[signs]
    assert np.allclose(mesh.vertices, np.stack(expected, 1))
    assert volume(mesh) == pytest.approx(1)


def test_transforms_of_nodes_are_applied(read):
    inner = f"<node><scale>1 1 -2</scale>{NODE}</node>"
    mesh = read(dae(nodes=f"<node><translate>1 2 3</translate><rotate>0 0 1 90</rotate>{inner}{NODE}</node>"))
    x, y, z = VERTICES.T
    assert np.allclose(mesh.vertices[:4], np.stack([1 - y, 2 + x, 3 - 2 * z], 1))
    assert np.allclose(mesh.vertices[4:], np.stack([1 - y, 2 + x, 3 + z], 1))
    assert volume(mesh) == pytest.approx(2 + 1)


def test_polygons_and_unused_vertices_are_read(read):
    star = "0 0 0 4 1 0 0 2 0 1 1 0 9 9 9"  # concave at its last used corner
    source = '<input semantic="VERTEX" source="#v" offset="0"/><input semantic="NORMAL" source="#s" offset="1"/>'
    polylist = f'<polylist count="2">{source}<vcount>4 3</vcount><p>0 0 1 1 2 2 3 0 0 0 1 0 2 0</p></polylist>'
    mesh = read(dae(polylist, points=star))
    assert mesh.faces.shape == (3, 3)
    assert len(mesh.vertices) == 4
    polygons = f'<polygons count="1">{source}<p>0 0 1 1 2 2 3 0</p></polygons>'
    lines = f'<lines count="1">{source}<p>0 0 1 1</p></lines>'
    mesh = read(dae(polygons + lines, points=star))
    a, b, c = mesh.corners.transpose(1, 0, 2)
    area = np.cross(b - a, c - a)[:, 2] / 2
    assert (area > 0).all() or (area < 0).all()
    assert abs(area.sum()) == pytest.approx(3)
    assert mesh.notes == ("ignored lines",)


def test_what_is_wrong_is_said(read):
    with pytest.raises(
        InputError, match=r"refers to vertex \d, which is missing \(vertices: 3\)|damaged; export it again"
    ):
        read(dae(points="0 0 0 1 0 0 0 2 0"))
    with pytest.raises(InputError, match=r"holds no faces; export it again as a surface$"):
        read(dae(nodes="<node/>"))
    with pytest.raises(LimitError, match=r"8 faces, more than the limit of 7; decimate it, or raise `max_faces`$"):
        read(dae(nodes=NODE * 2), max_faces=7)
    for data in (dae()[:-20], dae(points="a b c"), dae(head="<!DOCTYPE x [<!ENTITY a 'b'>]>"), dae("<triangles/>")):
        with pytest.raises(InputError, match=r"the DAE file is truncated or damaged; export it again$"):
            read(data)


def test_without_the_package_the_way_to_it_is_named(read, monkeypatch):
    monkeypatch.setitem(sys.modules, "collada", None)
    pattern = (
        r'reading DAE needs pycollada; pip install "nmaptool-relief\[collada\]", or export it as GLB, STL, OBJ or PLY$'
    )
    with pytest.raises(InputError, match=pattern):
        read(dae())


def test_trimesh_reads_the_same(read):
    data = dae(nodes=f"<node><translate>1 2 3</translate><rotate>0 1 1 30</rotate>{NODE}</node>")
    theirs = trimesh.load(io.BytesIO(data), file_type="dae", force="mesh", process=False)
    ours = read(data)
    assert files.volume(ours) == pytest.approx(theirs.volume)
    assert np.allclose(np.sort(ours.vertices, axis=0)[[0, -1]], theirs.bounds, atol=1e-6)
