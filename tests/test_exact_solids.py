"""Solids of plates with an exact outline: its area, its volume, a manifold on every outline."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree
from solid_cases import PLATE, check_solid, circle, crossings, options, plate, random_options, random_plate

import nmaptool as nm
from nmaptool.types.contours import ring_area

BACKS = [{"base": "2mm"}, {"base": "2mm", "hollow": "0.6mm"}, {"shell": "0.8mm"}]


def downward_area(solid):
    """Area of the triangles that face down, seen from above: that of the back."""
    corners = solid.to_mesh().vertices[solid.to_mesh().faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] / 2
    walls = np.ptp(corners[..., 2], axis=1) > 0
    return -normals[(normals < 0) & ~walls].sum()


def ellipse(a, b, corners):
    return circle(0, 0, 1, corners) * (a, b) + (5.03, 5.04)


def rounded(width, depth, radius, corners):
    """A rectangle with rounded corners; each corner has ``corners`` points."""
    angle = np.linspace(0, np.pi / 2, corners)
    arc = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    ends = [(width - radius, depth - radius), (radius, depth - radius), (radius, radius), (width - radius, radius)]
    turns = [np.array([[np.cos(t), np.sin(t)], [-np.sin(t), np.cos(t)]]) for t in np.arange(4) * np.pi / 2]
    arcs = [arc @ turn + end for turn, end in zip(turns, ends, strict=True)]
    return np.concatenate(arcs) + np.array([0.73, 0.61])


ANALYTIC = {
    # ring and the area of its true curve; n corners on an arc lose a share of about (2 pi / n)^2 / 6
    "circle": (circle(5.03, 5.04, 4.2, 700), np.pi * 4.2**2),
    "ellipse": (ellipse(4.4, 2.9, 900), np.pi * 4.4 * 2.9),
    "rounded": (rounded(8.5, 7.2, 1.5, 200), 8.5 * 7.2 - (4 - np.pi) * 1.5**2),
}


@pytest.mark.parametrize("name", ANALYTIC)
def test_round_plates_have_the_area_and_the_volume_of_their_curves(name):
    ring, area = ANALYTIC[name]
    solid = nm.solid(plate([ring], 1.0, 100, 100), options(base="2mm"))
    check_solid(solid)
    assert downward_area(solid) == pytest.approx(ring_area(ring), rel=1e-12)
    assert solid.volume_mm3 == pytest.approx(3 * ring_area(ring), rel=1e-12)
    assert solid.volume_mm3 == pytest.approx(3 * area, rel=2e-5)
    assert solid.facts["area_mm2"] == pytest.approx(area, rel=2e-5)
    wanted = [[*ring.min(axis=0), -2], [*ring.max(axis=0), 1]]
    assert solid.bounds_mm.tolist() == wanted


def test_the_corners_of_the_rings_are_vertices_of_front_and_back():
    rings = [circle(5.03, 5.04, 4.2, 61), circle(5.5, 6.1, 1.3, 17, is_hole=True)]
    vertices = nm.solid(plate(rings, 1.0, 100, 100), options(base="2mm")).to_mesh().vertices
    for z in (1.0, -2.0):
        found = {tuple(xy) for xy in vertices[vertices[:, 2] == z, :2]}
        assert {tuple(xy) for ring in rings for xy in ring} <= found
    # the back has no others
    assert np.count_nonzero(vertices[:, 2] == -2.0) == 61 + 17


def test_a_flat_plate_is_perfectly_flat():
    rings = [circle(5.03, 5.04, 4.2, 61), circle(5.5, 6.1, 1.3, 17, is_hole=True)]
    vertices = nm.solid(plate(rings, 0.1, 100, 100), options(base="2mm")).to_mesh().vertices
    assert set(vertices[:, 2]) == {0.1, -2.0}


def test_a_plane_stays_a_plane_up_to_the_outline():
    ring = circle(5.03, 5.04, 4.2, 61)
    solid = nm.solid(plate([ring], lambda x, y: 0.3 * x - 0.2 * y, 100, 100), options())
    assert not solid.is_closed
    vertices = solid.to_mesh().vertices
    assert vertices[:, 2] == pytest.approx(0.3 * vertices[:, 0] - 0.2 * vertices[:, 1], abs=1e-12)


def test_a_cone_and_a_dome_have_their_volumes():
    x0, y0, radius = 5.03, 5.04, 4.2
    ring = circle(x0, y0, radius, 900)
    cone = nm.solid(
        plate([ring], lambda x, y: 2 * (radius - np.hypot(x - x0, y - y0)), 200, 200, 0.05), options(base="1mm")
    )
    assert cone.volume_mm3 == pytest.approx(np.pi * radius**2 * (1 + 2 * radius / 3), rel=2e-4)
    cap = 9.0**2 - radius**2

    def dome(x, y):
        return np.sqrt(9.0**2 - (x - x0) ** 2 - (y - y0) ** 2)

    below = 2 * np.pi / 3 * (9.0**3 - cap**1.5)
    solid = nm.solid(plate([ring], dome, 200, 200, 0.05), options(base="1mm"))
    assert solid.volume_mm3 - np.pi * radius**2 == pytest.approx(below, rel=5e-5)


def test_there_is_no_comb_along_the_outline_of_a_dome():
    x0, y0, radius = 10.03, 10.04, 9.0

    def dome(x, y):
        return np.sqrt(15.0**2 - (x - x0) ** 2 - (y - y0) ** 2)

    mesh = nm.solid(plate([circle(x0, y0, radius, 566)], dome, 200, 200), options()).to_mesh()
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    middle = corners.mean(axis=1) - (x0, y0, 0)
    true = middle / np.linalg.norm(middle, axis=1)[:, None]
    off = np.degrees(np.arccos(np.clip((normals * true).sum(axis=1), -1, 1)))
    along = np.hypot(*middle[:, :2].T) > radius - 0.2
    assert np.count_nonzero(along) > 1000
    # neighbouring pixels differ by 0.4 degrees
    assert off[along].max() < 0.4
    assert np.median(off[along]) < 0.1


@pytest.mark.parametrize("back", BACKS, ids=str)
def test_holes_of_all_kinds_give_a_manifold(back):
    holes = [circle(x, y, r, n, is_hole=True) for x, y, r, n in ((3, 3, 1.1, 30), (7, 3, 0.03, 8), (6.5, 6.5, 1.9, 4))]
    rings = [circle(5.03, 5.04, 4.9, 300), *holes]
    solid = nm.solid(plate(rings, lambda x, y: 0.1 * np.sin(x), 100, 100), options(**back))
    check_solid(solid)
    assert len(solid.bodies) == 1
    assert solid.facts["pieces"] == 1


HARD_OUTLINES = {
    "star": [
        np.array(
            [
                (5 + r * np.sin(t), 5 + r * np.cos(t))
                for t, r in zip(-np.arange(14) * np.pi / 7, [4.8, 1] * 7, strict=True)
            ]
        )
    ],
    "bridge thinner than a pixel": [
        np.array(
            [
                (1, 1),
                (4, 1),
                (4, 4.98),
                (6, 4.98),
                (6, 1),
                (9, 1),
                (9, 9),
                (6, 9),
                (6, 5.03),
                (4, 5.03),
                (4, 9),
                (1, 9),
            ],
            float,
        )
    ],
    "smaller than four pixels": [circle(5.03, 5.01, 0.13, 12)],
    "within one pixel": [circle(5.05, 5.05, 0.03, 5)],
    "needle": [np.array([(1, 1), (9, 5), (1, 1.3)], float)],
    "points on one line": [
        np.array([(1, 1), (2, 1), (2.5, 1), (9, 1), (9, 3), (9, 7), (9, 9), (1, 9), (1, 8.9)], float)
    ],
    "on the lines of the grid": [np.array([(1, 1), (9, 1), (9, 9), (1, 9)], float)],
    "the whole picture": [np.array([(0, 0), (10, 0), (10, 10), (0, 10)], float)],
    "hole near the edge": [circle(5, 5, 4.5, 200), circle(5, 8, 1.49, 90, is_hole=True)],
}


@pytest.mark.parametrize("back", BACKS, ids=str)
@pytest.mark.parametrize("name", HARD_OUTLINES)
def test_every_hard_outline_gives_a_manifold_with_its_area(name, back):
    rings = HARD_OUTLINES[name]
    height = plate(rings, lambda x, y: 0.3 * np.sin(2 * x) * np.cos(3 * y), 100, 100)
    solid = nm.solid(height, options(**back))
    check_solid(solid)
    mesh = solid.to_mesh()
    corners = mesh.vertices[mesh.faces]
    upward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] / 2
    assert upward[upward > 1e-12].sum() == pytest.approx(sum(ring_area(ring) for ring in rings), rel=1e-9)


def test_random_plates_give_manifold_solids(trials):
    for seed in range(trials(300)):
        check_solid(nm.solid(random_plate(seed), random_options(seed)))


def test_no_triangles_of_a_plate_cross(trials):
    checked = 0
    for seed in range(trials(300)):
        height = random_plate(seed)
        if 0 < height.domain.sum() < 80:
            mesh = nm.solid(height, random_options(seed)).to_mesh()
            assert crossings(mesh.vertices, mesh.faces) == 0, seed
            checked += 1
    assert checked >= trials(300) // 10


def test_a_plate_that_is_moved_with_its_grid_stays_the_same():
    rings = [circle(5.03, 5.04, 4.2, 61), circle(5.5, 6.1, 1.3, 17, is_hole=True)]

    def z(x, y):
        return 0.1 * np.sin(x) * y

    first = nm.solid(plate(rings, z, 100, 100), options(base="2mm"))
    by = np.array([1.6, 3.2])  # 16 and 32 px
    moved = plate([ring + by for ring in rings], lambda x, y: z(x - by[0], y - by[1]), 140, 120)
    second = nm.solid(moved, options(base="2mm"))
    assert second.volume_mm3 == pytest.approx(first.volume_mm3, rel=1e-12)
    assert second.face_count == first.face_count
    assert second.bounds_mm - first.bounds_mm == pytest.approx(np.array([[1.6, 3.2, 0]] * 2), abs=1e-12)


def test_a_hollow_plate_keeps_its_walls_along_the_outline():
    x0, y0, radius = 5.03, 5.04, 4.5
    rings = [circle(x0, y0, radius, 400), circle(x0, y0, 1.0, 90, is_hole=True)]
    full = nm.solid(plate(rings, 2.0, 200, 200, 0.05), options(base="2mm"))
    hollow = nm.solid(plate(rings, 2.0, 200, 200, 0.05), options(base="2mm", hollow="0.8mm"))
    check_solid(hollow)
    assert hollow.bounds_mm.tolist() == full.bounds_mm.tolist()
    assert full.volume_mm3 - hollow.volume_mm3 == pytest.approx(hollow.facts["hollowed_mm3"], rel=1e-9)
    pocket = hollow.to_mesh()
    inner = pocket.vertices[(pocket.vertices[:, 2] > -2) & (pocket.vertices[:, 2] < 2)]
    away = np.hypot(inner[:, 0] - x0, inner[:, 1] - y0)
    assert away.max() < radius - 0.8
    assert away.min() > 1.0 + 0.8
    assert inner[:, 2] == pytest.approx(2 - 0.8)
    # and the walls are at most three pixels thicker
    assert away.max() > radius - 0.8 - 0.15
    assert away.min() < 1.0 + 0.8 + 0.15


def test_a_shell_is_as_thick_as_asked_for_up_to_the_outline():
    x0, y0 = 5.03, 5.04

    def dome(x, y):
        return np.sqrt(8.0**2 - (x - x0) ** 2 - (y - y0) ** 2)

    solid = nm.solid(plate([circle(x0, y0, 4.2, 300)], dome, 100, 100), options(shell="1.2mm"))
    check_solid(solid)
    front = nm.solid(plate([circle(x0, y0, 4.2, 300)], dome, 100, 100), options()).to_mesh().vertices
    vertices = solid.to_mesh().vertices
    back = vertices[len(front) :]
    away = cKDTree(front).query(back)[0]
    assert away.min() > 1.2 - 0.02
    assert away.max() < 1.2 * 1.25


def test_the_base_is_measured_from_the_lowest_point_where_there_is_no_plate():
    height = plate([circle(5.03, 5.04, 4.2, 300)], lambda x, y: 3 + 0.1 * x, 100, 100)
    report = type("Report", (), {"options": nm.ReliefOptions(background="free")})()
    for given, lowest in ((PLATE, -2.0), (report, 3 + 0.1 * (5.03 - 4.2) - 2)):
        relief = nm.Relief(height, height.domain, given)
        assert nm.solid(relief, options(base="2mm")).bounds_mm[0, 2] == pytest.approx(lowest, abs=1e-9)


def test_heights_along_the_outline_stay_within_those_of_the_domain():
    # beyond the outline the heights rise on
    height = plate([circle(5.03, 5.04, 4.2, 300)], lambda x, y: np.hypot(x - 5.03, y - 5.04) ** 4, 100, 100)
    low, high = height.range_mm
    bounds = nm.solid(height, options()).bounds_mm
    assert low <= bounds[0, 2]
    assert bounds[1, 2] <= high
