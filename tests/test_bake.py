"""Layers of known meshes: each pixel shows the true surface."""

import dataclasses

import numpy as np
import pytest
from mesh_cases import angles, divided, joined, sheet, sphere

import nmaptool as nm
from nmaptool.core.vectors import mean_abs_curl, slopes, unit
from nmaptool.maps.detail import encode_detail
from nmaptool.meshes.clean import clean_mesh
from nmaptool.types.mesh import face_geometry

NUMPY = {"renderer": "numpy", "size": "120x100"}


def baked(mesh, filter=None, **options):
    return nm.bake(
        mesh, nm.BakeOptions(**{**NUMPY, **options}), nm.FilterOptions(**(filter or {"neighborhood": "ring"}))
    )


def at_pixels(layers, margin=0.04):
    """Eye-space x, y of the pixels for a mesh whose height (-1 to 1) fills the image."""
    rows, cols = layers.frame.shape
    per_px = layers.report.camera["unit_per_px"]
    y, x = np.mgrid[0:rows, 0:cols] + 0.5
    return (x - cols / 2) * per_px, (rows / 2 - y) * per_px


@pytest.mark.parametrize("renderer", ["numpy", "auto"])
def test_flat_shading_shows_the_face_normals(renderer):
    mesh = sphere(12)
    layers = baked(mesh, supersample=1, renderer=renderer)
    own = face_geometry(mesh).normals.astype(np.float32)
    seen = layers.coverage == 1
    shown = own[layers.faces[seen]]
    shown[shown[:, 2] < 0] *= -1
    assert np.abs(layers.original.normals[seen] - shown).max() < 2e-7  # float32 rounding
    assert np.array_equal(layers.original.normals[~seen], np.broadcast_to([0, 0, 1], ((~seen).sum(), 3)))


@pytest.mark.parametrize("renderer", ["numpy", "auto"])
def test_smooth_shading_of_a_sphere_is_analytic(renderer):
    layers = baked(sphere(158), supersample=1, shading="smooth", renderer=renderer, size="300x300")  # 200k faces
    assert layers.report.faces == 199_712
    x, y = at_pixels(layers)
    seen = (layers.coverage == 1) & (np.hypot(x, y) < 0.99)
    true = np.stack([x, y, np.sqrt((1 - x * x - y * y).clip(0))], axis=-1)
    assert angles(layers.original.normals[seen], true[seen]).max() < 0.2


@pytest.mark.parametrize("renderer", ["numpy", "auto"])
@pytest.mark.parametrize("fov", [0.0, 50.0])
def test_depth_of_a_plane_is_exact(renderer, fov):
    mesh = dataclasses.replace(sheet(lambda x, y: 0.4 * x - 0.7 * y, 12, 12), mm_per_unit=2.0)
    layers = baked(mesh, renderer=renderer, fov=fov)
    camera = layers.report.camera
    seen = layers.coverage == 1
    x, y = at_pixels(layers)
    tilt = 0.4 * x - 0.7 * y
    if fov:
        distance, center = camera["distance"], camera["center"]
        offset = 0.4 * center[0] - 0.7 * center[1] - center[2]
        depth = distance * (distance - offset) / (distance + tilt)  # where the viewing ray meets the tilted plane
    else:
        depth = mesh.vertices[:, 2].max() - tilt
    assert np.abs(layers.depth_mm / 2 - depth)[seen].max() < 1e-4 * 12
    assert (layers.depth_mm[layers.coverage == 0] == 0).all()


def test_depth_of_a_sphere_is_accurate():
    layers = baked(sphere(60, 3.0), size="200x200")
    x, y = at_pixels(layers)
    seen = (layers.coverage == 1) & (np.hypot(x, y) < 2.9)
    true = 3 - np.sqrt((9 - x * x - y * y).clip(0))
    assert np.abs(layers.depth_mm - true)[seen].max() < 0.005  # distance of the facets from the sphere
    assert layers.frame.pitch_mm == pytest.approx(6 / (200 - 16))


