"""Parts of a relief: watertight, and together exactly the whole."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from part_cases import (
    PITCH_MM,
    along,
    area,
    cap,
    grid,
    height_of,
    plane,
    ramp_with_holes,
    random_counts,
    random_height,
    relief_of,
    triangles,
)
from solid_cases import check_solid, options

import nmaptool as nm
from nmaptool.solids.cutting.plan import surface_box

SURFACES = {"plane": plane, "cap": cap, "ramp with holes": ramp_with_holes}
BACKS = ({"base": "2mm"}, {"shell": "0.7mm"})


def parts_of(height, counts="3x2", origin="whole", solid=None):
    given = nm.PartOptions(parts=counts, part_origin=origin)
    return {(row, col): part for row, col, part in nm.parts(height, given, solid)}


def planned(height, counts):
    """The parts of the box around a surface."""
    options = nm.PartOptions(parts=counts)
    plan = nm.plan_parts(*height.frame.shape, PITCH_MM, options, within=surface_box(height.domain))
    return {(part.row, part.col): part for part in plan}


@pytest.mark.parametrize("back", BACKS, ids=str)
@pytest.mark.parametrize("counts", ["1x1", "3x2", "2x5"])
@pytest.mark.parametrize("name", SURFACES)
def test_parts_are_watertight_and_have_the_volume_and_the_surface_of_the_whole(name, counts, back):
    height, given = SURFACES[name](), options(**back)
    whole, parts = nm.solid(height, given), parts_of(height, counts, solid=given)
    for part in parts.values():
        check_solid(part)
    assert sum(part.volume_mm3 for part in parts.values()) == pytest.approx(whole.volume_mm3, rel=1e-12)
    assert area(parts.values()) == pytest.approx(area([whole]), rel=1e-12)
    assert triangles(parts.values()) == triangles([whole])


def test_the_parts_of_a_plane_have_its_analytic_volume():
    height = plane(30, 44)
    wide, tall = 44 * PITCH_MM, 30 * PITCH_MM
    parts = parts_of(height, "4x3", solid=options(base="2mm"))
    expected = wide * tall * (2 + 0.1 * wide / 2 + 0.05 * tall / 2)
    assert sum(part.volume_mm3 for part in parts.values()) == pytest.approx(expected, rel=1e-12)


def test_the_parts_of_a_cap_have_nearly_its_analytic_volume():
    x, y = grid(100, 100)
    x, y = x / 2, y / 2  # 12.5 mm
    z_mm = np.sqrt(144 - (x - 6.25) ** 2 - (y - 6.25) ** 2)
    height = nm.Height(z_mm, np.ones((100, 100), bool), nm.Frame(100, 100, pitch_mm=0.125))
    found = sum(part.volume_mm3 for part in parts_of(height, "3x3", solid=options(base="1mm")).values())
    nodes, weights = np.polynomial.legendre.leggauss(20)
    u, v = np.meshgrid(nodes * 6.25, nodes * 6.25)
    expected = 6.25**2 * float((np.outer(weights, weights) * (1 + np.sqrt(144 - u**2 - v**2))).sum())
    assert found == pytest.approx(expected, rel=5e-5)


@pytest.mark.parametrize("given", [*BACKS, {"base": "2mm", "hollow": "0.6mm"}, {"base": "2mm", "max_error": "0.05mm"}])
def test_neighbours_share_their_border_bit_by_bit(given):
    rng = np.random.default_rng(0)
    height = height_of(np.cumsum(rng.standard_normal((37, 47)), axis=0) * 0.02)
    parts = parts_of(height, "3x3", solid=options(**given))
    cols, rows = [46 * n // 3 for n in range(4)], [36 * n // 3 for n in range(4)]
    for row in range(3):
        for col in range(3):
            if col < 2:
                x = cols[col + 1] * PITCH_MM
                shared = along(parts[row, col], 0, x)
                assert len(shared) >= 2 * 13
                assert shared == along(parts[row, col + 1], 0, x)
            if row < 2:
                y = (36 - rows[row + 1]) * PITCH_MM
                shared = along(parts[row, col], 1, y)
                assert len(shared) >= 2 * 15
                assert shared == along(parts[row + 1, col], 1, y)


def test_the_back_of_all_parts_lies_below_the_lowest_point_of_the_whole():
    x, _ = grid(20, 40)
    for background, lowest in (("plane", -2.0), ("cut", -3.0), ("free", -3.0)):
        height, report = height_of(x - 1), SimpleNamespace(options=nm.ReliefOptions(background=background))
        relief = nm.Relief(height, height.domain, report)
        parts = parts_of(relief, "4x1", solid=options(base="2mm"))
        assert {float(part.bounds_mm[0, 2]) for part in parts.values()} == {lowest}


def test_random_reliefs_in_parts_are_their_solids(trials):
    backs = (
        {"base": "9mm"},
        {"shell": "0.35mm"},
        {},
        {"base": "9mm", "hollow": "0.3mm"},
        {"base": "9mm", "max_error": "0.05mm"},
    )
    for seed in range(trials(150)):
        height = random_height(seed)
        given = options(**backs[seed % len(backs)])
        counts = random_counts(seed, height)
        whole, parts = nm.solid(height, given), parts_of(height, counts, solid=given)
        if given.is_closed:
            for part in parts.values():
                check_solid(part)
        if given.max_error is None:
            assert triangles(parts.values()) == triangles([whole]), (seed, counts)
            if given.is_closed and given.hollow is None:
                assert sum(part.volume_mm3 for part in parts.values()) == pytest.approx(whole.volume_mm3, rel=1e-9)


def test_parts_that_hold_nothing_are_left_out():
    domain = np.zeros((20, 30), bool)
    domain[2:8, 3:9] = True
    domain[12:18, 21:28] = True
    parts = parts_of(height_of(np.ones((21, 31)), domain), "3x2", solid=options(base="1mm"))
    assert sorted(parts) == [(0, 0), (1, 2)]


def test_parts_at_their_own_origin_are_those_of_the_whole_moved():
    height, given = cap(), options(base="2mm")
    whole, own = (parts_of(height, "3x2", origin, given) for origin in ("whole", "own"))
    plan = planned(height, "3x2")
    for place, part in own.items():
        at = np.array([plan[place].left, 50 - plan[place].bottom, 0]) * PITCH_MM
        assert np.abs(part.to_mesh().vertices + at - whole[place].to_mesh().vertices).max() < 1e-12
        assert part.bounds_mm[0, :2].min() >= 0


def test_a_hollow_part_has_walls_of_its_own_where_it_is_cut():
    height, given = plane(40, 60), options(base="5mm", hollow="1mm")
    whole, parts = nm.solid(height, given), parts_of(height, "2x1", solid=given)
    total = sum(part.volume_mm3 for part in parts.values())
    assert total > whole.volume_mm3
    x = 30 * PITCH_MM
    for part in parts.values():  # no vertex of the pocket is nearer to the cut than the wall
        vertices = part.to_mesh().vertices
        pocket = vertices[(vertices[:, 2] > -5 + 1e-9) & (vertices[:, 2] < -1e-9)]
        assert np.abs(pocket[:, 0] - x).min() >= 1.0


def test_open_parts_join_to_the_open_surface():
    height = ramp_with_holes()
    parts = parts_of(height, "3x3")
    assert not any(part.is_closed for part in parts.values())
    assert triangles(parts.values()) == triangles([nm.solid(height)])


def test_thinned_parts_keep_within_the_error_and_every_vertex_between_parts():
    x, y = grid(64, 64)
    height = height_of(0.5 * np.sin(x) * np.cos(y))
    full, few = (parts_of(height, "2x2", solid=options(base="2mm", **more)) for more in ({}, {"max_error": "0.03mm"}))
    for place, part in few.items():
        check_solid(part)
        assert part.face_count < full[place].face_count / 2
        assert 0 < part.facts["max_error_mm"] <= 0.03
    middle = 32 * PITCH_MM
    for row in range(2):
        assert along(few[row, 0], 0, middle) == along(full[row, 1], 0, middle)
    limited = parts_of(height, "2x2", solid=options(base="2mm", triangles="2k"))
    assert all(part.face_count <= 2000 for part in limited.values())


def test_a_smooth_outline_does_not_leave_the_lines_between_parts():
    r, c = np.ogrid[:60, :60]
    coverage = np.clip(25.3 - np.hypot(r - 29.7, c - 29.2), 0, 1).astype(np.float32)
    mask = coverage >= 0.5
    height = height_of(np.full((61, 61), 1.5), mask)
    relief = relief_of(height, coverage)
    given = options(base="1mm")
    parts = parts_of(relief, "3x3", solid=given)
    plan = planned(height, "3x3")
    for (row, col), part in parts.items():
        check_solid(part)
        assert part.facts["outline"] == "smooth"
        box, (low, high) = plan[row, col], part.bounds_mm[:, :2]
        left, lower = box.left * PITCH_MM, (60 - box.bottom) * PITCH_MM
        right, upper = box.right * PITCH_MM, (60 - box.top) * PITCH_MM
        if col > 0:
            assert low[0] == left
        if col < 2:
            assert high[0] == right
        assert low[1] == lower if row < 2 else low[1] > lower - PITCH_MM
        assert high[1] == upper if row > 0 else high[1] < upper + PITCH_MM
        if col < 2 and (row, col + 1) in parts:
            x = right
            found, beyond = along(part, 0, x), along(parts[row, col + 1], 0, x)
            assert len(found & beyond) >= 10
            # where the outline crosses the line, only one of them may have a pixel
            ends = [np.hypot(px - 29.7 * 0.25, py - (60 - 30.2) * 0.25) for px, py, _ in found ^ beyond]
            assert all(abs(end - 25.3 * 0.25) < 2 * PITCH_MM for end in ends)
    whole = nm.solid(relief, given)
    assert sum(part.volume_mm3 for part in parts.values()) == pytest.approx(whole.volume_mm3, rel=2e-4)


def test_a_raised_motif_is_cut_with_its_walls():
    r, c = np.ogrid[:40, :40]
    raised = np.hypot(r - 19.5, c - 19.5) < 14
    x, _ = grid(40, 40)
    on = np.zeros((41, 41), bool)
    for down in (0, 1):
        for right in (0, 1):
            on[down : down + 40, right : right + 40] |= raised
    height = height_of(np.where(on, 1 + 0.1 * x, 0.0), None, raised)
    for given in (options(base="2mm"), options(shell="0.5mm"), options(base="2mm", max_error="0.02mm"), None):
        parts = parts_of(height, "3x3", solid=given)
        whole = nm.solid(height, given)
        assert len(parts) == 9
        if given is not None:
            for part in parts.values():
                check_solid(part)
            assert sum(part.volume_mm3 for part in parts.values()) == pytest.approx(whole.volume_mm3, rel=1e-9)


def test_the_facts_of_a_part_are_those_of_its_own_triangles():
    parts = parts_of(ramp_with_holes(), "2x2", solid=options(base="2mm"))
    assert sum(part.facts["split_corners"] for part in parts.values()) > 0
    assert all(part.facts["outline"] == "exact" for part in parts.values())
    assert all(part.facts["pieces"] == len(part.bodies) for part in parts.values())
