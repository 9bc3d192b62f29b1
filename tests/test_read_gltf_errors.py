"""Unusable glTF and GLB files: every odd scene gives a clear error."""

import struct

import mesh_files as files
import pytest
from mesh_files import VERTICES, tree

from nmaptool.core.errors import InputError
from nmaptool.io.meshes.reader import read_mesh

DAMAGED = r"(GLB|glTF) file is truncated or damaged; export it again$"


@pytest.fixture
def refused(tmp_path, capfd):
    """``refused(content, pattern)``: refused as glTF and as GLB, without other output."""

    def call(content, pattern):
        for name, data in (("a.glb", files.glb(content)), ("a.gltf", files.gltf(content))):
            (tmp_path / name).write_bytes(data)
            with pytest.raises(InputError, match=pattern) as caught:
                read_mesh(tmp_path / name)
            assert str(caught.value).startswith(f"{tmp_path / name}: ")
            assert "\n" not in str(caught.value)
            assert capfd.readouterr() == ("", "")

    return call


@pytest.mark.parametrize("extension", ["EXT_meshopt_compression", "KHR_meshopt_compression"])
def test_meshopt_compression_is_refused(refused, extension):
    pattern = r"is compressed with meshopt; export it again without compression(, such as by gltf-transform cp .*)?$"
    refused(tree(extensionsRequired=["KHR_mesh_quantization", extension]), pattern)
    content, data = tree(extensionsUsed=[extension])  # not declared as required, but nothing else is available
    del content["accessors"][0]["bufferView"]
    content["accessors"][0]["count"] = 10**6
    refused((content, data), pattern)
    content, data = tree()
    content["buffers"].append({"byteLength": 99, "extensions": {extension: {"fallback": True}}})
    refused((content, data), pattern)


