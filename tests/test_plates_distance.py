"""Distances from curves and points inside them, against brute force."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.path import Path
from plate_cases import star
from solid_cases import random_plate

from nmaptool.plates.board import Board
from nmaptool.plates.distance import Curves, inside_grid, inside_points
from nmaptool.types.contours import Contours


def brute(contours, points):
    """Least distance from each point to any edge."""
    least = np.full(len(points), np.inf)
    for ring in contours.rings:
        for start, end in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            edge, way = end - start, points - start
            share = np.clip(way @ edge / (edge @ edge), 0, 1)
            least = np.minimum(least, np.hypot(*(way - share[:, None] * edge).T))
    return least


def cases(trials):
    for seed in range(trials(60)):
        contours = random_plate(seed).outline
        low, high = contours.bounds_mm
        rng = np.random.default_rng(seed)
        yield contours, rng.uniform(low - (high - low) / 4, high + (high - low) / 4, (400, 2)), high - low


def test_distances_of_random_polygons_are_exact(trials):
    for contours, points, size in cases(trials):
        for spacing in (size.max() / 300, size.max() / 20):
            found = Curves(contours, spacing).nearest(points)
            assert np.abs(found.distance_mm - brute(contours, points)).max() < 1e-9 * size.max()


def test_points_along_a_ring_are_where_the_nearest_point_lies(trials):
    for contours, points, size in cases(trials):
        found = Curves(contours, size.max() / 100).nearest(points)
        for number, ring in enumerate(contours.rings):
            own = found.ring == number
            closed = np.concatenate([ring, ring[:1]])
            along = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(closed, axis=0).T))])
            place = np.column_stack([np.interp(found.along_mm[own], along, axis) for axis in closed.T])
            away = np.hypot(*(points[own] - place).T)
            assert np.allclose(away, found.distance_mm[own], atol=1e-9 * size.max())


def test_distances_beyond_the_reach_are_infinite():
    contours = star()
    points = np.random.default_rng(0).uniform(-30, 30, (500, 2))
    exact = brute(contours, points)
    found = Curves(contours, 0.5).nearest(points, 3.0)
    near = exact <= 3.0
    assert np.allclose(found.distance_mm[near], exact[near])
    assert np.isinf(found.distance_mm[~near]).all()
    assert (found.ring[~near] == -1).all()


def test_points_inside_random_polygons_are_those_of_matplotlib(trials):
    for contours, points, _ in cases(trials):
        expected = np.zeros(len(points), bool)
        for ring in contours.rings:
            expected ^= Path(np.concatenate([ring, ring[:1]])).contains_points(points)
        assert (inside_points(contours, points) == expected).all()


def test_a_grid_inside_random_polygons_is_that_of_its_points(trials):
    for contours, points, _ in cases(trials):
        x, y = np.sort(points[:40, 0]), points[:30, 1]  # y in any order
        found = inside_grid(contours, x, y)
        grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        assert (found.ravel() == inside_points(contours, grid)).all()


def test_vertices_of_a_grid_on_corners_and_edges_are_counted_once():
    square = Contours((np.array([[1.0, 1.0], [4.0, 1.0], [4.0, 3.0], [1.0, 3.0]]),))
    found = inside_grid(square, np.arange(6.0), np.arange(5.0))
    # half open: each of 3 x 2 unit squares has one of the points
    assert found.sum() == 6


def test_depths_of_a_grid_are_positive_inside():
    board = Board.around(star(), 0.5)
    contours = board.placed(star())
    depth = board.field(contours, 2.0).depth_mm()
    points = np.stack(np.meshgrid(board.x_mm, board.y_mm), axis=-1).reshape(-1, 2)
    exact = np.where(inside_points(contours, points), 1, -1) * brute(contours, points)
    exact[np.abs(exact) > 2.0] *= np.inf
    assert depth.ravel() == pytest.approx(exact, abs=1e-9)


def test_a_board_covers_its_outline_in_line_with_the_picture():
    board = Board.around(star().moved(3.3, -2.1), 0.4)
    low, high = board.placed(star().moved(3.3, -2.1)).bounds_mm
    assert (low > 0.4).all()
    assert (high < np.array([board.cols, board.rows]) * 0.4 - 0.4).all()
    assert board.x_mm[board.left] == pytest.approx(board.left * 0.4)
