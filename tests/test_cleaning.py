"""Mesh cleaning: what is welded, dropped and reported, and which meshes are refused."""

import numpy as np
import pytest
from mesh_files import FACES, VERTICES, volume

from nmaptool.core.errors import InputError
from nmaptool.meshes.clean import clean_mesh
from nmaptool.types.mesh import Mesh, face_geometry, mean_edge_length
from nmaptool.types.mesh_findings import MeshFindings

V = VERTICES.astype(np.float64)


def mesh_of(vertices, faces, **more):
    return Mesh(np.array(vertices, np.float64), np.array(faces, np.int32).reshape(-1, 3), **more)


def soup(vertices=V, faces=FACES):
    """Give every triangle its own three vertices, as in an STL."""
    return mesh_of(vertices[faces].reshape(-1, 3), np.arange(3 * len(faces)))


def test_a_clean_mesh_is_not_changed():
    given = Mesh(V, FACES, 25.4, "given", "a.obj")
    mesh, source, findings = clean_mesh(given)
    assert np.array_equal(mesh.vertices, V)
    assert np.array_equal(mesh.faces, FACES)
    assert np.array_equal(source, np.arange(4))
    assert source.dtype == np.int64
    assert findings == MeshFindings(vertices=4, faces=4)
    assert (mesh.mm_per_unit, mesh.unit_from, mesh.name) == (25.4, "given", "a.obj")


def test_a_triangle_soup_is_welded_in_file_order():
    mesh, source, findings = clean_mesh(soup())
    assert np.array_equal(mesh.vertices, V[[0, 2, 1, 3]])  # in order of first appearance
    assert np.array_equal(mesh.corners, V[FACES])
    assert np.array_equal(source, np.arange(4))
    assert findings == MeshFindings(vertices=12, faces=4, welded_vertices=8)
    assert volume(mesh) == pytest.approx(1)


def test_only_vertices_at_exactly_the_same_position_are_welded():
    vertices = [*V, (np.nextafter(1.0, 2), 0, 0)]  # next to vertex 1
    mesh, _, findings = clean_mesh(mesh_of(vertices, [*FACES.tolist(), [4, 2, 3]]))
    assert findings.welded_vertices == 0
    assert len(mesh.vertices) == 5


def test_positive_and_negative_zero_are_the_same_position():
    vertices = np.concatenate([V, -V])
    mesh, _, findings = clean_mesh(mesh_of(vertices, [[0, 1, 2], [4, 2, 3]]))
    assert findings.welded_vertices == 1
    assert len(mesh.vertices) == 4
    assert not np.signbit(mesh.vertices).any()


def test_a_welded_mesh_of_random_triangles_is_the_same_surface():
    random = np.random.default_rng(4)
    grid = random.integers(0, 5, (400, 3)).astype(float)
    faces = random.integers(0, 400, (900, 3))
    mesh, source, findings = clean_mesh(mesh_of(grid, faces))
    same, turned = ((mesh.corners == grid[faces][source][:, way]).all(axis=(1, 2)) for way in ([0, 1, 2], [2, 1, 0]))
    assert (same | turned).all()
    assert turned.sum() == findings.turned_faces
    assert len(np.unique(mesh.vertices, axis=0)) == len(mesh.vertices)
    assert set(mesh.faces.ravel()) == set(range(len(mesh.vertices)))
    area = np.linalg.norm(np.cross(*(grid[faces[:, k]] - grid[faces[:, 0]] for k in (1, 2))), axis=1)
    assert set(source) <= set(np.flatnonzero(area > 1e-9))
    assert len(source) + findings.repeated_faces == (area > 1e-9).sum()
    assert findings.degenerate_faces == (area < 1e-9).sum() > 0


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_nonfinite_vertices_are_dropped_with_their_faces(value):
    vertices = np.append(V, [[0, value, 0], [value] * 3], axis=0)
    faces = [[0, 1, 4], *FACES[:2].tolist(), [4, 4, 4], *FACES[2:].tolist()]
    mesh, source, findings = clean_mesh(mesh_of(vertices, faces))
    assert np.array_equal(mesh.corners, V[FACES])
    assert np.array_equal(source, [1, 2, 4, 5])
    assert findings == MeshFindings(vertices=6, faces=6, nonfinite_vertices=2, nonfinite_faces=2)


def test_vertices_used_only_by_dropped_faces_are_dropped_too():
    vertices = np.append(V, [[7, 7, 7], [np.nan] * 3, [8, 8, 8]], axis=0)
    mesh, source, findings = clean_mesh(mesh_of(vertices, [[4, 5, 0], [6, 6, 0], *FACES.tolist()]))
    assert np.array_equal(mesh.vertices, V)
    assert np.array_equal(source, [2, 3, 4, 5])
    # not counted as unreferenced: a face did reference them, if only a useless one
    assert findings == MeshFindings(vertices=7, faces=6, nonfinite_vertices=1, nonfinite_faces=1, degenerate_faces=1)


