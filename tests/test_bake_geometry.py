"""Layers on the original and on the updated geometry (paper, Fig. 10)."""

import numpy as np
import pytest
from bake_cases import plate_mesh
from mesh_cases import angles, sphere

import nmaptool as nm
from nmaptool.core.vectors import unit


def knob():
    ball = nm.clean_mesh(sphere(24))[0]
    x, y, _ = ball.vertices.T
    return nm.Mesh(ball.vertices * (1 + 0.08 * np.cos(16 * x) * np.cos(14 * y))[:, None], ball.faces)


def baked(mesh, **changes):
    return nm.bake(mesh, nm.BakeOptions(size="120x100", renderer="numpy", supersample=1, **changes))


@pytest.mark.parametrize("mesh", [plate_mesh(), knob()], ids=["plate", "knob"])
def test_the_original_geometry_shows_the_split_bit_for_bit(mesh):
    layers = baked(mesh)
    split = nm.decompose_normals(mesh)
    seen = layers.faces >= 0
    face = layers.faces[seen]
    assert layers.report.options["geometry"] == "original"
    for drawn, field in ((layers.original, split.normals), (layers.base, split.base)):
        # the front view has the mesh's own axes; normals that face away are flipped to the viewer
        towards = np.where(split.normals[face][:, 2:] < 0, -1.0, 1.0)
        expected = unit((field[face].astype(np.float32) * towards).astype(np.float32))
        np.testing.assert_allclose(drawn.normals[seen], expected, atol=1e-6)
    same = baked(mesh, geometry="original")
    for name in ("original", "base", "detail"):
        assert np.array_equal(getattr(layers, name).normals, getattr(same, name).normals)
    assert np.array_equal(layers.depth_mm, same.depth_mm)


def test_the_updated_geometry_shows_the_rebuilt_mesh_in_the_same_frame():
    mesh = knob()
    original, updated = baked(mesh), baked(mesh, geometry="updated")
    assert updated.report.camera == original.report.camera
    assert updated.report.options["geometry"] == "updated"
    rebuilt = nm.reconstruct(mesh, nm.decompose_normals(mesh).base).mesh
    seen = updated.faces >= 0
    own = rebuilt.geometry.normals[updated.faces[seen]]
    assert angles(updated.base.normals[seen], own).max() < 0.01
    # the bumps no longer show in the outline
    radius = [np.hypot(*(np.argwhere(c.coverage > 0) - [49.5, 59.5]).T).max() for c in (original, updated)]
    assert radius[1] < radius[0] - 0.5
    assert not np.array_equal(original.coverage, updated.coverage)
    # the base of the updated mesh belongs to a surface; that of the original is only a field of normals
    assert updated.report.curl["base"] < original.report.curl["base"]


def test_the_updated_geometry_takes_smooth_shading_and_several_views():
    options = nm.BakeOptions(
        view="front,left", size="60x50", renderer="numpy", supersample=1, shading="smooth", geometry="updated"
    )
    sets = nm.bake_views(knob(), options)
    assert [layers.report.view for layers in sets] == ["front", "left"]
    for layers in sets:
        np.testing.assert_allclose(np.linalg.norm(layers.base.normals, axis=-1), 1, atol=1e-5)