def test_quantised_positions_scaled_by_their_node_are_read(tmp_path):
    content, data = tree(nodes=[{"mesh": 0, "scale": [0.5, 0.5, 0.5]}])
    start = len(data)
    data += (VERTICES * 2).astype("<i2").tobytes()
    content["bufferViews"].append({"buffer": 0, "byteOffset": start, "byteLength": 24})
    content["accessors"].append({"bufferView": 2, "componentType": 5122, "count": 4, "type": "VEC3"})
    content["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 2
    content["buffers"][0]["byteLength"] = len(data)
    (tmp_path / "a.glb").write_bytes(files.glb((content, data)))
    assert (read_mesh(tmp_path / "a.glb").vertices == VERTICES).all()


@pytest.mark.parametrize(
    "nodes",
    [
        [{"children": [0], "mesh": 0}],
        [{"children": [1]}, {"children": [2], "mesh": 0}, {"children": [1]}],
        [{"children": [1, 2]}, {"children": [3]}, {"children": [3]}, {"mesh": 0}],
        [{"children": [1, 1]}, {"mesh": 0}],
    ],
)
def test_nodes_that_are_not_a_tree_are_refused(refused, nodes):
    refused(tree(nodes=nodes), r"node \d of the scene has two parents or is its own ancestor; export it again$")


def test_trees_that_double_at_every_level_are_refused_quickly(refused):
    nodes = [{"children": [i + 1, i + 1]} for i in range(200)] + [{"mesh": 0}]
    refused(tree(nodes=nodes), r"has two parents or is its own ancestor")


@pytest.mark.parametrize(
    "place",
    [
        {"translation": [0, float("nan"), 0]},
        {"scale": [1, 1, float("inf")]},
        {"matrix": [float("nan")] * 16},
        {"rotation": [float("nan"), 0, 0, 1]},
        {"scale": [1e200, 1, 1], "children": [1]},
    ],
)
def test_nonfinite_transforms_are_refused(refused, place):
    nodes = [{**place, "mesh": 0}, {"scale": [1e200, 1, 1], "mesh": 0}]
    refused(tree(nodes=nodes), r"node [01] of the scene has a transform that is not finite; export it again$")


@pytest.mark.parametrize(
    "change",
    [
        {"nodes": [{"mesh": 1}]},
        {"nodes": [{"mesh": -1}]},
        {"nodes": [{"mesh": True}]},
        {"nodes": [{"children": [7]}]},
        {"nodes": [{"mesh": 0, "translation": [1, 2]}]},
        {"nodes": [{"mesh": 0, "scale": "big"}]},
        {"nodes": {"0": 1}},
        {"scene": 1},
        {"scenes": [{"nodes": [-1]}]},
        {"meshes": [{}]},
        {"meshes": [{"primitives": [{"attributes": {"POSITION": 1}}]}]},
        {"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 0}]}]},
        {"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 9}]}]},
        {"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}]},  # four corners
        {"accessors": []},
        {"bufferViews": [{"buffer": 0, "byteLength": 47}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}]},
        {"bufferViews": [{"buffer": 0, "byteLength": 48, "byteStride": 4}, {"buffer": 0, "byteLength": 24}]},
        {"bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 10**9, "byteLength": 24}]},
        {"bufferViews": [{"buffer": 3, "byteLength": 48}, {"buffer": 0, "byteLength": 24}]},
        {"buffers": [{"byteLength": 10**9}]},
        {"buffers": [{}]},
        {"asset": 2},
    ],
)
def test_dangling_references_are_refused(refused, change):
    refused(tree(**change), DAMAGED)


def test_other_versions_and_other_json_are_refused(tmp_path, refused):
    refused(tree(asset={"version": "1.0"}), r"is not glTF version 2; export it as glTF 2\.0$")
    for text in ("{}", '{"a": 1}'):
        (tmp_path / "a.gltf").write_text(text, encoding="utf-8")
        with pytest.raises(InputError, match=r"holds no glTF data; export it again, preferably as one GLB file$"):
            read_mesh(tmp_path / "a.gltf")


@pytest.mark.parametrize(
    "text",
    [
        b"{",
        b'{"asset": {"version": "2.0"}, "extras": ' + b"[" * 100_000 + b"]" * 100_000 + b"}",
        b'{"asset": {"version": "2.0"}, "extras": ' + b"9" * 10_000 + b"}",
        b'{"asset": {"version": "2.0"}, "buffers": 7}',
        b'{"asset": {"version": "2.0"}, "buffers": [{"byteLength": 3}]}',
        b'{"asset": {"version": "2.0"}, "buffers": [{"byteLength": 3, "uri": "data:a;base64,$$$$"}]}',
        b'{"asset": {"version": "2.0"}, "buffers": [{"byteLength": 3, "uri": "data:a,abc"}]}',
        b'{"asset": {"version": "2.0"}, "nodes": [\xff]}',
    ],
)
def test_invalid_json_is_refused(tmp_path, text):
    glb = struct.pack("<4sIIII", b"glTF", 2, 20 + len(text), len(text), 0x4E4F534A) + text
    for name, data in (("a.gltf", text), ("a.glb", glb)):
        (tmp_path / name).write_bytes(data)
        with pytest.raises(InputError, match=DAMAGED):
            read_mesh(tmp_path / name)


@pytest.mark.parametrize("size", [5, 11, 12, 15, 19])
def test_a_glb_without_a_first_chunk_is_truncated(tmp_path, size):
    path = tmp_path / "a.glb"
    cases = [(size, f"it holds {size} bytes, but every GLB file has at least 20")]
    if size >= 12:  # holds the whole header
        cases.append((500, f"it declares 500 bytes but holds {size}"))
    for declared, held in cases:
        path.write_bytes(struct.pack("<4sIIII", b"glTF", 2, declared, 0, 0)[:size])
        with pytest.raises(
            InputError, match=rf"a\.glb: the GLB file is truncated: {held}; export or download it again$"
        ):
            read_mesh(path)
