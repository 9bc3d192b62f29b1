"""Nodes of glTF scenes: GPU instances and skins, compared with cases computed by hand."""

import mesh_files as files
import numpy as np
import pytest
from gltf_cases import Builder
from mesh_files import FACES, VERTICES, volume

from nmaptool.core.errors import InputError, LimitError
from nmaptool.io.meshes.reader import read_mesh

DAMAGED = r"GLB file is truncated or damaged; export it again$"
HALF = np.sqrt(0.5)


@pytest.fixture
def read(tmp_path):
    """``read(content)``: the mesh of a GLB."""

    def call(content, **options):
        (tmp_path / "a.glb").write_bytes(files.glb(content))
        return read_mesh(tmp_path / "a.glb", **options)

    return call


def instanced(made, **attributes):
    """A node of mesh 0 with instances."""
    return {"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}}}


def plain(made):
    primitive = {"attributes": {"POSITION": made.add(VERTICES)}, "indices": made.add(FACES.ravel(), "u1")}
    return [{"primitives": [primitive]}]


def test_every_instance_is_read_in_its_place(read):
    made = Builder()
    meshes = plain(made)
    node = instanced(
        made,
        TRANSLATION=made.add([[0, 0, 0], [10, 0, 0], [0, 20, 0]]),
        ROTATION=made.add([[0, 0, 0, 1], [0, 0, HALF, HALF], [0, 0, 0, 1]]),
        SCALE=made.add([[1, 1, 1], [2, 1, 1], [1, 1, -1]]),
    )
    mesh = read(made.content([{**node, "translation": [0, 0, 5]}], meshes=meshes))
    x, y, z = VERTICES.T
    first, second, third = mesh.vertices.reshape(3, 4, 3)
    assert np.allclose(first, np.stack([x, y, z + 5], 1))
    assert np.allclose(second, np.stack([10 - y, 2 * x, z + 5], 1))  # x doubled, turned a quarter, moved
    assert np.allclose(third, np.stack([x, y + 20, 5 - z], 1))
    assert volume(mesh) == pytest.approx(1 + 2 + 1)  # the mirrored one is not inside out
    assert mesh.faces.tolist() == [*FACES.tolist(), *(FACES + 4).tolist(), *(FACES[:, ::-1] + 8).tolist()]


def test_quantised_rotations_of_instances_are_read(read):
    made = Builder()
    meshes = plain(made)
    node = instanced(made, ROTATION=made.add([[0, 0, 32767, 32767], [0, 0, 0, 32767]], "i2", normalized=True))
    mesh = read(made.content([node], meshes=meshes))
    x, y, z = VERTICES.T
    assert np.allclose(mesh.vertices[:4], np.stack([-y, x, z], 1))
    assert np.allclose(mesh.vertices[4:], VERTICES)


def test_a_node_without_instances_is_placed_once_and_one_with_none_not_at_all(read):
    made = Builder()
    meshes = plain(made)
    assert len(read(made.content([instanced(made)], meshes=meshes)).faces) == 4
    nodes = [{**instanced(made, TRANSLATION=made.add(np.zeros((0, 3)))), "children": [1]}, {"mesh": 0}]
    assert len(read(made.content(nodes, meshes=meshes)).faces) == 4


def test_instances_of_different_number_are_refused(read):
    made = Builder()
    meshes = plain(made)
    node = instanced(made, TRANSLATION=made.add(np.zeros((2, 3))), SCALE=made.add(np.ones((3, 3))))
    with pytest.raises(InputError, match=DAMAGED):
        read(made.content([node], meshes=meshes))


def test_the_face_limit_counts_instances_before_they_are_made(read):
    made = Builder()
    meshes = plain(made)
    node = instanced(made, TRANSLATION=made.add(np.zeros((1000, 3))))
    nodes = [{"children": list(range(1, 1001))}, *[node] * 1000]
    with pytest.raises(LimitError, match=r"4000000 faces, more than the limit of 3999999; decimate it"):
        read(made.content(nodes, meshes=meshes), max_faces=3_999_999)


def test_nonfinite_instances_are_refused(read):
    made = Builder()
    meshes = plain(made)
    node = instanced(made, TRANSLATION=made.add([[0, 0, np.nan]]))
    with pytest.raises(InputError, match=r"node 0 of the scene has a transform that is not finite; export it again$"):
        read(made.content([node], meshes=meshes))


def skinned(made, joints, weights, joint_dtype="u1", **more):
    """Mesh 0 with joints and weights, all given per vertex; and its parts for the JSON."""
    attributes = {"POSITION": made.add(VERTICES), "JOINTS_0": made.add(joints, joint_dtype)}
    attributes["WEIGHTS_0"] = made.add(weights, **more)
    return [{"primitives": [{"attributes": attributes, "indices": made.add(FACES.ravel(), "u2")}]}]


def columns(*matrices):
    """Matrices as a glTF stores them."""
    return np.stack([np.asarray(m, float).T.ravel() for m in matrices])


def moved(x, y, z):
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


JOINTS = [[0, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0], [1, 7, 0, 0]]
WEIGHTS = np.float32([[1, 0, 0, 0], [1, 0, 0, 0], [0.5, 0.5, 0, 0], [1, 0, 0, 0]])


@pytest.mark.parametrize("kind", ["u1", "u2"])
def test_skins_at_rest_follow_their_joints_and_not_their_node(read, kind):
    made = Builder()
    meshes = skinned(made, JOINTS, WEIGHTS, kind)
    skins = [{"joints": [2, 3], "inverseBindMatrices": made.add(columns(moved(0, 0, -1), moved(-4, 0, 0)))}]
    nodes = [
        {"children": [1, 2], "translation": [0, 100, 0]},
        {"mesh": 0, "skin": 0, "translation": [50, 60, 70], "scale": [9, 9, 9]},
        {"children": [3], "translation": [0, 0, 1]},
        {"translation": [4, 0, 0], "scale": [1, 1, 2]},
    ]
    mesh = read(made.content(nodes, meshes=meshes, skins=skins))
    # joint 0 moves by (0, 100, 1) - (0, 0, 1); joint 1 also scales z and moves by (0, 100, 1)
    by_first = VERTICES + np.float32([0, 100, 0])
    by_second = VERTICES * [1, 1, 2] + [0, 100, 1]
    expected = [by_first[0], by_second[1], (by_first[2] + by_second[2]) / 2, by_second[3]]
    assert np.allclose(mesh.vertices, expected)
    assert volume(mesh) > 0


def test_weights_are_shares_and_may_be_normalised_integers(read):
    made = Builder()
    joints = np.tile([0, 1, 0, 0], (4, 1))
    weights = [[255, 0, 0, 0], [0, 255, 0, 0], [64, 64, 0, 0], [0, 0, 0, 0]]
    attributes_of = skinned(made, joints, np.array(weights), "u1", dtype="u1", normalized=True)
    skins = [{"joints": [1, 2]}]
    nodes = [{"mesh": 0, "skin": 0, "children": [1]}, {"children": [2]}, {"translation": [0, 0, 8]}]
    mesh = read(made.content(nodes, meshes=attributes_of, skins=skins))
    # weights that do not add up to 1 are scaled; a vertex without any follows its first joint
    assert np.allclose(mesh.vertices - VERTICES, [[0, 0, 0], [0, 0, 8], [0, 0, 4], [0, 0, 0]])


def test_joints_outside_the_scene_and_mirrored_joints_are_followed(read):
    made = Builder()
    meshes = skinned(made, np.zeros((4, 4)), np.tile([1, 0, 0, 0], (4, 1)))
    nodes = [{"mesh": 0, "skin": 0}, {"children": [2], "scale": [-1, 1, 1]}, {"translation": [1, 0, 0]}]
    mesh = read(made.content(nodes, meshes=meshes, skins=[{"joints": [2]}]))
    assert np.allclose(mesh.vertices, (VERTICES + np.float32([1, 0, 0])) * [-1, 1, 1])
    assert volume(mesh) == pytest.approx(1)


@pytest.mark.parametrize(
    ("skins", "joints"),
    [
        ([], 0),
        ([{"joints": [9]}], 0),
        ([{"joints": []}], 0),
        ([{"joints": [1]}], 1),
        ([{"joints": [1, 1], "inverseBindMatrices": 0}], 0),
        ([{"joints": [1, 1], "inverseBindMatrices": 4}], 0),
    ],
)
def test_invalid_skins_are_refused(read, skins, joints):
    made = Builder()
    meshes = skinned(made, np.full((4, 4), joints), np.tile([1, 0, 0, 0], (4, 1)))
    made.add(columns(np.eye(4)))  # accessor 4: one matrix too few
    nodes = [{"mesh": 0, "skin": 0, "children": [1]}, {}]
    with pytest.raises(InputError, match=DAMAGED):
        read(made.content(nodes, meshes=meshes, skins=skins))
