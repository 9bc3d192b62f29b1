"""Previews of meshes: reliefs are read back from their lattice, other meshes are drawn by their triangles."""

import numpy as np
import pytest
import trimesh
from preview_cases import PITCH, cone, disc

import nmaptool as nm
from nmaptool.core.errors import InputError
from nmaptool.options.preview import Light
from nmaptool.shading.lamp_depth import seen_by_lamp
from nmaptool.shading.mesh_front import lattice_of, mesh_front


def closed(height, base="2mm", **words):
    return nm.solid(height, nm.SolidOptions(base=nm.length(base), **words)).to_mesh()


@pytest.mark.parametrize("words", [{}, {"max_error": nm.length("0.001mm")}])
def test_the_heights_of_a_relief_are_found_again_in_its_mesh(words):
    height = cone()
    front, thick = mesh_front(closed(height, **words))
    assert front.frame.shape == (80, 120)
    assert front.pitch_mm == pytest.approx(PITCH, rel=1e-6)
    assert front.domain.all()
    assert thick == pytest.approx(2, abs=1e-6)
    np.testing.assert_allclose(front.z_mm, height.z_mm + 2, atol=2e-3 if words else 1e-6)


def test_a_relief_in_single_precision_and_elsewhere_in_space_keeps_its_lattice():
    mesh = closed(cone())
    moved = np.add(mesh.vertices, [1234.5, -77.7, 9.0]).astype(np.float32).astype(np.float64)
    found = nm.Mesh.from_arrays(moved, mesh.faces)
    assert lattice_of(found.vertices_mm).spacing == pytest.approx(PITCH, rel=1e-5)
    assert mesh_front(found)[0].frame.shape == (80, 120)


def test_an_open_surface_and_a_cut_out_are_reliefs_too():
    front, thick = mesh_front(nm.surface_mesh(disc()))
    rows, cols = front.frame.shape
    assert (rows, cols) == (72, 72)
    assert front.domain.sum() == disc().domain.sum()
    assert thick > 0


@pytest.mark.parametrize("shape", [trimesh.creation.icosphere(subdivisions=3), trimesh.creation.box((3, 2, 1))])
def test_other_meshes_have_no_lattice_and_keep_their_size(shape):
    mesh = nm.Mesh.from_trimesh(shape)
    assert lattice_of(mesh.vertices_mm) is None
    front, thick = mesh_front(mesh, 200)
    size = np.ptp(shape.vertices, axis=0)
    assert front.frame.cols * front.pitch_mm == pytest.approx(size[0], rel=0.01)
    assert front.frame.rows * front.pitch_mm == pytest.approx(size[1], rel=0.01)
    assert front.range_mm[1] == pytest.approx(size[2], rel=0.01)
    assert thick <= size[2]


def test_a_sphere_has_the_heights_of_a_sphere():
    front, _ = mesh_front(nm.Mesh.from_trimesh(trimesh.creation.icosphere(subdivisions=5)), 200)
    y, x = np.mgrid[1 : -1 : (front.frame.rows + 1) * 1j, -1 : 1 : (front.frame.cols + 1) * 1j]
    inside = np.hypot(x, y) < 0.95
    np.testing.assert_allclose(
        front.z_mm[inside], 1 + np.sqrt(1 - x * x - y * y, out=np.zeros_like(x), where=inside)[inside], atol=0.02
    )


@pytest.mark.parametrize(
    "vertices", [[[0, 0, 0], [1, 0, 0], [2, 0, 1]], [[0, 0, 0], [0, 0, 1], [0, 1e-9, 2]]], ids=["upright", "line"]
)
def test_meshes_without_an_upper_side_are_refused(vertices):
    mesh = nm.Mesh.from_arrays(vertices, [[0, 1, 2]], name="edge.stl")
    with pytest.raises(InputError, match=r"edge\.stl: is so thin that no pixel of a preview from above lies inside it"):
        nm.preview(mesh)
    with pytest.raises(InputError, match=r"edge\.stl: is a line along z; a preview from above would be empty"):
        mesh_front(nm.Mesh.from_arrays([[0, 0, 0], [0, 0, 1], [0, 0, 2]], [[0, 1, 2]], name="edge.stl"))


