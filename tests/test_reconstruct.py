"""Meshes rebuilt to given normals: the paper's equations by hand, fixed points, folds, boundaries, equivariance."""

import numpy as np
import pytest
from mesh_cases import angles, joined, sheet, sphere
from scipy.spatial.transform import Rotation

import nmaptool as nm
from nmaptool.reconstruction import shaping, stitching
from nmaptool.reconstruction.measures import volume, volume_between

SCHEMES = ("gsfg-gradient", "gsfg-shape", "gsfg", "poisson")
UP = (0.0, 0.0, 1.0)


def clean(mesh):
    return nm.clean_mesh(mesh)[0]


def noisy_sphere(share, steps=24, seed=3):
    """A sphere, the same with noise (as a share of the mean edge), and the size of that noise."""
    true = clean(sphere(steps))
    size = share * true.mean_edge
    noise = np.random.default_rng(seed).normal(size=true.vertices.shape) * size
    return true, nm.Mesh(true.vertices + noise, true.faces), size


def bumps(rows=12, cols=14):
    return clean(sheet(lambda x, y: np.sin(x) + 0.5 * np.cos(1.3 * y) + 0.1 * x * y, rows, cols, 0.4))


def tilted(mesh, degrees, seed=1):
    """The normals of the mesh, each tilted by at most ``degrees`` in a random direction."""
    normals = mesh.geometry.normals
    off = np.random.default_rng(seed).uniform(-1, 1, normals.shape) / np.sqrt(3) * np.sin(np.radians(degrees))
    out = normals + off
    return out / np.linalg.norm(out, axis=1, keepdims=True)


def options(scheme, **changes):
    return nm.ReconstructOptions(scheme=scheme, **changes)


def test_gsfg_follows_the_two_equations_of_the_paper():
    mesh = bumps()
    targets = tilted(mesh, 40)
    target_shapes = [[] for _ in mesh.vertices]
    for face, n in zip(mesh.faces, targets, strict=True):
        c = mesh.vertices[face].mean(axis=0)
        for vertex in face:
            v = mesh.vertices[vertex]
            target_shapes[vertex].append(v - ((v - c) @ n) * n)  # Eq. 2
    expected = np.array([np.mean(each, axis=0) for each in target_shapes])  # Eq. 3
    found = nm.reconstruct(mesh, targets, options("gsfg", steps=1, boundary="free"))
    assert found.report.folded_before == 0
    assert angles(mesh.geometry.normals, targets).max() < 60  # no target faces backwards
    np.testing.assert_allclose(found.vertices, expected, atol=1e-13)


def test_poisson_solves_its_normal_equations():
    mesh = bumps()
    targets = tilted(mesh, 40)
    count, closeness = len(mesh.vertices), 0.03
    left, right = closeness * np.eye(count), closeness * mesh.vertices
    for face, n, t, area in zip(mesh.faces, mesh.geometry.normals, targets, mesh.geometry.areas, strict=True):
        corners = mesh.vertices[face]
        gradients = np.array([np.cross(n, corners[(k + 2) % 3] - corners[(k + 1) % 3]) for k in range(3)]) / (2 * area)
        turn, _ = Rotation.align_vectors([t, np.cross(n, t)], [n, np.cross(n, t)])
        g = gradients.T @ corners @ turn.as_matrix().T  # rows: the gradient's axes; columns: x, y, z
        left[np.ix_(face, face)] += area * gradients @ gradients.T
        right[face] += area * gradients @ g
    expected = np.linalg.solve(left, right)
    found = nm.reconstruct(mesh, targets, options("poisson", steps=1, closeness=closeness, boundary="free"))
    np.testing.assert_allclose(found.vertices, expected, atol=1e-10)


@pytest.mark.parametrize("scheme", ["gsfg-gradient", "gsfg-shape"])
def test_both_schemes_reach_the_minimum_of_their_energies(scheme):
    mesh = bumps(6, 7)
    targets = tilted(mesh, 8)
    count, closeness = len(mesh.vertices), 0.05
    hessian = np.zeros((count, 3, count, 3))
    for face, n, own in zip(mesh.faces, targets, mesh.geometry.normals, strict=True):
        measure = np.eye(3) - 1 / 3
        if scheme == "gsfg-gradient":  # integrals of the products of the hat functions' gradients
            corners = mesh.vertices[face]
            across = np.array([np.cross(own, corners[(k + 2) % 3] - corners[(k + 1) % 3]) for k in range(3)])
            measure = (
                across @ across.T / (2 * np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0])))
            )
        for i, a in enumerate(face):
            for j, b in enumerate(face):
                hessian[a, :, b, :] += measure[i, j] * np.outer(n, n)
    matrix = hessian.reshape(3 * count, 3 * count) + closeness * np.eye(3 * count)
    expected = np.linalg.solve(matrix, closeness * mesh.vertices.ravel()).reshape(-1, 3)
    found = nm.reconstruct(mesh, targets, options(scheme, steps=3000, closeness=closeness, boundary="free"))
    np.testing.assert_allclose(found.vertices, expected, atol=1e-7)
    assert found.report.moves[-1] < 1e-9 < found.report.moves[0]


