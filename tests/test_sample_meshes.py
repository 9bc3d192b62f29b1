"""The sample meshes: small, sound, and reproducible by their script."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

SAMPLES = Path(__file__).parents[1] / "samples"
BODIES = {"gate": 72, "portrait": 1, "rings": 3, "vase": 1}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("meshes")
    subprocess.run([sys.executable, str(SAMPLES / "make_meshes.py"), str(folder)], check=True, capture_output=True)
    return folder


def load(folder, name):
    return trimesh.load(folder / f"{name}.ply", process=False)


def test_meshes_are_small_and_complete(made):
    shipped = sorted(SAMPLES.glob("*.ply"))
    assert [path.stem for path in shipped] == sorted(BODIES) == sorted(path.stem for path in made.iterdir())
    assert sum(path.stat().st_size for path in shipped) <= 1_150_000


@pytest.mark.parametrize("name", BODIES)
def test_the_script_makes_the_shipped_meshes(made, name):
    again, kept = load(made, name), load(SAMPLES, name)
    np.testing.assert_array_equal(again.faces, kept.faces)
    # sines may differ in their last bit between machines
    assert np.abs(again.vertices - kept.vertices).max() < 1e-4 * kept.extents.max()


@pytest.mark.parametrize("name", BODIES)
def test_meshes_are_sound(name):
    mesh = load(SAMPLES, name)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume > 0  # normals point outwards
    assert len(np.unique(mesh.faces)) == len(mesh.vertices)
    assert mesh.body_count == BODIES[name]
    assert all(body.euler_number == (0 if name == "rings" else 2) for body in mesh.split())
    longest = mesh.edges_unique_length[mesh.faces_unique_edges].max(axis=1)
    assert (2 * mesh.area_faces / longest).min() > 0.05  # mm: no face is a sliver or a point
    assert 60 < mesh.extents.max() < 100  # mm


def test_rings_clear_each_other():
    bodies = load(SAMPLES, "rings").split()
    for one in range(3):
        gap, _ = cKDTree(bodies[one].vertices).query(bodies[one - 1].vertices)
        assert 0.5 < gap.min() < 3


def test_the_vase_wall_has_no_holes():
    mesh = load(SAMPLES, "vase")
    upward = mesh.vertices[mesh.vertices[:, 1] > 60]
    inside = mesh.vertex_normals[mesh.vertices[:, 1] > 60]
    radial = upward[:, [0, 2]] / np.linalg.norm(upward[:, [0, 2]], axis=1, keepdims=True)
    faces_in = (radial * inside[:, [0, 2]]).sum(axis=1) < -0.3
    radius, height = np.hypot(upward[:, 0], upward[:, 2]), upward[:, 1]
    order = np.argsort(height[faces_in])
    inner = np.interp(height, height[faces_in][order], radius[faces_in][order])
    outer = ~faces_in & (height < 88)
    assert (radius - inner)[outer].min() > 0.5