def test_normals_of_faces_seen_from_behind_are_flipped_to_the_viewer():
    front = sheet(lambda x, y: 0.3 * x + 0.1 * y * y, 10, 10)
    back = dataclasses.replace(front, faces=np.ascontiguousarray(front.faces[:, ::-1]))
    one, other = baked(front), baked(back)
    assert np.array_equal(one.original.normals, other.original.normals)
    assert np.allclose(one.base.normals, other.base.normals, atol=1e-6)
    assert (one.original.normals[..., 2] > 0).all()


@pytest.mark.parametrize("samples", [1, 2, 4])
def test_coverage_is_the_share_of_samples_that_hit(samples):
    layers = baked(sphere(40), supersample=samples, size="64x64")
    assert set(np.unique(layers.coverage)) <= set(np.arange(samples**2 + 1) / samples**2)
    area = layers.coverage.sum() / (np.pi * (32 - 0.04 * 64) ** 2)
    assert area == pytest.approx(1, abs=0.01)
    assert angles(layers.original.normals, unit(layers.original.normals)).max() < 1e-4


def test_supersampled_normals_are_the_mean_of_their_samples():
    mesh = sphere(9)
    one, four = baked(mesh, supersample=4), baked(mesh, supersample=1, size="480x400", margin="16px")
    four_by_four = four.original.normals.reshape(100, 4, 120, 4, 3)
    weight = four.coverage.reshape(100, 4, 120, 4, 1)
    mean = unit((four_by_four * weight).sum(axis=(1, 3)))
    one_margin = baked(mesh, supersample=4, margin="4px")
    assert angles(one_margin.original.normals, mean).max() < 0.01
    assert one.coverage.shape == one_margin.coverage.shape


def rnm(base, detail):
    t = base + np.array([0.0, 0, 1])
    u = detail * [-1.0, -1, 1]
    return unit(t * (t * u).sum(axis=-1, keepdims=True) / t[..., 2:] - u)


def knobbly(steps=40):
    mesh = sphere(steps)
    v = mesh.vertices
    bumps = 0.03 * np.sin(25 * v[:, :1]) * np.sin(25 * v[:, 1:2]) * np.sin(25 * v[:, 2:])
    return nm.Mesh(v * (1 + bumps), mesh.faces)


@pytest.mark.parametrize("shading", ["flat", "smooth"])
@pytest.mark.parametrize("filter", ["rnf", "grnf"])
def test_reoriented_blending_of_base_and_detail_gives_the_original(shading, filter):
    layers = baked(knobbly(), {"filter": filter}, shading=shading)
    seen = layers.coverage > 0
    back = rnm(layers.base.normals[seen], layers.detail.normals[seen])
    assert angles(back, layers.original.normals[seen]).max() < 0.01
    assert layers.report.detail_angle_deg > 3


def test_detail_is_exactly_flat_where_the_base_equals_the_original():
    layers = baked(knobbly(), {"filter": "grnf"}, supersample=1)
    same = (layers.base.normals == layers.original.normals).all(axis=-1)
    assert 0.2 < same[layers.coverage > 0].mean() < 0.98
    assert np.array_equal(layers.detail.normals[same], np.broadcast_to([0, 0, 1], (same.sum(), 3)))


def test_slopes_of_base_and_detail_add_up_to_the_original():
    layers = baked(knobbly(), detail_encoding="slope")
    inside = (layers.coverage > 0) & (layers.original.normals[..., 2] > 0.1) & (layers.base.normals[..., 2] > 0.1)
    maps = (layers.original, layers.base, layers.detail)
    (po, qo), (pb, qb), (pd, qd) = (slopes(m.normals[inside], 1e3) for m in maps)
    assert np.abs(pb + pd - po).max() < 1e-4
    assert np.abs(qb + qd - qo).max() < 1e-4


def test_difference_detail_is_original_minus_base():
    original, base = (unit(np.random.default_rng(k).normal(size=(50, 3)) + np.array([0, 0, 2])) for k in (1, 2))
    assert np.allclose(encode_detail(original, base, "difference"), unit(original - base + np.float32([0, 0, 1])))


