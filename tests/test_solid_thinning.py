"""Few triangles instead of two for each pixel: they cover the mask exactly, meet at whole sides and keep the error."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy import ndimage
from solid_cases import HARD_MASKS, check_solid, mask_of, random_options, random_relief

import nmaptool as nm
from nmaptool.core.grid import touching_vertices
from nmaptool.solids.outline import find_splits
from nmaptool.solids.shape import Shape
from nmaptool.solids.sheet import Placing, Sheet
from nmaptool.solids.simplify import Thinner, thin, tolerance_for
from nmaptool.solids.split_errors import needed_outline
from nmaptool.solids.triangle_tree import tree


def drawn(triangles, z_mm, mask):
    """Largest distance of each vertex from the triangles that hold it (-1: none does), and how often quarters of pixels
    are covered, both found triangle by triangle."""
    off, covered = np.full(z_mm.shape, -1.0), np.zeros((4, *mask.shape), int)
    for corners in triangles:
        r, c = np.divmod(corners, z_mm.shape[1])
        to_weights = np.linalg.inv(np.array([r, c, np.ones(3)]))
        down, right = (np.arange(each.min(), each.max() + 1) for each in (r, c))

        def weights(rows, cols, to_weights=to_weights):
            return np.einsum("wk,kij->wij", to_weights, np.stack([*np.broadcast_arrays(rows, cols, 1.0)]))

        at = weights(down[:, None], right)
        inside = (at > -1e-9).all(axis=0)
        here = np.ix_(down, right)
        distance = np.abs(np.einsum("wij,w->ij", at, z_mm[r, c]) - z_mm[here])
        off[here] = np.maximum(off[here], np.where(inside, distance, -1))
        for number, (y, x) in enumerate(((0.25, 0.5), (0.75, 0.5), (0.5, 0.25), (0.5, 0.75))):
            middle = weights(down[:-1, None] + y, right[:-1] + x)
            covered[number][np.ix_(down[:-1], right[:-1])] += (middle > 0).all(axis=0)
    return off, covered


def sides_of(triangles):
    """(n, 2): the directed sides of triangles."""
    return np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])


def check_mesh(mesh, z_mm, mask, kept):
    """Exactly the mask, counter-clockwise, right-angled with equal legs, met at whole sides, as far off as it says."""
    triangles, width = mesh.triangles, mask.shape[1] + 1
    r, c = np.divmod(triangles, width)
    dx, dy = c - np.roll(c, 1, axis=1), np.roll(r, 1, axis=1) - r
    assert (dx[:, 1] * dy[:, 2] - dy[:, 1] * dx[:, 2] > 0).all()
    lengths = np.sort(dx**2 + dy**2, axis=1)
    assert (lengths[:, 0] == lengths[:, 1]).all()
    assert (lengths[:, 2] == 2 * lengths[:, 0]).all()
    off, covered = drawn(triangles, z_mm, mask)
    assert (covered == mask).all()
    assert abs(off.max() - mesh.max_error_mm) <= 1e-12 * np.abs(z_mm).max()
    sides = {(a, b) for a, b in sides_of(triangles).tolist()}
    assert len(sides) == 3 * len(triangles)
    outline = mesh.outline
    open_sides = {(a, b) for a, b in sides if (b, a) not in sides}
    assert open_sides == set(zip(outline.start.tolist(), outline.end.tolist(), strict=True))
    assert mask[outline.rows, outline.cols].all()
    used = np.zeros(z_mm.shape, bool)
    used.ravel()[triangles] = True
    assert used[kept & touching_vertices(mask)].all()
    assert mesh.face_count == len(triangles)


def random_case(seed):
    """A mask up to 70 px wide, heights, vertices that stay."""
    rng = np.random.default_rng(seed)
    rows, cols = (int(side) for side in rng.integers(1, rng.choice([10, 36, 71]), 2))
    field = ndimage.gaussian_filter(rng.standard_normal((rows, cols)), rng.choice([0, 1.5, 4]))
    masks = [np.ones((rows, cols), bool), field >= np.quantile(field, 0.4), np.ones((rows, cols), bool)]
    mask = masks[seed % 3]
    if seed % 3 == 2:  # lines of single pixels, and gaps
        mask[rng.integers(rows)] = False
        mask[:, rng.integers(cols)] = False
        mask |= rng.random((rows, cols)) < 0.02
        mask[rows // 2, cols // 2] = True
    z_mm = ndimage.gaussian_filter(rng.standard_normal((rows + 1, cols + 1)), rng.choice([0, 2, 6]))
    z_mm /= np.ptp(z_mm)
    return mask, z_mm, rng.random((rows + 1, cols + 1)) < rng.choice([0, 0.01])


def test_random_masks_are_covered_exactly_within_the_error(trials):
    for seed in range(trials(24)):
        mask, z_mm, kept = random_case(seed)
        max_error_mm = (0.0, 1e-9, 0.01, 0.1, 0.3, 2.0)[seed % 5]
        mesh = thin(z_mm, mask, kept, max_error_mm=max_error_mm)
        check_mesh(mesh, z_mm, mask, kept)
        assert mesh.max_error_mm <= max_error_mm


@pytest.mark.parametrize("name", HARD_MASKS)
def test_every_hard_mask_is_covered_by_the_fewest_triangles(name):
    mask = mask_of(HARD_MASKS[name])
    kept = np.zeros(np.add(mask.shape, 1), bool)
    check_mesh(thin(np.ones(kept.shape), mask, kept), np.ones(kept.shape), mask, kept)


def test_a_number_of_triangles_gives_the_smallest_possible_error(trials):
    for seed in range(trials(40)):
        mask, z_mm, kept = random_case(seed)
        thinner = Thinner([z_mm], mask, kept)
        fewest, most = thinner.at(np.inf).face_count, thinner.at(0.0).face_count
        steps = np.unique(np.concatenate(thinner.steps()))
        counts = {bound: thinner.at(bound).face_count for bound in [0.0, *steps[:: max(1, len(steps) // 20)], np.inf]}
        assert list(counts.values()) == sorted(counts.values(), reverse=True)
        for limit in (fewest, (fewest + most) // 2, most):
            mesh = thin(z_mm, mask, kept, max_triangles=limit)
            assert mesh.face_count <= limit
            smaller = [bound for bound, count in counts.items() if count <= limit]
            assert mesh.face_count >= max(counts[bound] for bound in smaller)
            assert mesh.max_error_mm <= min(smaller) + 1e-12


def test_vertices_of_equal_error_come_in_together():
    errors = np.array([3.0, 2.0, 2.0, 2.0, 1.0])
    assert [tolerance_for(limit, 10, [(errors, 2)]) for limit in (10, 12, 17, 18, 20)] == [3, 2, 2, 1, 0]


def test_too_few_triangles_are_refused_with_the_number_needed():
    mask = np.ones((40, 37), bool)
    fewest = thin(np.zeros((41, 38)), mask, np.zeros((41, 38), bool)).face_count
    assert 37 <= fewest < 300
    with pytest.raises(nm.InputError, match=f"`triangles='5'`: the outline alone needs {fewest} triangles"):
        thin(np.zeros((41, 38)), mask, np.zeros((41, 38), bool), max_triangles=5)


@pytest.mark.parametrize("slope", [0.0, 0.25])
def test_a_plane_needs_two_triangles_for_each_tile(slope):
    z_mm = np.add.outer(np.arange(513) * slope, np.arange(257) * slope / 2)
    mesh = thin(z_mm, np.ones((512, 256), bool), np.zeros((513, 257), bool), max_error_mm=1e-9)
    assert len(mesh.triangles) == 4
    assert len(mesh.outline.start) == 6


def test_without_error_a_rough_surface_is_that_of_the_full_grid():
    rng = np.random.default_rng(4)
    z_mm, mask = rng.random((34, 30)), rng.random((33, 29)) < 0.8
    mesh = thin(z_mm, mask, np.ones(z_mm.shape, bool), max_error_mm=0)
    shape = Shape(mask, dataclasses.replace(find_splits(mask), vertices=np.zeros(0, np.int64)))
    parts = list(Sheet(z_mm, shape, Placing(1, 0, 0)).parts())
    full = np.concatenate([part.nodes[part.faces] for part in parts])
    ours, theirs = ({tuple(sorted(each)) for each in found.tolist()} for found in (mesh.triangles, full))
    assert ours == theirs


def test_errors_of_a_tile_are_those_found_triangle_by_triangle():
    rng = np.random.default_rng(8)
    z_mm, known = rng.random((17, 17)), np.ones((17, 17), bool)
    known[3, 5] = False
    expected, of_known = np.zeros((17, 17)), np.zeros((17, 17))
    corners = np.array([[[0, 0], [16, 16], [0, 16]], [[16, 16], [0, 0], [16, 0]]])
    grid = np.stack([*np.indices((17, 17)).reshape(2, -1), np.ones(289)])
    while len(corners) <= 256:
        halves = []
        for a, b, c in corners:
            weights = np.linalg.solve(np.column_stack([[*p, 1] for p in (a, b, c)]), grid)
            inside = (weights > -1e-9).all(axis=0)
            off = np.abs(z_mm[tuple(np.array([a, b, c]).T)] @ weights - z_mm.ravel())[inside].max()
            at = tuple((a + b) // 2)
            expected[at] = max(expected[at], off)
            of_known[at] = max(of_known[at], off * known.ravel()[inside].all())
            halves += [[c, a, (a + b) // 2], [b, c, (a + b) // 2]]
        corners = np.array(halves)
    assert tree(16).errors(z_mm, None) == pytest.approx(expected, abs=1e-14)
    assert tree(16).errors(z_mm, known) == pytest.approx(of_known, abs=1e-14)


def test_the_border_of_a_picture_needs_only_vertices_at_powers_of_two():
    # 96 = 3 * 32 and 100 = 25 * 4: steps of 32 along the right border, of 4 along the lower one, tiles of 128
    needed = needed_outline(np.ones((100, 96), bool), 128)
    row, col = np.nonzero(needed)
    assert set(row[col == 96].tolist()) == {0, 32, 64, 96, 100}
    assert set(col[row == 100].tolist()) == set(range(0, 97, 4))
    assert set(row[col == 0].tolist()) == {0, 64, 96, 100}


def with_limit(options, rng):
    """The options with an error, and with about that many triangles."""
    error_mm = float(rng.choice([0.002, 0.05, 0.3, 3.0]))
    return error_mm, dataclasses.replace(options, max_error=nm.length(f"{error_mm}mm"))


def test_thinned_solids_are_manifold_and_as_large_as_the_full_ones(trials):
    for seed in range(trials(60)):
        relief, options, rng = random_relief(seed), random_options(seed), np.random.default_rng([seed, 2])
        full = nm.solid(relief, options)
        error_mm, limited = with_limit(options, rng)
        solid = nm.solid(relief, limited)
        check_solid(solid)
        assert solid.facts["max_error_mm"] <= error_mm
        assert np.abs(solid.bounds_mm - full.bounds_mm).max() < 1e-9
        assert sum(len(part.faces) for body in solid.bodies for part in body.parts()) == solid.face_count
        # both sheets may be off; diagonals of pixels add less than half the range of heights
        area = np.count_nonzero(relief.foreground) * 0.01
        assert abs(solid.volume_mm3 - full.volume_mm3) <= area * (
            2 * solid.facts["max_error_mm"] + 0.5 * np.ptp(relief.z_mm)
        )


def test_a_number_of_triangles_counts_the_whole_solid(trials):
    for seed in range(trials(40)):
        relief, options = random_relief(seed), random_options(seed)
        full = nm.solid(relief, options).face_count
        fewest = nm.solid(relief, dataclasses.replace(options, max_error=nm.length("1000mm"))).face_count
        limit = max(100, (fewest + full) // 2)
        solid = nm.solid(relief, dataclasses.replace(options, triangles=str(limit)))
        check_solid(solid)
        assert fewest <= solid.face_count <= limit
        below = solid.facts["max_error_mm"] * (1 - 1e-6)
        if below > 1e-6 and solid.face_count < limit:
            more = nm.solid(relief, dataclasses.replace(options, max_error=nm.length(f"{below:.12f}mm")))
            assert more.face_count > limit


def test_an_open_surface_is_thinned():
    y, x = np.mgrid[0:101, 0:121] / 50
    height = nm.Height(np.sin(3 * x) * np.cos(2 * y), np.ones((100, 120), bool), nm.Frame(100, 120, pitch_mm=0.2))
    solid = nm.solid(height, nm.SolidOptions(triangles="2k"))
    assert not solid.is_closed
    assert 1900 < solid.face_count <= 2000
    assert 0 < solid.facts["max_error_mm"] < 0.02
    assert nm.solid(height, nm.SolidOptions(max_error=nm.length("0.02mm"))).face_count < 2000


def test_a_thinned_shell_is_as_thick_as_the_full_one_at_its_vertices():
    y, x = np.mgrid[-20:21, -20:21] * 0.5
    z_mm = np.sqrt(np.maximum(14.0**2 - x**2 - y**2, 1.0))
    height = nm.Height(z_mm, np.ones((40, 40), bool), nm.Frame(40, 40, pitch_mm=0.5))
    options = nm.SolidOptions(shell=nm.length("1.5mm"))
    meshes = [nm.solid(height, each).to_mesh() for each in (options, dataclasses.replace(options, triangles="1k"))]
    full, thin_ = ({tuple(vertex) for vertex in mesh.vertices.round(9).tolist()} for mesh in meshes)
    assert thin_ < full
    # every vertex of the front has one of the back below it
    places = [vertex[:2] for vertex in thin_]
    assert all(places.count(place) == 2 for place in places)


def test_too_few_triangles_for_a_solid_are_refused_in_the_words_given():
    relief = nm.Height(np.ones((76, 78)), np.ones((75, 77), bool), nm.Frame(75, 77, pitch_mm=0.2))
    with pytest.raises(nm.InputError, match=r"`triangles='0.5k'`: the outline alone needs \d+ triangles; allow more"):
        nm.solid(relief, nm.SolidOptions(base=nm.length("2mm"), triangles="0.5k"))
