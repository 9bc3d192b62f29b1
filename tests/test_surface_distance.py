"""Distances from points to surfaces, compared with trimesh and with all pairs."""

import numpy as np
import pytest
import trimesh
from mesh_cases import sheet, sphere

import nmaptool as nm
from nmaptool.meshes.distances import hausdorff, to_triangles


def test_distances_from_points_to_triangles_are_exact():
    rng = np.random.default_rng(0)
    points, corners = rng.normal(size=(4000, 3)), rng.normal(size=(4000, 3, 3))
    corners[:50, 2] = corners[:50, 0]  # without area
    corners[50:100] = corners[50:100, :1]  # one point
    foot = trimesh.triangles.closest_point(corners[100:], points[100:])
    np.testing.assert_allclose(
        to_triangles(points, corners)[100:], np.linalg.norm(points[100:] - foot, axis=1), atol=1e-12
    )
    np.testing.assert_allclose(
        to_triangles(points[50:100], corners[50:100]), np.linalg.norm(points[50:100] - corners[50:100, 0], axis=1)
    )


def test_the_hausdorff_distance_matches_all_pairs():
    mesh = nm.clean_mesh(sheet(lambda x, y: np.sin(x) * np.cos(y), 9, 11, 0.5))[0]
    # one face is many times larger than the others
    mesh = nm.Mesh(np.vstack([mesh.vertices, [[40.0, 0, 0]]]), np.vstack([mesh.faces, [[0, 9, 120]]]).astype(np.int32))
    points = np.random.default_rng(2).normal(size=(700, 3)) * [3, 3, 1.5] + [2, 0, 0]
    pairs = [to_triangles(points, np.broadcast_to(face, (len(points), 3, 3))) for face in mesh.corners]
    nearest = np.min(pairs, axis=0)
    distance, place = hausdorff(points, mesh)
    assert distance == pytest.approx(nearest.max(), rel=1e-12)
    assert place == nearest.argmax()


def test_the_distance_of_two_spheres_is_exact():
    ball = nm.clean_mesh(sphere(20))[0]
    outer = nm.Mesh(1.2 * ball.vertices, ball.faces)
    assert hausdorff(outer.vertices, ball)[0] == pytest.approx(0.2, rel=1e-6)
    # from inside, the nearest point of the outer sphere is in the middle of a face
    assert 0.19 < hausdorff(ball.vertices, outer)[0] < 0.2
    assert hausdorff(ball.vertices, ball)[0] < 1e-15