@pytest.mark.parametrize("boundary", ["hold", "free"])
@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_mesh_with_its_own_normals_is_unchanged(scheme, boundary):
    _, rough, _ = noisy_sphere(0.3)
    for mesh in (bumps(), rough):
        found = nm.reconstruct(mesh, mesh.geometry.normals, options(scheme, boundary=boundary))
        size = np.ptp(mesh.vertices, axis=0).max()
        assert np.abs(found.vertices - mesh.vertices).max() < 1e-9 * size
        assert found.report.normal_deviation_deg < 1e-6
        assert found.report.folded_after == 0


@pytest.mark.parametrize("share", [0.1, 0.3])
def test_a_noisy_sphere_with_true_normals_becomes_the_sphere(share):
    true, rough, size = noisy_sphere(share, 40)
    found = nm.reconstruct(rough, true.geometry.normals)
    off = np.linalg.norm(found.vertices, axis=1) - 1
    assert np.sqrt((off**2).mean()) < size / 10
    assert (found.report.folded_before > 0) == (share > 0.2)
    assert found.report.folded_after == 0
    assert abs(volume(found.vertices, true.faces) / volume(true.vertices, true.faces) - 1) < 0.005


def test_gsfg_alone_needs_more_steps_for_the_sphere():
    true, rough, size = noisy_sphere(0.1, 40)
    off = []
    for steps in (20, 60):
        found = nm.reconstruct(rough, true.geometry.normals, options("gsfg", steps=steps))
        off.append(np.sqrt(((np.linalg.norm(found.vertices, axis=1) - 1) ** 2).mean()))
    assert size / 10 < off[0] < size / 8
    assert off[1] < size / 12


@pytest.mark.parametrize("scheme", SCHEMES)
def test_results_follow_rotation_scale_and_translation(scheme):
    true, rough, _ = noisy_sphere(0.35, 12)
    targets = true.geometry.normals
    plain = nm.reconstruct(rough, targets, options(scheme)).vertices
    turn = Rotation.from_rotvec([0.7, -1.1, 0.4]).as_matrix()
    moved = nm.Mesh(37 * rough.vertices @ turn.T + [5, -60, 7], rough.faces)
    found = nm.reconstruct(moved, targets @ turn.T, options(scheme)).vertices
    np.testing.assert_allclose(found, 37 * plain @ turn.T + [5, -60, 7], atol=1e-7)


@pytest.mark.parametrize("scheme", SCHEMES[:3])
@pytest.mark.parametrize("drag", [(1.3, 0.4, 0.0), (2.3, 1.4, 0.0), (-3.2, 0.5, 0.7)])
def test_a_vertex_dragged_over_its_neighbours_leaves_no_fold(scheme, drag):
    flat = clean(sheet(lambda x, y: 0 * x, 10, 10))
    vertices = flat.vertices.copy()
    vertices[60] += drag
    mesh = nm.Mesh(vertices, flat.faces)
    targets = np.tile(UP, (len(flat.faces), 1))
    found = nm.reconstruct(mesh, targets, options(scheme))
    assert found.report.folded_before > 0
    assert found.report.folded_after == 0
    assert (found.mesh.geometry.normals[:, 2] > 0.99).all()


def test_a_half_turn_flattens_a_face_with_the_right_side_up():
    rng = np.random.default_rng(5)
    shapes = rng.normal(size=(3, 50, 3))
    shapes -= shapes.mean(axis=0)
    normals = shaping.normals_of(shapes)
    laid = shaping.flattened_opposed(shapes, normals, -normals)
    np.testing.assert_allclose(shaping.normals_of(laid), -normals, atol=1e-12)
    for k in range(3):
        np.testing.assert_allclose(*(np.linalg.norm(s[k] - s[k - 1], axis=1) for s in (laid, shapes)), atol=1e-12)
    # no rotation in the plane brings the corners closer
    for angle in (-0.1, 0.1):
        turn = Rotation.from_rotvec(angle * normals)
        other = np.stack([turn.apply(corner) for corner in laid])
        assert (((other - shapes) ** 2).sum(axis=(0, 2)) >= ((laid - shapes) ** 2).sum(axis=(0, 2)) - 1e-12).all()


def test_a_regular_face_opposite_to_its_target_is_solved():
    angle = np.radians([90, 210, 330])
    shapes = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)[:, None]
    normals = shaping.normals_of(shapes)
    laid = shaping.flattened_opposed(shapes, normals, -normals)
    np.testing.assert_allclose(shaping.normals_of(laid), -normals, atol=1e-12)
    # and so is a face perpendicular to its target
    upright = shaping.flattened_opposed(shapes, normals, np.array([[0.0, 1.0, 0.0]]))
    np.testing.assert_allclose(shaping.normals_of(upright), [[0, 1, 0]], atol=1e-12)