def test_a_mesh_and_its_heights_give_the_same_picture():
    height = cone()
    for view in ("top", "iso"):
        options = nm.PreviewOptions(size=360, view=view, thickness="2mm")
        pictures = [nm.preview(each, options).astype(int) for each in (height, closed(height))]
        assert np.abs(pictures[0] - pictures[1]).mean() < 0.5, view


def test_a_figure_stands_upright_where_y_is_up():
    tall = nm.Mesh.from_trimesh(trimesh.creation.capsule(height=4, radius=1))  # along z
    lying = nm.Mesh.from_arrays(tall.vertices[:, [0, 2, 1]] * [1, 1, -1], tall.faces)
    upright = nm.preview(tall, nm.PreviewOptions(view="iso", size=160))
    np.testing.assert_array_equal(upright, nm.preview(lying, nm.PreviewOptions(view="iso", size=160, up="y")))
    assert upright.shape[0] > upright.shape[1]
    flat = nm.preview(lying, nm.PreviewOptions(view="iso", size=160))
    assert flat.shape[0] / flat.shape[1] < upright.shape[0] / upright.shape[1] - 0.2


def test_the_two_ways_to_draw_a_piece_agree_on_its_outline_and_light():
    """A box as heights with walls and as triangles: the same camera, nearly the same colours."""
    rows, cols = 40, 60
    plate = nm.Height(np.zeros((rows + 1, cols + 1)), np.ones((rows, cols), bool), nm.Frame(rows, cols, PITCH))
    box = nm.Mesh.from_trimesh(trimesh.creation.box((cols * PITCH, rows * PITCH, 3)))
    options = nm.PreviewOptions(view="iso", size=240, thickness="3mm", material="plaster", background="#203050")
    first, second = (nm.preview(each, options).astype(int) for each in (plate, box))
    assert np.abs(np.subtract(first.shape, second.shape)).max() <= 2
    low = [min(sizes) for sizes in zip(first.shape, second.shape, strict=True)]
    first, second = (each[: low[0], : low[1]] for each in (first, second))
    piece = [each[..., 0] > 100 for each in (first, second)]
    assert (piece[0] & piece[1]).sum() > 0.95 * (piece[0] | piece[1]).sum()
    top = low[0] // 2 - 20, low[1] // 2
    assert np.abs(first[top] - second[top]).max() < 12


def test_the_shadow_of_a_mesh_ends_where_the_elevation_says():
    box = trimesh.creation.box((2, 2, 1))
    points = np.add(box.vertices, [0, 0, 0.5])
    x = np.linspace(1.02, 6, 400, dtype=np.float32)
    table = np.stack([x, np.zeros_like(x), np.zeros_like(x)], axis=1)[None]
    up = np.zeros_like(table)
    up[..., 2] = 1
    for elevation in (20, 45, 70):
        lit = seen_by_lamp(points, np.asarray(box.faces, np.int32), Light(180, elevation), table, up)[0]
        ends = float(x[(lit > 0.5).argmax()])
        assert ends == pytest.approx(1 + 1 / np.tan(np.radians(elevation)), abs=0.03)
    top = np.array([[[0.3, 0.2, 1.0]]], np.float32)
    assert seen_by_lamp(points, np.asarray(box.faces, np.int32), Light(30, 30), top, up[:, :1])[0, 0] == 1


def test_a_mesh_that_is_inside_out_shows_the_same():
    mesh = closed(cone())
    turned = nm.Mesh.from_arrays(mesh.vertices, mesh.faces[:, ::-1])
    np.testing.assert_array_equal(mesh_front(turned)[0].z_mm, mesh_front(mesh)[0].z_mm)
