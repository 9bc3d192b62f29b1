"""The axis that points up is doubted if a mesh would lie down or show its edge, and only then."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from mesh_cases import sheet, sphere

import nmaptool as nm
from nmaptool.meshes.lying import lying

FLAT = "the mesh stands on a flat bottom that faces -z; if it lies down in the maps, use `up='z'`"
TALL = "the mesh is tallest along z; if it lies down in the maps, use `up='z'`"
GROUND = "the mesh is tallest along z and stands on z = 0; if it lies down in the maps, use `up='z'`"
EDGE = "the mesh is thin along {}, so this view shows its edge; use {}"
BOTH = "`up='z'` or `view='top'`"


def z_up(mesh, **changes):
    """The mesh turned from y up to z up."""
    x, y, z = mesh.vertices.T
    return replace(mesh, vertices=np.stack([x, -z, y], axis=1), **changes)


def cone(radius=1.0, height=3.0):
    """A cone with y up, on the ground."""
    made = trimesh.creation.cone(radius, height, sections=40)
    x, y, z = made.vertices.T
    return nm.clean_mesh(nm.Mesh.from_arrays(np.stack([x, z, -y], 1), made.faces, name="a.obj"))[0]


def egg(*stretch):
    """An ellipsoid without any flat side."""
    ball = sphere(12)
    return nm.clean_mesh(replace(ball, vertices=ball.vertices * stretch))[0]


def said(mesh, up="y", views=("front",)):
    found = lying(mesh, up, views)
    assert len(found) <= 1
    return "".join(found)


def test_a_mesh_on_its_bottom_is_doubted_only_if_it_lies():
    assert said(cone()) == ""
    assert said(z_up(cone())) == FLAT
    assert said(z_up(cone(height=1.9))) == FLAT
    assert said(z_up(cone()), up="z") == ""


@pytest.mark.parametrize("name", ["a.stl", "b/A.PLY", "a.3mf"])
def test_formats_of_scanners_and_printers_are_usually_z_up(name):
    tall = egg(1, 3, 1)
    assert said(replace(tall, name=name)) == ""
    assert said(z_up(tall, name=name)) == TALL
    assert said(z_up(egg(1, 1.1, 1), name=name)) == ""  # hardly longer
    assert said(z_up(tall, name="a.obj")) == ""  # an animal that looks at us


def test_standing_on_the_ground_counts_in_every_format():
    tall = egg(1, 3, 1)
    standing = replace(tall, vertices=tall.vertices - tall.vertices.min(axis=0) * [0, 1, 0])
    assert said(standing) == ""
    assert said(z_up(standing, name="a.obj")) == GROUND
    along = replace(egg(1, 1, 3), name="a.stl")
    assert said(replace(along, vertices=along.vertices + np.array([0, 1, 0]))) == ""  # long, but it stands on y = 0


def test_plates_are_doubted_if_the_view_shows_their_edge():
    plate = nm.clean_mesh(sheet(lambda x, y: np.cos(x / 5), 20, 30))[0]
    assert said(plate) == ""  # faces +z: the usual front
    assert said(plate, up="z") == EDGE.format("z", "`up='y'` or `view='top'`")
    assert said(plate, up="z", views=("top",)) == ""
    assert said(z_up(plate)) == EDGE.format("y", BOTH)
    for views in (("back",), ("front", "back")):
        assert said(z_up(plate), views=views) == EDGE.format("y", BOTH)
    assert said(z_up(plate), views=("top",)) == ""


def test_the_flat_side_of_a_plate_is_its_back():
    box = trimesh.creation.box((10, 1, 8))
    up = box.vertices[:, 1] > 0
    for turn, remedy in ((up, "`view='top'`"), (~up, "`up='z'`")):
        points = box.vertices.copy()
        points[turn] *= [0.6, 1.5, 0.6]  # narrower in front
        assert said(nm.Mesh.from_arrays(points, box.faces)) == EDGE.format("y", remedy)
    assert said(nm.Mesh.from_arrays(box.vertices, box.faces)) == EDGE.format("y", BOTH)  # both sides are flat
    assert said(nm.Mesh.from_arrays(box.vertices[:, [0, 2, 1]], box.faces[:, ::-1])) == ""


def test_files_that_state_their_axis_are_never_doubted():
    assert said(z_up(cone(), up_from="file")) == ""
    assert said(z_up(egg(1, 3, 1), name="a.stl", up_from="file")) == ""


def test_other_directions_are_not_doubted():
    assert said(z_up(cone()), views=("top",)) == ""
    options = nm.BakeOptions(elevation=90, size="32x32", renderer="numpy")
    assert FLAT not in nm.bake(z_up(cone(3, 9)), options).report.warnings
    options = nm.BakeOptions(size="32x32", renderer="numpy")
    assert FLAT in nm.bake(z_up(cone(3, 9)), options).report.warnings
