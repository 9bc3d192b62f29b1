"""The pieces of the solve by tiles: the grid, the transfer to the coarse grid, borders, islands."""

from __future__ import annotations

import numpy as np
import pytest

from nmaptool.core.errors import UsageError
from nmaptool.core.grid import touching_vertices
from nmaptool.solver.system import QuadSystem
from nmaptool.solver.tiling.borders import Strip, strip_residual
from nmaptool.solver.tiling.coarse import CoarseProblem, add_block, empty_sum
from nmaptool.solver.tiling.grid import Tile, TileGrid, inside, of_vertices
from nmaptool.solver.tiling.islands import label_faces, label_vertices, merge
from nmaptool.solver.tiling.tile import TileSystem, correct, face_means, restricted
from nmaptool.solver.tiling.transfer import coarse_box, prolong, restrict


def _systems(rows: int, cols: int) -> QuadSystem:
    rng = np.random.default_rng(3)
    weight = np.where(rng.random((rows, cols)) > 0.2, rng.uniform(0.5, 2, (rows, cols)), 0).astype(np.float32)
    beta = (0.01 * rng.random((rows + 1, cols + 1))).astype(np.float32)
    return QuadSystem(weight, beta, rng.random((rows + 1, cols + 1)) > 0.97)


@pytest.mark.parametrize(("rows", "cols"), [(32, 48), (33, 31), (16, 17), (5, 70)])
def test_every_vertex_and_face_belongs_to_one_tile(rows: int, cols: int) -> None:
    grid = TileGrid(rows, cols, 16, 8, 4)
    faces, vertices = np.zeros((rows, cols), int), np.zeros((rows + 1, cols + 1), int)
    for tile in grid:
        faces[grid.faces(tile)] += 1
        vertices[grid.vertices(tile)] += 1
    assert (faces == 1).all()
    assert (vertices == 1).all()
    assert len(grid) == len(list(grid))


def test_a_tile_must_hold_whole_coarse_faces() -> None:
    with pytest.raises(UsageError, match=r"`tile=18`: must be a multiple of 4, at least 4"):
        TileGrid(100, 100, 18, 8, 4)


@pytest.mark.parametrize(
    "box", [(slice(0, 9), slice(4, 21)), (slice(3, 14), slice(8, 13)), (slice(16, 19), slice(0, 1))]
)
def test_restriction_is_the_transpose_of_interpolation(box: tuple[slice, slice]) -> None:
    rng = np.random.default_rng(0)
    rows, cols = coarse_box(box, 4)
    coarse = rng.normal(size=(rows.stop - rows.start, cols.stop - cols.start))
    fine = rng.normal(size=(box[0].stop - box[0].start, box[1].stop - box[1].start))
    assert (prolong(coarse, box, 4) * fine).sum() == pytest.approx((coarse * restrict(fine, box, 4)).sum(), rel=1e-12)


def test_interpolation_keeps_planes() -> None:
    box = (slice(2, 23), slice(5, 30))
    rows, cols = coarse_box(box, 4)
    y, x = np.mgrid[rows, cols] * 4.0
    fine_y, fine_x = np.mgrid[box]
    np.testing.assert_allclose(prolong(3 + 2 * y - x, box, 4), 3 + 2 * fine_y - fine_x, atol=1e-12)


def test_blocks_of_tiles_sum_to_the_restriction_of_the_whole() -> None:
    grid = TileGrid(70, 50, 16, 8, 4)
    values = np.random.default_rng(1).normal(size=(71, 51))
    total = empty_sum(grid)
    for tile in grid:
        add_block(total, restricted(values[grid.vertices(tile)], grid, tile), grid, tile)
    whole = (slice(0, 71), slice(0, 51))
    expected = np.zeros(total.shape)
    expected[coarse_box(whole, 4)] = restrict(values, whole, 4)
    np.testing.assert_allclose(total, expected, atol=1e-12)


def test_means_count_faces_outside_the_picture_as_nothing() -> None:
    grid = TileGrid(6, 4, 4, 4, 4)
    np.testing.assert_allclose(face_means(np.ones((6, 4), np.float32), grid), [[1.0], [0.5]])