def test_the_boundary_is_fixed_unless_it_is_free():
    mesh = bumps()
    targets = tilted(mesh, 30)
    rim = np.isclose(np.abs(mesh.vertices[:, :2]), np.abs(mesh.vertices[:, :2]).max(axis=0)).any(axis=1)
    for scheme in SCHEMES:
        held, free = (nm.reconstruct(mesh, targets, options(scheme, boundary=b)) for b in ("hold", "free"))
        assert np.array_equal(held.vertices[rim], mesh.vertices[rim])
        assert np.abs(free.vertices[rim] - mesh.vertices[rim]).max() > 0.01
        assert held.report.boundary_vertices == free.report.boundary_vertices == rim.sum()
        assert held.report.volume_share is None is free.report.volume_change_mm3
        assert held.report.volume_change_mm3 is not None


def test_volumes_are_exact():
    ball = clean(sphere(30))
    dilated = 1.1 * ball.vertices + [3, 4, 5]
    before = volume(ball.vertices, ball.faces)
    assert before == pytest.approx(4 / 3 * np.pi, rel=0.01)
    assert volume_between(ball.vertices, dilated, ball.faces) == pytest.approx((1.1**3 - 1) * before)
    flat, tent = clean(sheet(lambda x, y: 0 * x, 2, 2)), clean(sheet(lambda x, y: 3.0 * ((x == 0) & (y == 0)), 2, 2))
    far = np.array([100.0, -50, 20])
    # a pyramid over the six faces in the middle: one third of base 3 times height 3
    assert volume_between(flat.vertices + far, tent.vertices + far, flat.faces) == pytest.approx(3.0)


def test_the_report_is_in_millimetres():
    mesh = bumps()
    inches = nm.Mesh(mesh.vertices, mesh.faces, 25.4, "given")
    targets = tilted(mesh, 30)
    one, other = (nm.reconstruct(m, targets).report for m in (mesh, inches))
    for name, power in (("moved_rms_mm", 1), ("moved_max_mm", 1), ("diagonal_mm", 1), ("volume_change_mm3", 3)):
        assert getattr(other, name) == pytest.approx(25.4**power * getattr(one, name))
    assert one.normal_deviation_deg == other.normal_deviation_deg < one.normal_deviation_before_deg
    assert one.mean_offset_mm == pytest.approx(one.volume_change_mm3 / mesh.geometry.areas.sum())


@pytest.mark.parametrize(
    ("scheme", "steps", "close"), [("gsfg-gradient", 20, 0.03), ("gsfg-shape", 20, 1e-2), ("poisson", 1, 1e-8)]
)
def test_the_multigrid_hierarchy_replaces_the_factorisation(scheme, steps, close, monkeypatch):
    true, rough, _ = noisy_sphere(0.2)
    targets = true.geometry.normals
    exact = nm.reconstruct(rough, targets, options(scheme, steps=steps)).vertices
    monkeypatch.setattr(stitching, "_DIRECT", 0)
    found = nm.reconstruct(rough, targets, options(scheme, steps=steps)).vertices
    assert np.linalg.norm(found - exact, axis=1).max() < close * rough.mean_edge
    assert np.array_equal(found, nm.reconstruct(rough, targets, options(scheme, steps=steps)).vertices)


def test_fully_held_and_free_parts_are_solved():
    ball = clean(sphere(8))
    lone = nm.Mesh(np.array([[3.0, 0, 0], [4, 0, 0], [3, 1, 0]]), np.array([[0, 1, 2]], np.int32))
    mesh = joined(ball, lone)
    targets = np.vstack([ball.geometry.normals, [[0, 0.6, 0.8]]])
    for scheme in SCHEMES:
        found = nm.reconstruct(mesh, targets, options(scheme))
        np.testing.assert_allclose(found.vertices, mesh.vertices, atol=1e-9)
    found = nm.reconstruct(lone, targets[-1:], nm.ReconstructOptions(boundary="free", closeness=1e-6, steps=200))
    assert angles(found.mesh.geometry.normals, targets[-1:]).max() < 0.1
    assert np.array_equal(nm.reconstruct(lone, targets[-1:]).vertices, lone.vertices)


def test_progress_is_reported_and_arguments_are_not_changed():
    mesh = bumps()
    targets = tilted(mesh, 10).astype(np.float32)
    before, told = targets.copy(), []
    nm.reconstruct(mesh, targets, progress=lambda word, share: told.append((word, share)))
    assert np.array_equal(targets, before)
    shares = [share for _, share in told]
    assert shares == sorted(shares)
    assert 0 <= shares[0] <= shares[-1] <= 1
    assert {word for word, _ in told} == {"setting up", "rebuilding"}
