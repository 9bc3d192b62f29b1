"""Files beside a glTF: its buffers are read from its own folder, and nothing else is ever opened."""

import json
import os

import mesh_files as files
import numpy as np
import pytest
from mesh_files import FACES, VERTICES, tree

from nmaptool.core.errors import InputError
from nmaptool.io.meshes.reader import read_mesh

OUTSIDE = r", but only files in its own folder are opened; put all in one folder, or export one GLB file$"
MISSING = r" beside it, which is missing; put it there, or export one GLB file$"


@pytest.fixture
def scene(tmp_path):
    """``scene(uri)``: the path of a glTF whose buffer has that name; its folder is empty otherwise."""
    folder = tmp_path / "scene folder"
    folder.mkdir()

    def call(uri, **more):
        content, data = tree(**more)
        content["buffers"] = [{"uri": uri, "byteLength": len(data)}]
        (folder / "a.gltf").write_text(json.dumps(content), encoding="utf-8")
        return folder / "a.gltf"

    return call


def same(path):
    mesh = read_mesh(path)
    assert mesh.vertices.tolist() == VERTICES.tolist()
    assert mesh.faces.tolist() == FACES.tolist()


@pytest.mark.parametrize(
    ("uri", "name"),
    [
        ("a.bin", "a.bin"),
        ("./a.bin", "a.bin"),
        ("parts/a.bin", "parts/a.bin"),
        ("parts\\a.bin", "parts/a.bin"),
        ("my%20model%C3%A9.bin", "my modelé.bin"),
        ("my model.bin", "my model.bin"),
        ("100%.bin", "100%.bin"),
        ("as%20is.bin", "as%20is.bin"),
    ],
)
def test_a_buffer_in_its_folder_is_read(scene, monkeypatch, uri, name):
    path = scene(uri)
    target = path.parent / name
    target.parent.mkdir(exist_ok=True)
    target.write_bytes(tree()[1])
    same(path)
    monkeypatch.chdir(path.parent)
    same("a.gltf")


def test_pictures_beside_it_are_not_touched(scene):
    images = [{"uri": "missing.png"}, {"uri": "../../secret.png"}, {"uri": "http://example.org/a.png"}]
    path = scene("a.bin", images=images, textures=[{"source": 0}])
    (path.parent / "a.bin").write_bytes(tree()[1])
    same(path)


def test_a_glb_may_have_a_buffer_beside_it(tmp_path):
    content, data = tree()
    content["buffers"] = [{"uri": "b.bin", "byteLength": len(data)}]
    (tmp_path / "b.bin").write_bytes(data)
    (tmp_path / "a.glb").write_bytes(files.glb((content, b"")))
    same(tmp_path / "a.glb")


@pytest.mark.parametrize(
    "uri",
    [
        "../a.bin",
        "parts/../../a.bin",
        "%2e%2e/a.bin",
        "..%2Fa.bin",
        "..\\a.bin",
        "/etc/passwd",
        "%2Fetc/passwd",
        "C:\\a.bin",
        "http://127.0.0.1:1/a.bin",
        "file:///etc/passwd",
        "a%00.bin",
    ],
)
def test_files_outside_the_folder_are_never_opened(scene, monkeypatch, uri):
    path = scene(uri)
    (path.parent.parent / "a.bin").write_bytes(tree()[1])
    (path.parent / "parts").mkdir()
    with pytest.raises(InputError, match=OUTSIDE) as caught:
        read_mesh(path)
    assert str(caught.value).startswith(f"{path}: needs ")
    assert "\n" not in str(caught.value)


@pytest.mark.skipif(os.name != "posix", reason="Windows allows links to administrators only")
def test_links_that_lead_out_of_the_folder_are_refused(scene):
    path = scene("a.bin")
    (path.parent.parent / "secret.bin").write_bytes(tree()[1])
    (path.parent / "a.bin").symlink_to(path.parent.parent / "secret.bin")
    with pytest.raises(InputError, match=OUTSIDE):
        read_mesh(path)
    (path.parent / "parts").symlink_to(path.parent.parent)
    with pytest.raises(InputError, match=OUTSIDE):
        read_mesh(scene("parts/secret.bin"))


@pytest.mark.skipif(os.name != "posix", reason="Windows allows links to administrators only")
def test_a_link_to_a_folder_or_within_it_is_followed(scene):
    path = scene("a.bin")
    (path.parent / "b.bin").write_bytes(tree()[1])
    (path.parent / "a.bin").symlink_to("b.bin")
    (path.parent.parent / "link").symlink_to(path.parent)
    same(path)
    same(path.parent.parent / "link" / "a.gltf")


def test_a_missing_buffer_is_named(scene):
    for uri in ("a.bin", "x/" * 60 + "a.bin", "folder"):
        path = scene(uri)
        (path.parent / "folder").mkdir(exist_ok=True)
        with pytest.raises(InputError, match=r"needs the file '(a\.bin|(x/)+x?\.\.\.|folder)'" + MISSING):
            read_mesh(path)


@pytest.mark.parametrize("uri", ["", 7, None, ["a.bin"]])
def test_names_that_are_none_are_refused(scene, uri):
    with pytest.raises(InputError, match=r"the glTF file is truncated or damaged; export it again$"):
        read_mesh(scene(uri))


def test_a_truncated_buffer_is_named(scene):
    path = scene("a.bin")
    data = tree()[1]
    for size in range(0, len(data), 5):
        (path.parent / "a.bin").write_bytes(data[:size])
        pattern = (
            rf"a\.bin is truncated: it should hold {len(data)} bytes but holds {size}; export or download it again$"
        )
        with pytest.raises(InputError, match=pattern):
            read_mesh(path)


def test_an_unused_buffer_must_be_there_but_a_longer_one_is_no_fault(scene):
    path = scene("a.bin")
    content = json.loads(path.read_text(encoding="utf-8"))
    (path.parent / "a.bin").write_bytes(tree()[1] + bytes(99))
    same(path)
    content["buffers"].append({"uri": "b.bin", "byteLength": 4})
    path.write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(InputError, match=r"needs the file 'b\.bin'" + MISSING):
        read_mesh(path)


def test_a_buffer_named_many_times_is_loaded_once(scene):
    made = tree()[0]
    path = scene("a.bin")
    content = json.loads(path.read_text(encoding="utf-8"))
    content["buffers"] *= 1000
    for k, view in enumerate(made["bufferViews"]):
        content["bufferViews"][k] = {**view, "buffer": 500 + k}
    path.write_text(json.dumps(content), encoding="utf-8")
    (path.parent / "a.bin").write_bytes(np.frombuffer(tree()[1], np.uint8).tobytes())
    same(path)