def test_unreferenced_vertices_are_dropped_and_do_not_affect_the_size():
    vertices = np.concatenate([[[1e200, 0, 0]], V, [[0, 0, 0], [np.nan] * 3]])
    mesh, _, findings = clean_mesh(mesh_of(vertices, FACES + 1))
    assert np.array_equal(mesh.vertices, V)
    assert np.array_equal(mesh.faces, FACES)
    assert findings == MeshFindings(vertices=7, faces=4, unreferenced_vertices=2, nonfinite_vertices=1)


@pytest.mark.parametrize("scale", [1e-20, 1.0, 1e20])
@pytest.mark.parametrize(
    "thin",
    [
        [[0, 0, 0], [0, 0, 0], [0, 1, 0]],
        [[0, 0, 0], [1, 0, 0], [2, 0, 0]],
        [[0, 0, 0], [2, 0, 0], [1, 0, 0]],
        [[1, 1, 1], [4, 4, 4], [9, 9, 9]],
        [[0, 0, 0], [1, 0, 0], [0.5, 1e-12, 0]],
        [[3, 3, 3]] * 3,
    ],
)
def test_faces_without_area_are_dropped_at_every_scale(scale, thin):
    vertices = np.concatenate([V, thin]) * scale
    mesh, source, findings = clean_mesh(mesh_of(vertices, [*FACES[:3].tolist(), [4, 5, 6], FACES[3].tolist()]))
    assert findings.degenerate_faces == 1
    assert np.array_equal(source, [0, 1, 2, 4])
    assert np.array_equal(mesh.vertices, V * scale)


@pytest.mark.parametrize("scale", [1e-29, 1e-8, 1e8, 1e29])
def test_slivers_and_small_faces_stay_and_have_normals(scale):
    vertices = np.concatenate([V, [[0, 0, 0], [1, 0, 0], [0.5, 1e-7, 0]], V[[0, 1, 2]] * 1e-9]) * scale
    mesh, source, findings = clean_mesh(mesh_of(vertices, [*FACES.tolist(), [4, 5, 6], [7, 8, 9]]))
    assert findings.degenerate_faces == 0
    assert len(source) == 6
    geometry = face_geometry(mesh)
    assert np.linalg.norm(geometry.normals, axis=1) == pytest.approx(1)
    assert (geometry.areas > 0).all()
    assert np.isfinite(geometry.centroids).all()
    assert 0 < mean_edge_length(mesh) < 4 * scale


def test_a_mesh_far_from_the_origin_keeps_its_faces():
    mesh, _, findings = clean_mesh(soup(V + 4e6))
    assert findings.welded_vertices == 8
    assert len(mesh.faces) == 4


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (V, [], r"a\.obj: holds 4 points and no faces; a surface is needed$"),
        (np.zeros((0, 3)), [], r"a\.obj: holds 0 points and no faces; a surface is needed$"),
        (V * np.nan, FACES, r"a\.obj: every face has a vertex that is NaN or infinite; export it again$"),
        (np.append(V[:3], [[np.inf] * 3], axis=0), [[0, 1, 3]], r"every face has a vertex that is NaN or infinite"),
        (V * 0 + 3, FACES, r"a\.obj: all vertices are at one point; a surface is needed$"),
        (V, [[1, 1, 1]], r"a\.obj: all vertices are at one point; a surface is needed$"),
        (V, [[0, 1, 1], [2, 2, 3]], r"a\.obj: no face has an area \(faces: 2\); export it again$"),
        (V * [1, 0, 0], FACES, r"a\.obj: no face has an area \(faces: 4\); export it again$"),
        (V * 1e40, FACES, r"a\.obj: is 3e\+40 units large; scale it to a realistic size$"),
        (np.where(V > 0, 1e308, -1e308), FACES, r"a\.obj: is inf units large; scale it to a realistic size$"),
        (V * 1e-40, FACES, r"a\.obj: is 3e-40 units large; scale it to a realistic size$"),
        (V * 1e-320, FACES, r"a\.obj: is .*e-320 units large; scale it to a realistic size$"),
    ],
)
def test_meshes_that_cannot_be_cleaned_are_refused(vertices, faces, message):
    with pytest.raises(InputError, match=message):
        clean_mesh(mesh_of(vertices, faces, name="a.obj"))


def test_the_given_mesh_is_not_changed():
    given = soup()
    before = given.vertices.copy(), given.faces.copy()
    mesh, _, _ = clean_mesh(given)
    assert np.array_equal(given.vertices, before[0])
    assert np.array_equal(given.faces, before[1])
    with pytest.raises(ValueError, match="read-only"):
        mesh.vertices[0] = 7
