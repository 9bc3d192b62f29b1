"""Draco-compressed parts of a glTF: decoded with DracoPy, or refused with the way to install it."""

import sys

import DracoPy
import mesh_files as files
import numpy as np
import pytest
from gltf_cases import Builder
from mesh_cases import sphere
from mesh_files import FACES, VERTICES, volume

from nmaptool.core.errors import InputError, NmaptoolError
from nmaptool.io.meshes.reader import read_mesh

NAME = "KHR_draco_mesh_compression"
INSTALL = r'is compressed with Draco; pip install "nmaptool-relief\[draco\]" to read it, or export it again without '


def compressed(vertices=VERTICES, faces=FACES, fallback=False, counts=None, **more):
    """A glTF with one compressed mesh, with or without the same arrays uncompressed."""
    data = DracoPy.encode(np.asarray(vertices, np.float32), np.asarray(faces, np.uint32), quantization_bits=16)
    made = Builder()
    view = made.view(np.frombuffer(data, np.uint8), "u1")
    n, m = counts or (len(vertices), np.size(faces))
    if fallback:
        position, indices = made.add(vertices), made.add(np.ravel(faces), "u4")
    else:
        position, indices = 0, 1
        made.tree["accessors"] = [
            {"componentType": 5126, "count": n, "type": "VEC3"},
            {"componentType": 5125, "count": m, "type": "SCALAR"},
        ]
    extension = {NAME: {"bufferView": view, "attributes": {"POSITION": 0}}}
    primitive = {"attributes": {"POSITION": position}, "indices": indices, "extensions": extension, **more}
    required = {} if fallback else {"extensionsRequired": [NAME]}
    return made.content([{"mesh": 0, "scale": [1, 1, 2]}], meshes=[{"primitives": [primitive]}], **required)


def read(tmp_path, content):
    (tmp_path / "a.glb").write_bytes(files.glb(content))
    return read_mesh(tmp_path / "a.glb")


@pytest.fixture
def without_decoder(monkeypatch):
    """As if DracoPy were not installed."""
    monkeypatch.setitem(sys.modules, "DracoPy", None)


def test_compressed_parts_are_decoded(tmp_path):
    mesh = read(tmp_path, compressed())
    assert len(mesh.vertices) == 4
    assert volume(mesh) == pytest.approx(2, rel=1e-3)
    assert np.allclose(np.sort(mesh.vertices, axis=0), np.sort(VERTICES * [1, 1, 2], axis=0), atol=1e-3)
    ball = sphere(16)
    mesh = read(tmp_path, compressed(ball.vertices, ball.faces))
    assert volume(mesh) == pytest.approx(2 * volume(ball), rel=1e-3)


def test_without_the_package_the_way_to_it_is_named(tmp_path, without_decoder):
    with pytest.raises(InputError, match=INSTALL):
        read(tmp_path, compressed())


def test_without_the_package_uncompressed_arrays_are_read(tmp_path, without_decoder):
    assert read(tmp_path, compressed(fallback=True)).vertices.tolist() == (VERTICES * [1, 1, 2]).tolist()


def test_compressed_skins_and_morph_targets_at_rest_are_read(tmp_path):
    joints, weights = np.tile([1, 0, 0, 0], (4, 1)).astype(np.uint8), np.tile([1, 0, 0, 0], (4, 1)).astype(np.float32)
    generic = {5: joints, 6: weights}
    data = DracoPy.encode(VERTICES, FACES.astype(np.uint32), preserve_order=True, generic_attributes=generic)
    made = Builder()
    view = made.view(np.frombuffer(data, np.uint8), "u1")
    made.tree["accessors"] = [
        {"componentType": 5126, "count": 4, "type": "VEC3"},
        {"componentType": 5125, "count": 12, "type": "SCALAR"},
        {"componentType": 5121, "count": 4, "type": "VEC4"},
        {"componentType": 5126, "count": 4, "type": "VEC4"},
    ]
    ids = {"POSITION": 7, "JOINTS_0": 5, "WEIGHTS_0": 6}
    primitive = {
        "attributes": {"POSITION": 0, "JOINTS_0": 2, "WEIGHTS_0": 3},
        "indices": 1,
        "extensions": {NAME: {"bufferView": view, "attributes": ids}},
        "targets": [{"POSITION": made.add(np.tile([5, 0, 0], (4, 1)))}],
    }
    nodes = [{"mesh": 0, "skin": 0, "children": [1]}, {"translation": [0, 0, 8]}]
    meshes = [{"primitives": [primitive], "weights": [2]}]
    mesh = read(tmp_path, made.content(nodes, meshes=meshes, skins=[{"joints": [0, 1]}], extensionsRequired=[NAME]))
    assert np.allclose(mesh.vertices, VERTICES + np.float32([10, 0, 8]), atol=1e-3)


@pytest.mark.parametrize("counts", [(5, 12), (4, 9), (4, 11), (10**9, 12), (4, 3 * 10**9)])
def test_wrong_counts_are_refused(tmp_path, counts):
    with pytest.raises(InputError, match=r"GLB file is truncated or damaged; export it again$"):
        read(tmp_path, compressed(counts=counts))


def test_damaged_compressed_data_gives_a_mesh_or_an_error(tmp_path):
    content, data = compressed()
    rng = np.random.default_rng(3)
    outcomes = set()
    for _ in range(150):
        damaged = bytearray(data)
        for _ in range(rng.integers(1, 4)):
            damaged[rng.integers(len(data))] ^= 1 << int(rng.integers(8))
        try:
            read(tmp_path, (content, bytes(damaged)))
            outcomes.add("mesh")
        except NmaptoolError as error:
            assert str(error).startswith(f"{tmp_path / 'a.glb'}: ")
            outcomes.add("error")
    assert outcomes == {"mesh", "error"}
