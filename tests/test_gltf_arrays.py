"""Arrays of glTF scenes: normalised integers, sparse arrays, morph targets, fans; and what is said about the rest."""

import io

import mesh_files as files
import numpy as np
import pytest
import trimesh
from gltf_cases import Builder
from mesh_files import FACES, VERTICES, tree, volume

from nmaptool.core.errors import InputError, LimitError
from nmaptool.io.meshes.reader import read_mesh

DAMAGED = r"(GLB|glTF) file is truncated or damaged; export it again$"


@pytest.fixture
def read(tmp_path):
    """``read(content)``: the same mesh read from a GLB and from a glTF."""

    def call(content, **options):
        meshes = []
        for name, data in (("a.glb", files.glb(content)), ("a.gltf", files.gltf(content))):
            (tmp_path / name).write_bytes(data)
            meshes.append(read_mesh(tmp_path / name, **options))
        assert np.array_equal(meshes[0].vertices, meshes[1].vertices)
        assert meshes[0].notes == meshes[1].notes
        return meshes[0]

    return call


def one_mesh(made, primitive, **mesh):
    primitive.setdefault("indices", made.add(FACES.ravel(), "u2"))
    return {"meshes": [{"primitives": [primitive], **mesh}]}


@pytest.mark.parametrize(("dtype", "largest"), [("i1", 127), ("u1", 255), ("i2", 32767), ("u2", 65535)])
def test_normalised_integers_are_fractions(read, dtype, largest):
    codes = np.array([[0, 0, 0], [largest, 0, 0], [0, largest // 2, 0], [0, 0, largest]])
    made = Builder()
    attributes = {
        "POSITION": made.add(codes, dtype, normalized=True),
        "NORMAL": made.add(codes, dtype, normalized=True),
    }
    parts = one_mesh(made, {"attributes": attributes})
    mesh = read(made.content([{"mesh": 0, "scale": [2, 4, 8]}], **parts, extensionsUsed=["KHR_mesh_quantization"]))
    assert np.allclose(mesh.vertices, codes / largest * [2, 4, 8], rtol=0, atol=1e-15)
    assert mesh.faces.tolist() == FACES.tolist()


def test_the_lowest_normalised_code_is_minus_one(read):
    made = Builder()
    codes = [[-128, -127, 0], [127, 0, 0], [0, 127, 0], [0, 0, 127]]
    parts = one_mesh(made, {"attributes": {"POSITION": made.add(codes, "i1", normalized=True)}})
    assert read(made.content(**parts)).vertices[0].tolist() == [-1, -1, 0]


@pytest.mark.parametrize("kind", ["u1", "u2", "u4"])
@pytest.mark.parametrize("base", [None, VERTICES + 1])
def test_sparse_positions_are_read(read, kind, base):
    made = Builder()
    position = made.sparse(4, [1, 3], VERTICES[[1, 3]], base, kind)
    mesh = read(made.content(**one_mesh(made, {"attributes": {"POSITION": position}})))
    expected = np.zeros((4, 3)) if base is None else base.copy()
    expected[[1, 3]] = VERTICES[[1, 3]]
    assert mesh.vertices.tolist() == expected.tolist()


def test_sparse_indices_are_read(read):
    made = Builder()
    indices = made.add(np.zeros(12), "u2")
    places = np.arange(12)
    made.tree["accessors"][indices]["sparse"] = {
        "count": 12,
        "indices": {"bufferView": made.view(places, "u1"), "componentType": 5121},
        "values": {"bufferView": made.view(FACES.ravel(), "u2")},
    }
    primitive = {"attributes": {"POSITION": made.add(VERTICES)}, "indices": indices}
    assert read(made.content(**one_mesh(made, primitive))).faces.tolist() == FACES.tolist()


def test_morph_targets_move_positions_by_the_weights_of_the_mesh_or_the_node(read):
    made = Builder()
    more = np.float32([[0, 0, 0], [1, 0, 0], [0, 0, 0], [0, 0, 0]])
    targets = [{"POSITION": made.add(more)}, {"NORMAL": made.add(more)}, {"POSITION": made.sparse(4, [3], [[0, 0, 6]])}]
    primitive = {"attributes": {"POSITION": made.add(VERTICES)}, "targets": targets}
    parts = one_mesh(made, primitive, weights=[0.5, 9, 0])
    by_mesh = read(made.content(**parts))
    assert by_mesh.vertices.tolist() == [[0, 0, 0], [1.5, 0, 0], [0, 2, 0], [0, 0, 3]]
    by_node = read(made.content([{"mesh": 0, "weights": [-1, 0, 1], "scale": [1, 1, 2]}], **parts))
    assert by_node.vertices.tolist() == [[0, 0, 0], [0, 0, 0], [0, 2, 0], [0, 0, 18]]
    del parts["meshes"][0]["weights"]
    assert read(made.content(**parts)).vertices.tolist() == VERTICES.tolist()
    parts["meshes"][0]["weights"] = [0, 0, 1]
    assert volume(read(made.content(**parts))) == pytest.approx(3)  # three times as high


def test_fans_and_strips_are_wound_as_trimesh_and_the_specification_say(read):
    made = Builder()
    disc = np.float32([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [-1, 0, 0]])
    fan = {"attributes": {"POSITION": made.add(disc)}, "mode": 6}
    order = {**fan, "indices": made.add([0, 2, 3, 4], "u1")}
    content = made.content(meshes=[{"primitives": [fan, order]}])
    mesh = read(content)
    assert mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3], [0, 3, 4], [5, 7, 8], [5, 8, 9]]
    a, b, c = mesh.corners.transpose(1, 0, 2)
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()
    strip = {"attributes": {"POSITION": made.add([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 2, 0]])}, "mode": 5}
    content = made.content(meshes=[{"primitives": [strip]}])
    ours = read(content)
    theirs = trimesh.load(io.BytesIO(files.glb(content)), file_type="glb", force="mesh", process=False)
    assert ours.faces.shape == theirs.faces.shape
    normals = np.cross(ours.corners[:, 1] - ours.corners[:, 0], ours.corners[:, 2] - ours.corners[:, 0])
    assert (normals[:, 2] > 0).all()