def test_perspective_maps_are_those_of_a_height_field():
    """Their slopes integrate to distance * ln(depth), so their relief shows the object as the camera saw it."""
    layers = baked(sphere(120), shading="smooth", fov=70.0, size="200x200")
    seen = np.hypot(*at_pixels(layers)) < 0.9 * layers.coverage[100].sum() / 2 * layers.report.camera["unit_per_px"]
    z = -layers.report.camera["distance"] * np.log(np.where(layers.depth_mm > 0, layers.depth_mm, 1).astype(float))
    per_px = layers.report.camera["unit_per_px"]
    p, q = slopes(layers.original.normals, 1e3)
    inside = seen[1:-1, 1:-1] & seen[:-2, 1:-1] & seen[2:, 1:-1]
    dx, dy = (z[1:-1, 2:] - z[1:-1, :-2]) / (2 * per_px), (z[:-2, 1:-1] - z[2:, 1:-1]) / (2 * per_px)
    assert np.abs(p[1:-1, 1:-1] - dx)[inside].mean() < 0.02
    assert np.abs(q[1:-1, 1:-1] - dy)[inside].mean() < 0.02
    assert layers.original.normals[..., 2].min() >= 0  # nothing visible faces away
    assert mean_abs_curl(layers.original.normals, seen) < 0.005


def test_smooth_shading_keeps_creases():
    roof = sheet(lambda x, y: -np.abs(x), 10, 10)
    for crease, expected in ((60.0, 45.0), (170.0, None)):
        layers = baked(roof, shading="smooth", crease=crease, supersample=1)
        steep = angles(layers.original.normals[layers.coverage == 1], [0, 0, 1.0])
        if expected:
            assert np.allclose(steep, expected, atol=1e-3)
        else:
            assert steep.min() < 10


def test_views_share_one_filtering_and_rotating_the_mesh_equals_rotating_the_camera():
    mesh = joined(knobbly(20), sheet(lambda x, y: 0.2 * x, 4, 4, 0.7))
    front, left = nm.bake_views(mesh, nm.BakeOptions(**NUMPY, view="front,left"), nm.FilterOptions())
    turned = nm.Mesh(np.ascontiguousarray(mesh.vertices[:, [2, 1, 0]] * [1, 1, -1.0]), mesh.faces)
    again = nm.bake(turned, nm.BakeOptions(**NUMPY), nm.FilterOptions())
    assert (front.report.view, left.report.view) == ("front", "left")
    assert front.report.mixture is left.report.mixture
    assert angles(left.original.normals, again.original.normals).mean() < 0.01
    assert angles(left.base.normals, again.base.normals).mean() < 0.5  # the patches are placed differently
    with pytest.raises(nm.UsageError, match="`view='front,left'`: bake renders one view; use bake_views to"):
        nm.bake(mesh, nm.BakeOptions(view="front,left"))


def test_pitch_follows_units_and_width():
    mesh = sphere(10, 5.0)
    assert baked(mesh).frame.pitch_mm == pytest.approx(10 / (100 - 2 * 4.8))
    assert baked(dataclasses.replace(mesh, mm_per_unit=25.4)).frame.pitch_mm == pytest.approx(254 / (100 - 2 * 4.8))
    wide = baked(mesh, width="60mm")
    assert wide.frame.pitch_mm == pytest.approx(0.5)
    assert wide.report.pitch_from == "given"
    assert wide.depth_mm.max() == pytest.approx(0.5 / wide.report.camera["unit_per_px"] * 5, rel=0.05)
    assert baked(mesh, pitch="0.2mm").frame.pitch_mm == pytest.approx(0.2)


def test_sigma_s_in_mm_refers_to_the_given_width():
    """sigma_s in mm is measured on the mesh at the scale that `width` sets."""
    tiny = nm.Mesh(knobbly(16).vertices * 0.01, knobbly(16).faces)
    by_width = baked(tiny, {"sigma_s": "5mm"}, width="120mm")
    assert by_width.report.sigma_s_px == pytest.approx(5)
    by_share = baked(tiny, {"sigma_s": nm.length(f"{5 / (100 - 9.6) * 100}%")}, width="120mm")
    assert angles(by_width.base.normals, by_share.base.normals).max() < 0.2
    long = joined(sphere(6), sheet(lambda x, y: 0 * x, 8, 1))
    with pytest.raises(nm.UsageError, match="`sigma_s='5mm'`: the views differ in scale at `width='60mm'`"):
        nm.bake_views(long, nm.BakeOptions(**NUMPY, view="front,top", width="60mm"), nm.FilterOptions(sigma_s="5mm"))


