"""A mesh with less and more of its detail."""

import json

import numpy as np
import pytest
from mesh_cases import angles, sheet, sphere

import nmaptool as nm
from nmaptool.filters.rolling import Decomposition
from nmaptool.reconstruction.smooth import target_normals


def knobbly(steps=40, size=0.03):
    """A sphere with bumps a few edges wide."""
    ball = nm.clean_mesh(sphere(steps))[0]
    x, y, z = ball.vertices.T
    radius = 1 + size * np.sin(24 * x) * np.sin(22 * y) * np.cos(20 * z)
    return nm.Mesh(ball.vertices * radius[:, None], ball.faces)


def roughness(mesh):
    return np.linalg.norm(mesh.vertices, axis=1).std()


def test_the_gain_sets_how_much_detail_there_is():
    mesh = knobbly()
    base = roughness(mesh)
    found = {g: roughness(nm.smooth(mesh, nm.SmoothOptions(g)).mesh) / base for g in (-1, 0, 0.5, 1, 2)}
    assert found[0] < 0.3
    assert 0.45 < found[0.5] < 0.75
    assert found[1] == pytest.approx(1, abs=1e-6)
    assert 1.35 < found[2] < 2.2
    assert found[-1] > 0.4


def test_a_negative_gain_inverts_the_detail():
    mesh = knobbly()
    bump = np.linalg.norm(mesh.vertices, axis=1) - 1
    dented = np.linalg.norm(nm.smooth(mesh, nm.SmoothOptions(-1.0)).mesh.vertices, axis=1)
    assert np.corrcoef(bump, dented)[0, 1] < -0.8


def test_gain_one_keeps_the_mesh():
    mesh = nm.clean_mesh(sheet(lambda x, y: np.sin(3 * x) * np.cos(2 * y), 20, 20, 0.2))[0]
    found = nm.smooth(mesh, nm.SmoothOptions(1.0))
    assert np.abs(found.mesh.vertices - mesh.vertices).max() < 1e-9
    assert np.array_equal(found.mesh.faces, mesh.faces)


def test_targets_are_unit_vectors_even_where_base_and_detail_cancel():
    normals = np.array([[0.0, 0, 1], [0, 0, 1]])
    base = np.array([[0.0, 0, -1], [0, 0.6, 0.8]])
    split = Decomposition(normals, base, base, normals - base, np.ones(2, bool), None)
    half = target_normals(split, 0.5)
    np.testing.assert_allclose(half[0], base[0])
    np.testing.assert_allclose(half[1], np.array([0, 0.3, 0.9]) / np.hypot(0.3, 0.9))
    np.testing.assert_allclose(target_normals(split, 1.0), normals)


def test_dropped_faces_are_reported_and_faces_keep_their_order():
    mesh = knobbly(12)
    odd = np.insert(mesh.faces, 7, [3, 3, 5], axis=0).astype(np.int32)
    found = nm.smooth(nm.Mesh(mesh.vertices, odd, name="odd"))
    assert np.array_equal(found.source_faces, np.delete(np.arange(len(odd)), 7))
    assert np.array_equal(found.mesh.faces, mesh.faces)
    assert found.report.warnings[0] == "dropped 1 face (without area, with NaN, or duplicate)"
    assert found.report.findings.degenerate_faces == 1


def test_long_edges_give_a_warning():
    assert "the edges are long: `sigma_s` is " in nm.smooth(knobbly(6)).report.warnings[0]


def test_folded_faces_and_volume_changes_give_warnings():
    rng = np.random.default_rng(0)
    mesh = knobbly(20)
    rough = nm.Mesh(mesh.vertices + rng.normal(size=mesh.vertices.shape) * 0.6 * mesh.mean_edge, mesh.faces)
    found = nm.smooth(rough, nm.SmoothOptions(6.0), reconstruct_options=nm.ReconstructOptions(closeness=1e-6))
    words = " ".join(found.report.warnings)
    assert "; use a smaller `sigma_s`, a `detail_gain` closer to 1" in words
    assert "the volume changed by" in words


def test_the_report_is_plain_json():
    report = nm.smooth(knobbly(12), filter=nm.FilterOptions(sigma_s=nm.length("5%"))).report
    values = json.loads(json.dumps(report.to_dict()))
    assert values["filter"]["sigma_s"] == "5%"
    assert values["detail_gain"] == 0
    assert values["reconstruction"]["options"]["scheme"] == "gsfg-gradient"
    assert len(values["reconstruction"]["moves"]) == 20
    assert set(values["seconds"]) == {"clean", "filter", "rebuild"}


def test_smoothed_faces_have_the_base_normals():
    mesh = knobbly()
    split = nm.decompose_normals(mesh)
    before = angles(split.normals, split.base).mean()
    found = nm.smooth(mesh)
    after = angles(found.mesh.geometry.normals, split.base).mean()
    assert after < 0.25 * before
    assert found.report.reconstruction.normal_deviation_deg == pytest.approx(after, rel=0.2)
