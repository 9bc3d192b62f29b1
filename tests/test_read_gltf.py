"""Arrays in glTF files: every component type, gaps and offsets, several primitives per mesh."""

import mesh_files as files
import numpy as np
import pytest
from mesh_files import FACES, VERTICES, tree

from nmaptool.core.errors import InputError
from nmaptool.io.meshes.reader import read_mesh

POSITION_TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
INDEX_TYPES = {5121: "<u1", 5123: "<u2", 5125: "<u4"}


def packed(*arrays, strides=()):
    """Accessors and views of consecutive arrays; ``strides`` are the bytes from row to row, if given."""
    views, accessors, data = [], [], b"\xff" * 4  # other bytes precede them
    for i, (kind, dtype, array) in enumerate(arrays):
        rows = np.asarray(array, dtype).reshape(len(array), -1)
        stride = strides[i] if i < len(strides) else rows[0].nbytes
        body = b"".join(row.tobytes().ljust(stride, b"\xee") for row in rows)
        views.append({"buffer": 0, "byteOffset": len(data) - 4, "byteLength": len(body) + 4})
        if stride != rows[0].nbytes:
            views[-1]["byteStride"] = stride
        shape = "VEC3" if rows.shape[1] == 3 else "SCALAR"
        accessors.append({"bufferView": i, "byteOffset": 4, "componentType": kind, "count": len(rows), "type": shape})
        data += body + bytes(-len(body) % 4)
    content, _ = tree(buffers=[{"byteLength": len(data)}], bufferViews=views, accessors=accessors)
    return content, data


@pytest.mark.parametrize("index_kind", INDEX_TYPES)
@pytest.mark.parametrize("kind", POSITION_TYPES)
@pytest.mark.parametrize("stride", [12, 16, 252])
def test_every_component_type_is_read(tmp_path, kind, index_kind, stride):
    content = packed(
        (kind, POSITION_TYPES[kind], VERTICES), (index_kind, INDEX_TYPES[index_kind], FACES.ravel()), strides=(stride,)
    )
    for name, data in (("a.glb", files.glb(content)), ("a.gltf", files.gltf(content))):
        (tmp_path / name).write_bytes(data)
        mesh = read_mesh(tmp_path / name)
        assert mesh.vertices.tolist() == VERTICES.tolist()
        assert mesh.faces.tolist() == FACES.tolist()


def test_primitives_keep_the_order_of_the_file(tmp_path):
    content, data = packed((5126, "<f4", VERTICES), (5121, "<u1", FACES.ravel()), (5126, "<f4", VERTICES[:3] + 9))
    first = {"attributes": {"POSITION": 0}, "indices": 1}
    plain = {"attributes": {"POSITION": 2}}
    strip = {"attributes": {"POSITION": 0}, "mode": 5}
    content["meshes"] = [{"primitives": [plain]}, {"primitives": [first, strip]}]
    content["nodes"] = [{"mesh": 1}, {"mesh": 0, "scale": [1, 1, -1]}, {"mesh": 0}]
    content["scenes"] = [{"nodes": [0, 1, 2]}]
    (tmp_path / "a.glb").write_bytes(files.glb((content, data)))
    mesh = read_mesh(tmp_path / "a.glb")
    far = VERTICES[:3] + 9
    assert mesh.vertices.tolist() == [*VERTICES.tolist() * 2, *(far * [1, 1, -1]).tolist(), *far.tolist()]
    assert mesh.faces.tolist() == [*FACES.tolist(), [4, 5, 6], [7, 6, 5], [10, 9, 8], [11, 12, 13]]


def test_an_index_beyond_its_primitive_is_refused_even_if_another_follows(tmp_path):
    content, data = packed((5126, "<f4", VERTICES[:3]), (5121, "<u1", FACES.ravel()))
    content["nodes"] = [{"mesh": 0}, {"mesh": 0}]
    content["scenes"] = [{"nodes": [0, 1]}]
    (tmp_path / "a.glb").write_bytes(files.glb((content, data)))
    with pytest.raises(InputError, match=r"refers to vertex 3, which is missing \(vertices: 3\); export it again$"):
        read_mesh(tmp_path / "a.glb")
