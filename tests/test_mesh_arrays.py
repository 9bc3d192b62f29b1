"""Meshes from plain arrays of any type, and conversion to trimesh and back."""

import numpy as np
import pytest
import trimesh

import nmaptool as nm
from nmaptool.core.errors import InputError, UsageError

TRIANGLE = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


@pytest.mark.parametrize("kind", [np.int8, np.int64, np.uint16, np.float16, np.float32, np.float64, list])
def test_meshes_of_any_number_type_are_accepted(kind):
    make = (lambda values: values) if kind is list else (lambda values: np.array(values, kind))
    mesh = nm.Mesh.from_arrays(make(TRIANGLE), make([[0, 1, 2]]), mm_per_unit=10)
    assert (mesh.vertices.dtype, mesh.faces.dtype) == (np.float64, np.int32)
    np.testing.assert_array_equal(mesh.vertices_mm, np.array(TRIANGLE) * 10.0)
    assert len(nm.Mesh.from_arrays(TRIANGLE, []).faces) == 0


@pytest.mark.parametrize(
    ("vertices", "faces", "error", "message"),
    [
        (TRIANGLE, [[0, 1, 3]], InputError, "mesh: face 0 refers to vertex 3; expected whole numbers from 0 to 2"),
        (TRIANGLE, [[0, 1, 2], [0, 1, -1]], InputError, "face 1 refers to vertex -1"),
        (TRIANGLE, [[0, 1, 1.5]], InputError, "face 0 refers to vertex 1.5; expected whole numbers"),
        (TRIANGLE, [[0, 1, np.nan]], InputError, "face 0 refers to vertex nan"),
        (
            TRIANGLE,
            [[0, 1, 2, 0]],
            InputError,
            r"faces: found shape \(1, 4\), expected \(count, 3\); split larger faces",
        ),
        ([[0, 0]], [[0, 0, 0]], InputError, r"vertices: found shape \(1, 2\), expected \(count, 3\)$"),
        ("a.stl", [[0, 0, 0]], UsageError, "mesh: vertices must be an array of numbers, found str"),
    ],
)
def test_arrays_that_are_not_a_mesh_are_refused(vertices, faces, error, message):
    with pytest.raises(error, match=message):
        nm.Mesh.from_arrays(vertices, faces)


@pytest.mark.parametrize(("face", "named"), [([0, 1, 3], 3), ([0, 1, -1], -1), ([0, 2, -4], -4), ([-1, 7, 0], -1)])
def test_a_mesh_names_a_vertex_that_is_missing(face, named):
    message = rf"^mesh: a face refers to vertex {named}, which is missing \(vertices: 3\); the file is damaged"
    with pytest.raises(InputError, match=message):
        nm.Mesh(np.array(TRIANGLE, np.float64), np.array([[0, 1, 2], face], np.int32))


def test_meshes_convert_to_trimesh_and_back():
    box = trimesh.creation.box()
    assert nm.Mesh.from_trimesh(box).unit_from == "assumed"
    for units, mm in (("mm", 1), ("cm", 10), ("m", 1000), ("inches", 25.4)):
        box.units = units
        mesh = nm.Mesh.from_trimesh(box)
        assert (mesh.mm_per_unit, mesh.unit_from) == (pytest.approx(mm), "file")
        back = mesh.to_trimesh()
        np.testing.assert_array_equal(back.vertices, box.vertices)
        np.testing.assert_array_equal(back.faces, box.faces)
        assert nm.Mesh.from_trimesh(back).mm_per_unit == mesh.mm_per_unit
    assert nm.Mesh.from_trimesh(box, mm_per_unit=2).unit_from == "given"
    assert nm.Mesh.from_arrays(TRIANGLE, [[0, 1, 2]], 7).to_trimesh().units is None
    box.units = "furlongs per"
    for value, error, message in (
        (box, InputError, "the trimesh mesh has the unknown unit 'furlongs per'; give mm_per_unit"),
        (trimesh.Scene(), UsageError, r"found a Scene; join its parts with scene.to_mesh\(\)"),
        ("a.stl", UsageError, "expected a trimesh.Trimesh, found str; use Mesh.from_arrays for arrays"),
    ):
        with pytest.raises(error, match=message):
            nm.Mesh.from_trimesh(value)