def test_what_is_ignored_is_said(read):
    content, data = tree()
    surface = content["meshes"][0]["primitives"][0]
    dots = {"attributes": {"POSITION": 0}, "mode": 0}
    lines = {"attributes": {"POSITION": 0}, "mode": 3}
    content["meshes"] = [{"primitives": [surface, dots, lines, {**lines, "mode": 1}]}, {"primitives": [surface]}]
    content["animations"] = [{}, {}]
    content["scenes"] = [{"nodes": [0]}, {"nodes": []}]
    assert read((content, data)).notes == (
        "ignored 2 animations: the mesh is read at rest",
        "ignored 1 set of points",
        "ignored 2 sets of lines",
        "scene 0 of 2 is read; ignored 1 mesh outside it",
    )
    assert read(tree()).notes == ()
    assert read(tree()).up_from == "file"


@pytest.mark.parametrize(
    "change",
    [
        {"count": 9},
        {"count": -1},
        {"indices": {"bufferView": 0, "componentType": 5126}},
        {"indices": {"bufferView": 99, "componentType": 5123}},
        {"values": {"bufferView": 0, "byteOffset": 10**9}},
        {"indices": None},
    ],
)
def test_invalid_sparse_arrays_are_refused(read, change):
    made = Builder()
    position = made.sparse(4, [1, 3], VERTICES[[1, 3]], VERTICES)
    made.tree["accessors"][position]["sparse"] |= change
    with pytest.raises(InputError, match=DAMAGED):
        read(made.content(**one_mesh(made, {"attributes": {"POSITION": position}})))


def test_places_of_sparse_arrays_beyond_the_end_are_refused(read):
    made = Builder()
    position = made.sparse(4, [1, 4], VERTICES[[1, 3]], VERTICES)
    with pytest.raises(InputError, match=DAMAGED):
        read(made.content(**one_mesh(made, {"attributes": {"POSITION": position}})))


@pytest.mark.parametrize(
    ("mesh", "primitive"),
    [
        ({"weights": [float("inf")]}, {}),
        ({"weights": ["a"]}, {}),
        ({"weights": [1.0]}, {"targets": [{"POSITION": 77}]}),
        ({"weights": [1.0]}, {"targets": [{"POSITION": 1}]}),  # of another length
        ({"weights": [1.0]}, {"targets": 5}),
    ],
)
def test_invalid_morph_targets_are_refused(read, mesh, primitive):
    made = Builder()
    position, _ = made.add(VERTICES), made.add(VERTICES[:3])
    with pytest.raises(InputError, match=DAMAGED):
        read(made.content(**one_mesh(made, {"attributes": {"POSITION": position}, **primitive}, **mesh)))


@pytest.mark.parametrize("count", [10**5, 10**9, 10**15])
def test_arrays_of_zeros_cannot_be_larger_than_the_file(read, count):
    made = Builder()
    position = made.sparse(count, [1, 3], VERTICES[[1, 3]])
    with pytest.raises(InputError, match=DAMAGED):
        read(made.content(**one_mesh(made, {"attributes": {"POSITION": position}})))


def test_the_limit_counts_fans_and_vertices_of_sparse_arrays(read):
    made = Builder()
    fan = {"attributes": {"POSITION": made.add(np.zeros((12, 3)))}, "mode": 6}
    content = made.content(meshes=[{"primitives": [fan]}])
    assert len(read(content, max_faces=10).faces) == 10
    with pytest.raises(LimitError, match=r"10 faces, more than the limit of 9; decimate it, or raise `max_faces`$"):
        read(content, max_faces=9)