def test_the_coarse_problem_is_exact_for_constant_heights() -> None:
    """Where beta pulls an island without held vertices to one height, the coarse grid finds that height at once."""
    grid = TileGrid(64, 64, 32, 8, 4)
    weight = np.ones((64, 64), np.float32)
    system = QuadSystem(weight, np.full((65, 65), 0.01, np.float32), np.zeros((65, 65), bool))
    ones = np.ones((65, 65))
    total = [empty_sum(grid) for _ in range(3)]
    for tile in grid:
        own = grid.vertices(tile)
        for out, values in zip(total, (system.apply(ones), ones, system.apply(7 * ones)), strict=True):
            add_block(out, restricted(values[own], grid, tile), grid, tile)
    correction = CoarseProblem(face_means(weight, grid), total[0], total[1]).solve(total[2])
    whole = (slice(0, 65), slice(0, 65))
    np.testing.assert_allclose(prolong(correction[coarse_box(whole, 4)], whole, 4), 7, rtol=1e-4)


@pytest.mark.parametrize("row", [16, 32])
def test_a_strip_has_the_residual_of_the_whole(row: int) -> None:
    system = _systems(48, 40)
    rng = np.random.default_rng(2)
    z, load = rng.normal(size=(49, 41)), rng.normal(size=(49, 41))
    whole = np.empty(z.shape)
    system.residual(load, z, whole)
    middle = slice(row - 1, row + 1)
    found = strip_residual(
        Strip(
            z[row - 2 : row + 2],
            system.weight[row - 2 : row + 1],  # type: ignore[arg-type]
            system.beta[middle],  # type: ignore[arg-type]
            system.unknown[middle],
            load[middle],
        )
    )
    np.testing.assert_allclose(found, whole[middle], atol=1e-12)


def test_a_correction_leaves_no_residual_inside_its_tile() -> None:
    system = _systems(64, 64)
    grid = TileGrid(64, 64, 32, 16, 4)
    load = np.where(system.unknown, np.random.default_rng(5).normal(size=(65, 65)), 0)
    tile = Tile(0, 1)
    window = grid.window(tile)
    corners = of_vertices(window)
    part = TileSystem(
        np.ascontiguousarray(system.weight[window], np.float32),
        np.ascontiguousarray(system.beta[corners], np.float32),
        np.ascontiguousarray(system.unknown[corners]),
        np.ascontiguousarray(load[corners]),
        np.zeros(load[corners].shape),
    )
    before = part.z.copy()
    done = correct(part, grid, tile, 1e-6)
    assert done.z.shape == (32, 33)
    assert np.abs(done.residual).max() < 1e-4 * np.abs(load).max()
    assert done.iterations > 0
    np.testing.assert_array_equal(part.z, before)
    # the row and the column next to other tiles are left to the strips
    assert not done.residual[-1].any()
    assert not done.residual[:, 0].any()


def test_islands_that_cross_tiles_are_one() -> None:
    acting = np.zeros((32, 32), np.float32)
    acting[4, 2:30] = 1  # a line across both tiles
    acting[20, 5:9] = 1  # within the first
    acting[25:27, 15] = 1  # touches the next only at a corner
    acting[27, 16:20] = 1
    acting[30, 25:28] = 1
    grid = TileGrid(32, 32, 16, 4, 4)
    tiles = list(grid)
    labels, counts = {}, []
    for tile in tiles:
        rows, cols = grid.faces(tile)
        around = slice(max(rows.start - 1, 0), rows.stop), slice(max(cols.start - 1, 0), cols.stop)
        labels[tile], count = label_faces(np.ascontiguousarray(acting[around]))
        counts.append(count)
    place = {tile: k for k, tile in enumerate(tiles)}
    pairs = []
    for tile in tiles:
        above, before = Tile(tile.row - 1, tile.col), Tile(tile.row, tile.col - 1)
        if above in place:
            pairs.append((place[tile], labels[tile][0], place[above], labels[above][-1]))
        if before in place:
            pairs.append((place[tile], labels[tile][:, 0], place[before], labels[before][:, -1]))
    numbers, count = merge(counts, pairs)
    assert count == 4
    found = np.zeros(acting.shape, int)
    for tile, number in zip(tiles, numbers, strict=True):
        rows, cols = grid.faces(tile)
        box = (slice(max(rows.start - 1, 0), rows.stop), slice(max(cols.start - 1, 0), cols.stop))
        own = inside((rows, cols), box)
        found[rows, cols] = number[labels[tile]][own]
    assert len({*found[4, 2:30]}) == 1
    assert found[26, 15] == found[27, 16] != found[20, 6]
    assert ((found > 0) == (acting > 0)).all()


def test_a_vertex_belongs_to_the_island_of_its_faces() -> None:
    faces = np.array([[1, 0, 0], [0, 0, 2]], np.int32)
    assert label_vertices(faces).tolist() == [[1, 1, 0, 0], [1, 1, 2, 2], [0, 0, 2, 2]]
    assert (label_vertices(faces) > 0).tolist() == touching_vertices(faces > 0).tolist()