def test_edges_so_long_that_forms_become_detail_give_a_warning():
    assert any("the edges are long: `sigma_s` is " in w for w in baked(sphere(8), {}).report.warnings)
    assert not any("edges are long" in w for w in baked(sphere(8), {"sigma_s": "2%"}).report.warnings)
    assert not any("edges are long" in w for w in baked(sphere(60), {}).report.warnings)


def test_dropped_faces_are_reported_and_faces_keep_their_numbers():
    mesh = sphere(8)
    bad = np.array([[0, 0, 1], [3, 3, 3], [5, 6, len(mesh.vertices)]], np.int32)
    vertices = np.vstack([mesh.vertices, [[np.nan, 0, 0], [9, 9, 9]]])
    dirty = nm.Mesh(vertices, np.vstack([bad, mesh.faces]).astype(np.int32))
    one, other = baked(mesh), baked(dirty)
    assert np.array_equal(one.original.normals, other.original.normals)
    assert np.array_equal(np.where(one.faces >= 0, one.faces + 3, -1), other.faces)
    found = other.report.findings
    assert (found.degenerate_faces, found.nonfinite_faces, found.unreferenced_vertices) == (2, 1, 1)
    assert any(w == "dropped 2 faces without area" for w in other.report.warnings)
    assert any(w == "dropped 1 face with a NaN or infinite vertex" for w in other.report.warnings)


def test_welding_connects_the_faces_for_the_filter():
    """A mesh whose faces share no vertices, as in an STL, gives the same base."""
    mesh = knobbly(16)
    apart = nm.Mesh(mesh.corners.reshape(-1, 3).copy(), np.arange(3 * len(mesh.faces), dtype=np.int32).reshape(-1, 3))
    assert np.array_equal(baked(mesh).base.normals, baked(apart).base.normals)
    assert clean_mesh(apart)[2].welded_vertices == len(apart.vertices) - len(clean_mesh(mesh)[0].vertices)
    assert len(divided(mesh).faces) == 4 * len(mesh.faces)


def test_faces_wound_at_random_give_the_same_maps():
    mesh = knobbly(16)
    faces = mesh.faces.copy()
    which = np.random.default_rng(2).random(len(faces)) < 0.4
    faces[which] = faces[which][:, ::-1]
    one, other = baked(mesh, {}), baked(nm.Mesh(mesh.vertices, faces), {})
    assert np.array_equal(one.original.normals, other.original.normals)
    assert angles(one.base.normals, other.base.normals).max() < 0.01


def test_identical_views_are_refused():
    assert len(nm.bake_views(sphere(6), nm.BakeOptions(**NUMPY, view="front,iso", azimuth=30.0))) == 2
    with pytest.raises(nm.UsageError, match="`view='front,left'`: `azimuth` and `elevation` override the angles of"):
        nm.BakeOptions(view="front,left", azimuth=10.0)


def test_a_mesh_out_of_view_is_an_error():
    with pytest.raises(nm.InputError, match="is not visible in the front view; choose another `view`, `pitch`"):
        baked(sphere(6), pitch="0.001mm", target="50,0,0")


def test_a_baked_sphere_gives_a_round_relief():
    layers = baked(sphere(60), shading="smooth", size="128x128")
    relief = nm.relief(layers.original, options=nm.ReliefOptions(beta=0.0, slope_cap=20.0))
    z = relief.height.at_pixels() / relief.height.pitch_mm * layers.report.camera["unit_per_px"]
    x, y = at_pixels(layers)
    inside = np.hypot(x, y) < 0.8
    true = np.sqrt((1 - x * x - y * y).clip(0))
    assert np.abs((z - z[64, 64]) - (true - true[64, 64]))[inside].max() < 0.02
