"""The training meshes: sound, reproducible from the seed, and filtered well with their parameters."""

import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import nmaptool as nm

sys.path.insert(0, str(Path(__file__).parents[1] / "samples"))
sys.path.insert(0, str(Path(__file__).parents[1] / "samples" / "training"))

from catalogue import TRAINING
from catalogue_more import MORE
from held_out import HELD_OUT
from meshes import made
from surface import Surface, angle_deg, neighbours, smooth_step

del sys.path[:2]

# a few of each kind keep the test quick; choose_parameters covers all of them
QUICK = (
    *("box bricks", "letter fractal", "crystal chased", "small box bosses", "mask pores", "pebble fractal"),
    *("cloth woven", "gear", "steps", "cross scales", "crystal"),
    *("pyramid stones", "ring honeycomb", "bars"),
)
ENTRIES = {entry.name: entry for entry in (*TRAINING, *MORE, *HELD_OUT)}


@pytest.fixture(scope="module")
def quick():
    return {mesh.name: mesh for name in QUICK for mesh in made(ENTRIES[name], 3)}


@cache
def base_of(mesh):
    options = nm.FilterOptions(filter="grnf", sigma_s=mesh.sigma_s, sigma_r=mesh.sigma_r, iterations=mesh.iterations)
    base = nm.decompose_normals(nm.Mesh(mesh.vertices, mesh.faces), options).base
    return base / np.linalg.norm(base, axis=1, keepdims=True)


def off(mesh, normals):
    """Area-weighted mean angle to the normals of the form without ornament."""
    areas = nm.Mesh(mesh.vertices, mesh.faces).geometry.areas
    return np.average(angle_deg(normals, mesh.clean_normals), weights=areas)


def original(mesh):
    return Surface(mesh.vertices, mesh.faces).face_normals


def test_there_are_enough_of_every_kind():
    names = [entry.name for entry in (*TRAINING, *MORE, *HELD_OUT)]
    finer = sum(entry.finer is not None for entry in TRAINING)
    assert len(TRAINING) + finer >= 28
    assert finer >= 2
    assert len(MORE) >= 45
    assert sum(entry.finer is not None for entry in MORE) >= 3
    assert sum(entry.group == "plain" for entry in MORE) >= 6
    assert len(HELD_OUT) >= 8
    assert len(set(names)) == len(names)
    assert {entry.group for entry in TRAINING} == {"creased", "organic", "ornament", "plain"}
    assert sum(entry.noise > 0 for entry in TRAINING) >= 3
    assert sum(entry.where is not None for entry in TRAINING) >= 5
    assert all((entry.ornament is None and not entry.noise) == (entry.group == "plain") for entry in ENTRIES.values())


def test_meshes_are_sound(quick):
    for mesh in quick.values():
        assert 3000 <= len(mesh.faces) <= 25_000, mesh.name
        given = nm.Mesh(mesh.vertices, mesh.faces)
        _, kept, findings = nm.clean_mesh(given)
        assert len(kept) == len(mesh.faces)
        dropped = {k: v for k, v in vars(findings).items() if k not in ("vertices", "faces") and v}
        assert not dropped, mesh.name
        turned = angle_deg(original(mesh), mesh.clean_normals)
        assert turned.max() < 90, mesh.name
        if "cloth" not in mesh.name:
            assert len(neighbours(mesh.faces)[0]) * 2 == 3 * len(mesh.faces), mesh.name
            surface = Surface(mesh.vertices, mesh.faces)
            assert (mesh.vertices[mesh.faces[:, 0]] * surface.crosses).sum() > 0, mesh.name  # normals point outwards


def test_a_seed_gives_the_same_mesh_regardless_of_earlier_meshes(quick):
    for name in ("letter fractal", "pebble fractal", "cross scales"):
        (again,), (other,) = made(ENTRIES[name], 3), made(ENTRIES[name], 4)
        np.testing.assert_array_equal(again.vertices, quick[name].vertices)
        np.testing.assert_array_equal(again.faces, quick[name].faces)
        assert not np.array_equal(other.vertices, again.vertices)


def test_ornament_is_removed_and_plain_forms_are_kept(quick):
    for mesh in (quick[name] for name in QUICK):  # the finer versions are slow
        before, after = off(mesh, original(mesh)), off(mesh, base_of(mesh))
        if mesh.group == "plain":
            assert before == 0
            assert after < 1.0, mesh.name
        else:
            assert before > 5, mesh.name
            assert after < before / 2, f"{mesh.name}: {before:.1f} to {after:.1f}"


@pytest.mark.parametrize("name", ["box bricks", "gear", "crystal chased"])
def test_creases_are_kept(quick, name):
    mesh = quick[name]
    pairs, _ = neighbours(mesh.faces)
    true = angle_deg(*(mesh.clean_normals[pairs[:, k]] for k in (0, 1)))
    kept = angle_deg(*(base_of(mesh)[pairs[:, k]] for k in (0, 1)))
    creased = true > 30
    assert creased.sum() > 50
    assert np.median(kept[creased] / true[creased]) > 0.75


def test_a_finer_version_is_the_same_surface(quick):
    one, two = quick["small box bosses"], quick["small box bosses+"]
    assert len(two.faces) == 4 * len(one.faces)
    np.testing.assert_allclose(original(two).reshape(-1, 4, 3), np.repeat(original(one)[:, None], 4, 1), atol=1e-9)
    assert two.sigma_s == 2 * one.sigma_s


def test_slopes_match_the_height():
    surface = Surface(np.array([(0.0, 0, 0), (2, 0, 0), (0, 3, 0)]), np.array([(0, 1, 2)], np.int32))
    assert surface.slopes(np.array([0.0, 1.0, 0.0])) == pytest.approx(0.5)
    assert smooth_step(np.array([0.5]), 0, 1) == pytest.approx(0.5)
