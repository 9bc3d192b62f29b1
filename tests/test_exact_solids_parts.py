"""The parts of plates with an exact outline: triangles of polygons, inner pixels, points of outlines, walls."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import Delaunay, cKDTree
from solid_cases import circle, plate, random_plate

import nmaptool as nm
from nmaptool.core.grid import touching_corners, touching_vertices
from nmaptool.solids.exact.flat_rim import bent_nearby, without_flat_rim
from nmaptool.solids.exact.inner import inner_mask, inside_of, vertices_between
from nmaptool.solids.exact.plate_walls import walls_to_corners
from nmaptool.solids.exact.rings import outline_points
from nmaptool.solids.exact.sampling import heights_at
from nmaptool.solids.exact.triangulate import triangulated
from nmaptool.types.contours import ring_area


def areas(points, faces):
    a, b, c = np.moveaxis(points[faces], 1, 0)
    return ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2


def sides(faces):
    return {(a, b) for face in faces.tolist() for a, b in zip(face, face[1:] + face[:1], strict=True)}


@pytest.mark.parametrize("inside", [None, np.array([[40.0, 50.0], [60.0, 50.0], [50.0, 61.0], [50.0, 62.0]])])
def test_triangles_of_a_polygon_use_every_corner_once_around(inside):
    rings = [circle(50, 50, 42, 700), circle(50, 50, 7, 31, is_hole=True), circle(70, 70, 5, 4, is_hole=True)]
    faces = triangulated(rings, inside)
    points = np.concatenate(rings if inside is None else [*rings, inside])
    assert (areas(points, faces) > 0).all()
    assert areas(points, faces).sum() == pytest.approx(sum(ring_area(ring) for ring in rings), rel=1e-13)
    assert set(faces.ravel()) == set(range(len(points)))
    single = {(a, b) for a, b in sides(faces) if (b, a) not in sides(faces)}
    starts = np.cumsum([0, *(len(ring) for ring in rings)])
    wanted = {(s + i, s + (i + 1) % len(r)) for s, r in zip(starts, rings, strict=False) for i in range(len(r))}
    assert single == wanted


def test_triangles_with_points_inside_are_delaunay():
    ring = np.array([(0.0, 0.0), (9.5, 0.0), (9.5, 7.5), (0.0, 7.5)])
    rng = np.random.default_rng(4)
    grid = np.stack(np.meshgrid(np.arange(1, 9), np.arange(1, 7)), axis=-1).reshape(-1, 2)
    inside = grid[rng.choice(len(grid), 9, replace=False)].astype(float)
    points = np.concatenate([ring, inside])
    ours = np.sort(np.linalg.norm(points[triangulated([ring], inside)] - points.mean(axis=0), axis=2).sum(axis=1))
    theirs = Delaunay(points).simplices
    smallest = {}
    for name, faces in (("ours", triangulated([ring], inside)), ("theirs", theirs)):
        edges = points[faces] - points[np.roll(faces, 1, axis=1)]
        cosines = -(edges * np.roll(edges, -1, axis=1)).sum(axis=2)
        lengths = np.linalg.norm(edges, axis=2)
        smallest[name] = np.arccos((cosines / lengths / np.roll(lengths, -1, axis=1)).clip(-1, 1)).min()
    assert len(ours) == len(theirs)
    assert smallest["ours"] == pytest.approx(smallest["theirs"], abs=1e-9)


def test_points_on_one_line_make_no_flat_triangles():
    steps = np.linspace(0, 1, 50, endpoint=False)[:, None]
    corners = np.array([(0.3, 0.2), (9.1, 3.3), (7.0, 9.4), (-1.0, 6.0)])
    ring = np.concatenate([a + steps * (b - a) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)])
    faces = triangulated([ring])
    assert len(faces) == len(ring) - 2
    assert areas(ring, faces).min() > 1e-6


def in_px(height):
    return [ring / height.pitch_mm * (1, -1) + (0, height.frame.rows) for ring in height.outline.rings]


def test_inner_pixels_keep_their_distance_and_touch_at_sides(trials):
    for seed in range(trials(300)):
        height = random_plate(seed)
        rings, shape = in_px(height), height.frame.shape
        inner = inner_mask(rings, shape)
        assert np.array_equal(inside_of(rings, shape), height.domain)
        assert not (inner & ~height.domain).any()
        assert not any(each.any() for each in touching_corners(inner))
        between = vertices_between(rings, inner)
        assert not (between & touching_vertices(inner)).any()
        row, col = np.nonzero(touching_vertices(inner) | between)
        if len(row):
            ends = [(ring, np.roll(ring, -1, axis=0)) for ring in rings]
            along = np.concatenate([(a + (b - a) * t) for a, b in ends for t in np.linspace(0, 1, 400)])
            assert cKDTree(along).query(np.column_stack([col, row]))[0].min() >= 0.25


def test_edges_have_points_at_most_a_pixel_apart():
    height = plate([np.array([(1.0, 1.0), (8.3, 1.0), (8.3, 1.04), (1.0, 9.0)])], 0.0, 100, 100)
    points = outline_points(height.outline, height)
    steps = np.hypot(*(points.xy_mm[points.after] - points.xy_mm).T)
    assert steps.max() <= 0.1
    assert np.bincount(points.segment).tolist() == [128, 1, 128, 128]
    assert points.xy_mm[points.is_corner].tolist() == height.outline.rings[0].tolist()


def test_walls_do_not_overlap_where_heights_change_fast():
    ring = np.array([(1.0, 1.0), (9.0, 1.0), (9.0, 9.0), (1.0, 9.0)])
    height = plate([ring], 0.0, 20, 20, 0.5)
    points = outline_points(height.outline, height)
    top = 0.1 + 5 * np.random.default_rng(1).random(len(points.xy_mm))
    faces = walls_to_corners(points, top, 0.0, 0.5)
    xyz = np.concatenate([np.column_stack([points.xy_mm, top]), np.column_stack([ring, np.zeros(4)])])
    assert len(faces) == len(top) + 4
    a, b, c = np.moveaxis(xyz[faces], 1, 0)
    normals = np.cross(b - a, c - a)
    outward = np.array([(0, -1, 0), (1, 0, 0), (0, 1, 0), (-1, 0, 0)], float)
    of_face = np.append(points.segment, [-1] * 4)[faces.min(axis=1)]
    sign = np.einsum("nk,nwk->nw", normals, np.broadcast_to(outward, (len(faces), 4, 3)))
    assert (sign.max(axis=1) > 0).all()
    assert len(np.unique(of_face[of_face >= 0])) == 4
    heights = np.append(top, top[0])
    along = [np.append(top[points.segment == side], top[points.segment == (side + 1) % 4][0]) for side in range(4)]
    wanted = sum((each[1:] + each[:-1]).sum() / 2 * 0.5 for each in along)
    assert np.linalg.norm(normals, axis=1).sum() / 2 == pytest.approx(wanted, rel=1e-12)
    assert heights.min() > 0


def test_heights_between_vertices_are_bilinear():
    z_mm = np.array([[0.0, 1.0], [2.0, 5.0]])
    found = heights_at(z_mm, np.array([(0.0, 1.0), (1.0, 0.0), (0.5, 0.5), (0.25, 1.0), (-3.0, 9.0)]), 1.0)
    assert found.tolist() == [0.0, 5.0, 2.0, 0.25, 0.0]


def test_flat_blocks_at_the_outline_leave_the_pixels():
    z_mm = np.zeros((65, 65))
    z_mm[:, 48:] = np.arange(17) ** 2
    height = plate([circle(3.2, 3.2, 3.0, 200)], z_mm, 64, 64)
    inner = inner_mask(in_px(height), (64, 64))
    over = np.ones((64, 64), bool)
    kept = without_flat_rim(inner, bent_nearby([z_mm], over))
    assert not (kept & ~inner).any()
    assert np.array_equal(kept[:, 48:], inner[:, 48:])
    blocks = inner[:, :40].reshape(8, 8, 5, 8).all(axis=(1, 3))
    assert np.array_equal(kept[:, :40], np.repeat(np.repeat(blocks, 8, axis=0), 8, axis=1))
    assert isinstance(nm.solid(height), nm.Solid)
