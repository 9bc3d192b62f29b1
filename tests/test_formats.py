"""Format tables: an added entry is accepted by the writers, named in messages and shown wherever formats are listed."""

import subprocess
import sys

import pytest
from compose_cases import bump_map
from workspace_cases import random_workspace

import nmaptool as nm
from nmaptool.core.errors import UsageError
from nmaptool.options import formats
from nmaptool.options.formats import FileFormat, MapFormat, WorkspaceFormat

TABLES = {
    "NORMAL_MAP_FORMATS": [".png", ".exr", ".tif", ".tiff"],
    "HEIGHT_FORMATS": [".exr", ".tif", ".tiff", ".npy", ".png"],
    "MESH_FORMATS": [".stl", ".ply", ".obj", ".glb", ".3mf"],
    "RELIEF_FORMATS": [".exr", ".tif", ".tiff", ".npy", ".png", ".stl", ".ply", ".obj", ".glb", ".3mf"],
    "WORKSPACE_FORMATS": [".psd", ".psb", ".ora", ".tif", ".tiff", ".exr"],
}


@pytest.mark.parametrize("name", TABLES)
def test_tables_describe_every_format(name):
    table = getattr(formats, name)
    assert list(table) == TABLES[name]
    assert all(entry.description and "\n" not in entry.description for entry in table.values())


def test_tables_load_nothing_heavy():
    code = "import sys, nmaptool.options.formats; print('numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


@pytest.fixture(scope="module")
def relief():
    return nm.relief(bump_map(20, 30), options=nm.ReliefOptions(width=nm.length("30mm")))


def test_a_map_format_added_at_run_time_is_written(tmp_path, run, monkeypatch):
    def write(normal_map, path, options, attributes):
        path.write_text(f"{normal_map.frame.cols} {options.bits} {attributes}", encoding="utf-8")

    monkeypatch.setitem(nm.NORMAL_MAP_FORMATS, ".xyz", MapFormat("numbers as text", write, bits=("float", "8")))
    nm.write_normal_map(bump_map(8, 9), tmp_path / "a.xyz", nm.WriteOptions(bits="8"), attributes={"by": "me"})
    assert (tmp_path / "a.xyz").read_text(encoding="utf-8") == "9 8 {'by': 'me'}"
    with pytest.raises(UsageError, match=r"ends in \.jpg; normal maps are written as .*\.tiff, \.xyz$"):
        nm.write_normal_map(bump_map(8, 9), tmp_path / "a.jpg")
    with pytest.raises(UsageError, match=r"`bits='16'` is not supported for \.xyz; use float or 8$"):
        nm.write_normal_map(bump_map(8, 9), tmp_path / "b.xyz", nm.WriteOptions(bits="16"))
    nm.write_normal_map(bump_map(8, 9), tmp_path / "a.exr")
    assert run("compose", "transform", tmp_path / "a.exr", "-o", tmp_path / "c.xyz", "--flip-h").code == 0
    assert (tmp_path / "c.xyz").read_text(encoding="utf-8").startswith("9 auto {'recipe': ")


def test_a_relief_is_written_in_every_height_and_mesh_format(relief, tmp_path, run, clean_map, monkeypatch):
    def write_heights(height, path, attributes):
        path.write_text(f"{height.z_mm.shape} {attributes['unit']}", encoding="utf-8")

    def write_faces(mesh, path):
        path.write_text(str(len(mesh.faces)), encoding="utf-8")

    monkeypatch.setitem(nm.HEIGHT_FORMATS, ".asc", FileFormat("heights as text", write_heights))
    monkeypatch.setitem(nm.MESH_FORMATS, ".count", FileFormat("the number of faces", write_faces))
    nm.write_relief(relief, tmp_path / "a.asc", tmp_path / "a.count")
    assert (tmp_path / "a.asc").read_text(encoding="utf-8") == "(21, 31) mm"
    assert (tmp_path / "a.count").read_text(encoding="utf-8") == str(2 * 20 * 30)
    with pytest.raises(UsageError, match=r"a relief is written as \.exr, .*\.png, \.asc, \.stl, .*\.3mf, \.count$"):
        nm.write_relief(relief, tmp_path / "a.xyz")
    with pytest.raises(UsageError, match=r"a mesh is written as \.stl, \.ply, \.obj, \.glb, \.3mf, \.count$"):
        nm.write_mesh(nm.surface_mesh(relief.height), tmp_path / "a.asc")
    assert run("relief", clean_map, "-o", tmp_path / "b.count").code == 0


def test_a_workspace_format_added_at_run_time_is_written(tmp_path, monkeypatch):
    def write(workspace, path):
        path.write_text(" ".join(layer.name for layer in workspace.layers), encoding="utf-8")

    monkeypatch.setitem(nm.WORKSPACE_FORMATS, ".list", WorkspaceFormat("names of the layers", write, bits=(8, 16)))
    workspace = random_workspace()
    nm.write_workspace(workspace, tmp_path / "a.list")
    assert (tmp_path / "a.list").read_text(encoding="utf-8") == " ".join(layer.name for layer in workspace.layers)
    with pytest.raises(UsageError, match=r"a workspace is written as \.psd, .*\.exr, \.list$"):
        nm.write_workspace(workspace, tmp_path / "a.png")


def test_heights_and_meshes_refuse_each_others_endings(relief, tmp_path):
    from nmaptool.io.meshes.writer import write_mesh
    from nmaptool.io.pictures.heights import write_height

    with pytest.raises(UsageError, match=r"a\.stl: ends in \.stl; heights are written as \.exr, \.tif"):
        write_height(relief.height, tmp_path / "a.stl", {})
    with pytest.raises(UsageError, match=r"a\.npy: ends in \.npy; meshes are written as \.stl, \.ply"):
        write_mesh(nm.surface_mesh(relief.height), tmp_path / "a.npy")
