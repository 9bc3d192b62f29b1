"""Views, framing and projection."""

import dataclasses

import numpy as np
import pytest
from mesh_cases import sheet, sphere

import nmaptool as nm
from nmaptool.options.bake import VIEWS
from nmaptool.render.camera import frame_camera, view_rotation

BOX = nm.Mesh(
    np.array([[x, y, z] for x in (0.0, 2) for y in (0.0, 3) for z in (0.0, 5)]),
    np.array([[0, 1, 2], [4, 6, 7], [1, 5, 7]], np.int32),
)


def camera(mesh=BOX, view="front", **options):
    made = nm.BakeOptions(**{"size": "100x80", "margin": nm.length("5px"), **options})
    return frame_camera(mesh, made, *VIEWS[view])


@pytest.mark.parametrize(
    ("view", "right", "up", "toward"),
    [
        ("front", (1, 0, 0), (0, 1, 0), (0, 0, 1)),
        ("back", (-1, 0, 0), (0, 1, 0), (0, 0, -1)),
        ("right", (0, 0, -1), (0, 1, 0), (1, 0, 0)),
        ("left", (0, 0, 1), (0, 1, 0), (-1, 0, 0)),
        ("top", (1, 0, 0), (0, 0, -1), (0, 1, 0)),
        ("bottom", (1, 0, 0), (0, 0, 1), (0, -1, 0)),
    ],
)
def test_views_are_exact(view, right, up, toward):
    """Rows of the rotation: the mesh axes that point right, up and to the viewer."""
    assert np.array_equal(view_rotation(*VIEWS[view], 0, "y"), np.array([right, up, toward], float))


def test_with_z_up_the_front_is_seen_from_minus_y():
    assert np.array_equal(view_rotation(0, 0, 0, "z"), [[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    assert np.array_equal(view_rotation(*VIEWS["top"], 0, "z"), np.eye(3))


def test_iso_shows_the_three_axes_alike():
    turned = view_rotation(*VIEWS["iso"], 0, "y")
    assert np.allclose(turned @ [1, 1, 1], [0, 0, np.sqrt(3)])
    assert np.allclose(turned @ turned.T, np.eye(3))
    assert np.isclose(np.linalg.det(turned), 1)


def test_roll_turns_the_image_counter_clockwise():
    assert np.allclose(view_rotation(0, 0, 90, "y") @ [1, 0, 0], [0, 1, 0])


def test_azimuth_moves_the_camera_right_and_elevation_moves_it_up():
    assert np.allclose(view_rotation(30, 0, 0, "y") @ [np.sin(np.pi / 6), 0, np.cos(np.pi / 6)], [0, 0, 1])
    assert np.allclose(view_rotation(0, 30, 0, "y") @ [0, np.sin(np.pi / 6), np.cos(np.pi / 6)], [0, 0, 1])


@pytest.mark.parametrize("fov", [0.0, 35.0, 120.0])
@pytest.mark.parametrize("view", ["front", "left", "top", "iso"])
def test_the_mesh_fills_the_image_up_to_the_margin(fov, view):
    at = camera(view=view, fov=fov).project(BOX.vertices)
    low, high = at.min(axis=0), at.max(axis=0)
    assert (low[:2] > 5 - 1e-9).all()
    assert (high[:2] < np.array([95, 75]) + 1e-9).all()
    touches = np.isclose(low[:2], 5, atol=1e-7) & np.isclose(high[:2], [95, 75], atol=1e-7)
    assert touches.any()


def test_points_are_projected_to_the_expected_pixels():
    seen = camera()  # 2 x 3 units on the 70 px that the margin leaves
    assert seen.unit_per_px == pytest.approx(3 / 70)
    at = seen.project(np.array([[1, 1.5, 0], [0, 3, 1]], float))
    assert np.allclose(at[0, :2], [50, 40])
    assert np.allclose(at[1, :2], [50 - 70 / 3, 5])
    assert at[1, 2] > at[0, 2]


def test_pitch_and_target_set_what_is_visible():
    mesh = dataclasses.replace(BOX, mm_per_unit=10.0)
    seen = camera(mesh, pitch=nm.length("0.5mm"), target="2,3,5")
    assert seen.unit_per_px == pytest.approx(0.05)
    assert np.allclose(seen.project(np.array([[2, 3, 5], [0, 3, 5]], float))[:, :2], [[50, 40], [10, 40]])


@pytest.mark.parametrize("fov", [20.0, 90.0])
def test_nearness_is_linear_on_every_plane(fov):
    """Halfway between two image points, nearness is the mean of theirs, as a rasteriser assumes."""
    seen = camera(sheet(lambda x, y: 0.7 * x - 0.4 * y, 4, 4), fov=fov)
    a, b = np.array([-2.0, -1, -1.0]), np.array([1.5, 2, 0.25])
    share = np.linspace(0, 1, 101)[:, None]
    at = seen.project(a + (b - a) * share)
    along = (at[:, 0] - at[0, 0]) / (at[-1, 0] - at[0, 0])
    assert np.allclose(at[:, 2], at[0, 2] + along * (at[-1, 2] - at[0, 2]), rtol=1e-12)


def test_rays_point_from_the_surface_to_the_eye():
    seen = camera(fov=60.0)
    point = np.array([[1.7, 0.3, 4.0]])
    col, row, _ = seen.project(point)[0]
    eye = np.array([0, 0, seen.distance])
    toward = eye - seen.to_eye(point)[0]
    assert np.allclose(seen.rays(np.array([col]), np.array([row]))[0], toward / toward[2])
    assert np.array_equal(camera().rays(np.array([3.0]), np.array([70.0])), [[0, 0, 1]])


def test_a_mesh_that_cannot_be_framed_is_refused():
    with pytest.raises(nm.UsageError, match="`margin='40px'`: leaves no room in 100 x 80 px; use a smaller one"):
        camera(margin=nm.length("40px"))
    edge_on = nm.Mesh(np.array([[0, 0, 0], [0, 0, 1.0], [0, 0, 3]]), np.array([[0, 1, 2]], np.int32))
    with pytest.raises(nm.InputError, match="is seen exactly edge-on; choose another `view`"):
        camera(edge_on)
    with pytest.raises(nm.UsageError, match="the camera is inside the mesh; use a larger `pitch`"):
        camera(sphere(4), fov=90.0, pitch=nm.length("0.001mm")).project(sphere(4).vertices)
