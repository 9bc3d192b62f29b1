"""Faces whose winding disagrees with that of their neighbours."""

import numpy as np
import pytest
from mesh_cases import joined, sphere

import nmaptool as nm
from nmaptool.meshes.clean import clean_mesh


def flipped(mesh, which):
    faces = mesh.faces.copy()
    faces[which] = faces[which][:, ::-1]
    return nm.Mesh(mesh.vertices, faces)


@pytest.mark.parametrize("share", [0.01, 0.3, 0.49])
def test_faces_wound_the_other_way_are_flipped(share):
    mesh = clean_mesh(sphere(12))[0]
    which = np.random.default_rng(4).random(len(mesh.faces)) < share
    clean, source, found = clean_mesh(flipped(mesh, which))
    assert np.array_equal(clean.faces[which][:, ::-1], flipped(mesh, which).faces[which])
    assert np.array_equal(clean.faces[~which], mesh.faces[~which])
    assert np.array_equal(source, np.arange(len(mesh.faces)))
    assert found.turned_faces == which.sum()
    outward = (clean.geometry.normals * clean.geometry.centroids).sum(axis=1)
    assert (outward > 0).all()


def test_each_piece_is_oriented_separately_and_an_inside_out_piece_is_kept():
    mesh = joined(sphere(6), flipped(sphere(5, 3.0), slice(None)))
    clean, _, found = clean_mesh(mesh)
    outward = (clean.geometry.normals * clean.geometry.centroids).sum(axis=1)
    count = len(sphere(6).faces)
    assert (outward[:count] > 0).all()
    assert (outward[count:] < 0).all()
    assert found.turned_faces == 0


def test_a_moebius_strip_is_not_changed():
    turn = np.linspace(0, 2 * np.pi, 41)[:-1]
    side = np.stack([np.cos(turn / 2) * np.cos(turn), np.cos(turn / 2) * np.sin(turn), np.sin(turn / 2)], -1) * 0.3
    middle = np.stack([np.cos(turn), np.sin(turn), 0 * turn], -1)
    vertices = np.concatenate([middle - side, middle + side])
    a = np.arange(40)
    b, low, high = (a + 1) % 40, a + 40, (a + 1) % 40 + 40
    b[-1], high[-1] = 40, 0  # a half turn
    faces = np.concatenate([np.stack([a, b, low], -1), np.stack([b, high, low], -1)]).astype(np.int32)
    clean, _, found = clean_mesh(nm.Mesh(vertices, faces))
    assert np.array_equal(clean.faces, faces)
    assert found.turned_faces == 0


def test_repeated_faces_are_kept_once():
    mesh = sphere(4)
    double = nm.Mesh(mesh.vertices, np.vstack([mesh.faces, mesh.faces[::-1, ::-1], mesh.faces[:7]]).astype(np.int32))
    clean, source, found = clean_mesh(double)
    assert found.repeated_faces == len(mesh.faces) + 7
    assert np.array_equal(source, np.arange(len(mesh.faces)))
    assert np.array_equal(clean.faces, clean_mesh(mesh)[0].faces)


def test_three_faces_at_an_edge_do_not_flip_each_other():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]], float)
    faces = np.array([[0, 1, 2], [0, 1, 3], [0, 1, 4]], np.int32)
    clean, _, found = clean_mesh(nm.Mesh(vertices, faces))
    assert np.array_equal(clean.faces, faces)
    assert found.turned_faces == 0
