"""Smooth outlines: where coverage says the edge is, with islands, holes and heights kept."""

from __future__ import annotations

import numpy as np
import pytest
from solid_cases import PLATE, check_solid

import nmaptool as nm
from nmaptool.solids.outline import outline_edges
from nmaptool.solids.rim import rim_heights
from nmaptool.solids.smooth import has_soft_edges, smooth_foot_line, smooth_shape

SIZE, OVER = 200, 8
CENTRE = np.array([100.3, 99.7])


def star():
    """(10, 2) corners of a star with five points."""
    angle = np.arange(10) * np.pi / 5 + 0.2
    return CENTRE + np.where(np.arange(10) % 2, 35.0, 80.0)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])


def covered(inside):
    """(H, W) float32 share of each pixel in which ``inside(x, y)`` holds."""
    y, x = (np.mgrid[: SIZE * OVER, : SIZE * OVER] + 0.5) / OVER
    return inside(x, y).reshape(SIZE, OVER, SIZE, OVER).mean(axis=(1, 3)).astype(np.float32)


def in_star(x, y):
    from matplotlib.path import Path

    return Path(star()).contains_points(np.column_stack([x.ravel(), y.ravel()])).reshape(x.shape)


def from_star(points):
    """Distance of points from the outline of the star."""
    nearest = np.full(len(points), np.inf)
    for a, b in zip(star(), np.roll(star(), -1, axis=0), strict=True):
        along = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        nearest = np.minimum(nearest, np.linalg.norm(points - a - along[:, None] * (b - a), axis=1))
    return nearest


def disc(radius):
    """Whether places lie in a disc, and the distance of points from its circle."""
    return (
        lambda x, y: np.hypot(x - CENTRE[0], y - CENTRE[1]) < radius,
        lambda points: np.abs(np.hypot(*(points - CENTRE).T) - radius),
    )


SHAPES = {
    "disc": (
        lambda x, y: np.hypot(x - CENTRE[0], y - CENTRE[1]) < 70.2,
        lambda p: np.abs(np.hypot(*(p - CENTRE).T) - 70.2),
    ),
    "small disc": (
        lambda x, y: np.hypot(x - CENTRE[0], y - CENTRE[1]) < 9.2,
        lambda p: np.abs(np.hypot(*(p - CENTRE).T) - 9.2),
    ),
    "star": (in_star, from_star),
}


def points_along(shape):
    """Points along the edges of the outline."""
    edges = outline_edges(shape.mask, shape.splits)
    a, b = shape.places_px(edges.start), shape.places_px(edges.end)
    return np.concatenate([a * (1 - t) + b * t for t in (0.0, 0.25, 0.5, 0.75)])


@pytest.mark.parametrize("name", SHAPES)
def test_an_outline_with_soft_pixels_lies_on_the_true_curve(name):
    inside, distance = SHAPES[name]
    coverage = covered(inside)
    shape, deviation_px = smooth_shape(coverage >= 0.5, coverage)
    rms = np.sqrt(np.mean(distance(points_along(shape)) ** 2))
    assert rms < 0.06
    assert 0.5 < deviation_px < 0.45 * np.sqrt(2) + 1e-9


@pytest.mark.parametrize(("name", "limit"), [("disc", 0.15), ("star", 0.2)])
def test_the_steps_of_a_hard_mask_are_smoothed(name, limit):
    inside, distance = SHAPES[name]
    mask = covered(inside) >= 0.5
    shape, _ = smooth_shape(mask, mask.astype(np.float32))
    assert np.sqrt(np.mean(distance(points_along(shape)) ** 2)) < limit


def test_soft_pixels_are_found():
    coverage = covered(SHAPES["disc"][0])
    mask = coverage >= 0.5
    assert has_soft_edges(mask, coverage)
    assert not has_soft_edges(mask, mask.astype(np.float32))


def test_a_straight_soft_edge_stays_straight():
    coverage = np.zeros((20, 30), np.float32)
    coverage[:, :12] = 1
    coverage[:, 12] = 0.7
    shape, _ = smooth_shape(coverage >= 0.5, coverage)
    x, y = shape.places_px(shape.moved).T
    assert len(x) == 21
    # the ends slide along the border of the picture
    assert x[[0, -1]] == pytest.approx(12.7, abs=0.02)
    assert x[1:-1] == pytest.approx(12.7, abs=1e-5)
    assert y == pytest.approx(np.arange(21), abs=1e-3)


def test_pixels_and_lines_of_one_pixel_stay():
    mask = np.zeros((12, 12), bool)
    mask[2, 2] = mask[6, 1:11] = True
    mask[8:11, 4:9] = True
    mask[9, 6] = False
    for coverage in (mask.astype(np.float32), mask * np.float32(0.7)):
        shape, _ = smooth_shape(mask, coverage)
        height = nm.Height(np.ones((13, 13)), mask, nm.Frame(12, 12, pitch_mm=1.0))
        solid = nm.solid(
            nm.Relief(height, mask, PLATE, coverage), nm.SolidOptions(base=nm.length("1mm"), outline="smooth")
        )
        check_solid(solid)
        assert len(solid.bodies) == 3
        assert shape.mask.sum() == mask.sum()


def test_heights_along_a_moved_outline_continue_a_plane():
    coverage = covered(SHAPES["disc"][0])
    shape, _ = smooth_shape(coverage >= 0.5, coverage)
    row, col = np.mgrid[: SIZE + 1, : SIZE + 1]
    x, y = shape.places_px(shape.moved).T
    assert rim_heights(0.3 * col - 0.2 * row + 5.0, shape) == pytest.approx(0.3 * x - 0.2 * y + 5, abs=0.02)


def test_a_smooth_cut_keeps_the_exact_height():
    coverage = covered(SHAPES["disc"][0])
    mask = coverage >= 0.5
    row, col = np.mgrid[: SIZE + 1, : SIZE + 1]
    z_mm = 3 - np.hypot(col - 100, row - 100) / 30
    relief = nm.Relief(nm.Height(z_mm, mask, nm.Frame(SIZE, SIZE, pitch_mm=0.1)), mask, PLATE, coverage)
    solid = nm.solid(relief, nm.SolidOptions(outline="smooth"))
    assert solid.bounds_mm[:, 2] == pytest.approx(relief.height.range_mm, abs=1e-12)


def test_the_foot_line_on_a_plate_follows_the_true_curve():
    coverage = covered(SHAPES["disc"][0])
    shape, _ = smooth_foot_line(coverage >= 0.5, coverage)
    assert shape.mask.all()
    # every vertex of the outline of the motif lies on the circle, those of the plate stay on the grid
    distance = np.abs(np.hypot(*(shape.places_px(shape.moved) - CENTRE).T) - 70.2)
    assert np.sqrt(np.mean(distance**2)) < 0.06
    height = nm.Height(np.zeros((SIZE + 1, SIZE + 1)), shape.mask, nm.Frame(SIZE, SIZE, pitch_mm=0.1))
    solid = nm.solid(nm.Relief(height, coverage >= 0.5, PLATE, coverage), nm.SolidOptions(base=nm.length("1mm")))
    check_solid(solid)
    assert solid.facts["outline"] == "smooth"
