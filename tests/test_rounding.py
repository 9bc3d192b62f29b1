"""Rounded corners of a cut: circles of the radius asked for, straight edges where they were."""

from __future__ import annotations

import numpy as np
import pytest
from solid_cases import check_solid

import nmaptool as nm
from nmaptool.reliefs.rounding import rounded

SIDE = 80


def area_of_corner(radius):
    """What a rounded right angle loses."""
    return (1 - np.pi / 4) * radius**2


def square(low=20, high=60):
    coverage = np.zeros((SIDE, SIDE), np.float32)
    coverage[low:high, low:high] = 1
    return coverage


@pytest.mark.parametrize("radius", [2.0, 5.0, 11.5])
def test_outer_corners_become_quarter_circles(radius):
    found = rounded(square(), radius)
    lost = 40**2 - float(found.sum())
    assert lost == pytest.approx(4 * area_of_corner(radius), abs=0.05 * 4 * area_of_corner(radius) + 0.5)
    # straight edges stay
    assert found[40, 18:22].tolist() == pytest.approx([0, 0, 1, 1], abs=0.02)


def test_inner_corners_are_rounded_too():
    coverage = square()
    coverage[20:40, 20:40] = 0  # the shape of an L
    gained = float(rounded(coverage, 5.0).sum() - coverage.sum())
    assert gained == pytest.approx((1 - 5) * area_of_corner(5.0), abs=2)


def test_narrow_parts_and_gaps_disappear():
    coverage = square()
    coverage[38:42, 60:76] = 1  # a tongue of 4 px
    coverage[30:32, 25:55] = 0  # a slot of 2 px
    found = rounded(coverage, 3.0)
    assert found[40, 68] == 0
    assert found[31, 40] == 1


def test_a_disc_larger_than_the_radius_stays():
    y, x = np.mgrid[:SIDE, :SIDE] + 0.5
    coverage = np.clip(25 - np.hypot(x - 40, y - 40) + 0.5, 0, 1).astype(np.float32)
    assert rounded(coverage, 8.0) == pytest.approx(coverage, abs=0.25)


def test_the_border_of_the_picture_is_an_outline():
    found = rounded(np.ones((30, 40), np.float32), 6.0)
    assert found[0, 0] == 0
    assert found[15, 0] == found[0, 20] == 1
    assert 30 * 40 - float(found.sum()) == pytest.approx(4 * area_of_corner(6.0), rel=0.05)


def test_a_plaque_is_cut_with_rounded_corners():
    y, x = np.mgrid[1:-1:60j, -1:1:80j]
    normals = np.dstack([x, y, np.full_like(x, 2)])
    options = nm.ReliefOptions(background="cut", outline_round=nm.length("8mm"), width=nm.length("80mm"))
    relief = nm.relief(normals, options=options)
    assert 60 * 80 - relief.mask.sum() == pytest.approx(4 * area_of_corner(8.0), abs=8)
    solid = nm.solid(relief, nm.SolidOptions(base=nm.length("2mm")))
    check_solid(solid)
    corner = solid.to_mesh().vertices[:, :2]
    # no vertex lies outside the circle of the corner
    near = corner[(corner < 7.5).all(axis=1)]
    assert np.hypot(*(8 - near).T).max() < 8.1


@pytest.mark.parametrize(
    ("values", "error", "message"),
    [
        ({"background": "plane"}, nm.UsageError, "`outline_round='30mm'`: needs `background='cut'`, not plane"),
        ({"background": "cut"}, nm.InputError, "`outline_round='30mm'`: no part of the motif is twice as wide"),
    ],
)
def test_a_radius_that_cannot_be_is_refused(values, error, message):
    normals = np.zeros((40, 40, 3))
    normals[..., 2] = 1
    with pytest.raises(error, match=message):
        nm.relief(
            normals,
            options=nm.ReliefOptions(outline_round=nm.length("30mm"), width=nm.length("40mm"), **values),
        )
