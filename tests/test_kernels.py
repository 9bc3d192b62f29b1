"""The compiled loops and their twins in NumPy: equal results, whatever the number of threads, and checked arguments."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import nmaptool as nm
from nmaptool import kernels
from nmaptool.core import parallel
from nmaptool.kernels import grid_twins, pair_twins, pixel_twins, system_twins, transfer_twins

ROOT = Path(__file__).parents[1]
needs_compiler = pytest.mark.skipif(not kernels.IS_COMPILED, reason="built without a C compiler")
COLS, ROWS = 37, 23
SIZE, EDGE = COLS * ROWS, COLS + 1


def rng():
    return np.random.default_rng(17)


def field(random, zeros=False):
    """A flat field with margins of zeros."""
    out = np.zeros(SIZE + 2 * EDGE, np.float32)
    out[EDGE : EDGE + SIZE] = 0 if zeros else random.normal(size=SIZE)
    return out


def plain(random, size=SIZE):
    return random.normal(size=size).astype(np.float32)


def grid_arguments(name, random):
    """Arguments of a loop on a grid, the arrays it writes to, and a range of vertices."""
    x = field(random)
    out = np.zeros(SIZE, np.float32)
    range_ = (COLS, 2 * COLS + 5, SIZE - COLS - 3)
    couplings = [np.abs(field(random)) for _ in range(4)]
    if name == "coarse_step":
        out = field(random, zeros=True)
        return (*couplings, x, out, plain(random), np.abs(plain(random)), *range_, 0.7), out
    return (*couplings, x, plain(random), np.abs(plain(random)), out, *range_), out


@needs_compiler
@pytest.mark.parametrize("name", ["coarse_step", "coarse_left"])
def test_loops_on_grids_match_their_twins(name):
    (fast, fast_out), (slow, slow_out) = (grid_arguments(name, rng()) for _ in range(2))
    product, expected = getattr(kernels, name)(*fast), getattr(grid_twins, name)(*slow)
    assert np.abs(slow_out).max() > 1
    assert np.abs(fast_out - slow_out).max() < 2e-5
    assert product == pytest.approx(expected, rel=1e-4, abs=1e-2)
    # nothing outside the range is written
    assert np.array_equal(fast_out == 0, slow_out == 0)


def weights(cols, rows, random):
    """Eight fields of interpolation weights; those that would reach across an edge are 0."""
    out = []
    for _ in range(8):
        one = np.zeros(cols * rows + 2 * (cols + 1), np.float32)
        inner = one[cols + 1 : cols + 1 + cols * rows].reshape(rows, cols)
        inner[:-1, :-1] = random.random((rows - 1, cols - 1))
        out.append(one)
    return out


@needs_compiler
@pytest.mark.parametrize(("fine_rows", "fine_cols"), [(23, 37), (22, 36), (24, 35)])
@pytest.mark.parametrize(("first", "last"), [(0, 5), (3, 9), (0, 11)])
def test_transfer_matches_its_twin_and_is_symmetric(fine_rows, fine_cols, first, last):
    random = rng()
    cols, rows = (fine_cols + 1) // 2, (fine_rows + 1) // 2
    ways = weights(cols, rows, random)
    top = 0 if first == 0 else -1
    fine = plain(random, (min(2 * last, fine_rows) - 2 * first - top) * fine_cols)
    found, expected = np.zeros(cols * rows, np.float32), np.zeros(cols * rows, np.float32)
    kernels.restrict_rows(*ways, fine, found, fine_cols, cols, top, first, last)
    transfer_twins.restrict_rows(*ways, fine, expected, fine_cols, cols, top, first, last)
    assert np.abs(found - expected).max() < 1e-5

    coarse = np.zeros(cols * rows + 2 * (cols + 1), np.float32)
    coarse[cols + 1 : cols + 1 + cols * rows] = plain(random, cols * rows)
    up, twin = (np.zeros(fine_rows * fine_cols + 2 * (fine_cols + 1), np.float32) for _ in range(2))
    kernels.prolong_rows(*ways, coarse, up, fine_cols, cols, fine_rows, first, min(last, rows))
    transfer_twins.prolong_rows(*ways, coarse, twin, fine_cols, cols, fine_rows, first, min(last, rows))
    assert np.abs(up - twin).max() < 1e-5
    if (first, last) == (0, 11) and rows == 11:
        # <restrict r, x> = <r, prolong x>
        inside = up[fine_cols + 1 : fine_cols + 1 + fine_rows * fine_cols].astype(np.float64)
        own = coarse[cols + 1 : cols + 1 + cols * rows].astype(np.float64)
        assert found.astype(np.float64) @ own == pytest.approx(fine.astype(np.float64) @ inside, rel=1e-5)


@needs_compiler
def test_a_step_of_conjugate_gradients_matches_its_twin():
    results = []
    for loops in (kernels, transfer_twins):
        random = rng()
        direction, other, z, left = field(random), plain(random), random.normal(size=SIZE), plain(random)
        norm2 = loops.move(direction, other, z, left, 0.7, 1.5, 5, SIZE - 4, EDGE)
        results.append((direction, z, left, norm2))
    for fast, slow in zip(*results, strict=True):
        assert np.allclose(fast, slow, rtol=1e-5, atol=1e-6)


@needs_compiler
@pytest.mark.parametrize(("rows", "cols"), [(14, 9), (2, 2), (40, 65)])
def test_the_product_on_heights_matches_its_twin_in_any_bands(rows, cols):
    random = rng()
    weight, beta = random.random((rows - 1, cols - 1), np.float32), random.random((rows, cols), np.float32)
    z = random.normal(size=(rows, cols))
    expected = np.empty(z.shape)
    system_twins.system_product(weight, beta, z, expected, rows, cols, 0, rows)
    for first, last in ((0, rows), (0, 1), (1, rows), (rows - 1, rows)):
        found, twin = np.full((2, last - first, cols), np.nan)
        kernels.system_product(weight, beta, z, found, rows, cols, first, last)
        system_twins.system_product(weight, beta, z, twin, rows, cols, first, last)
        assert np.abs(twin - expected[first:last]).max() < 1e-14
        assert np.abs(found - expected[first:last]).max() < 1e-14
    # rows of the matrix sum to beta
    ones = np.empty(z.shape)
    kernels.system_product(weight, beta, np.ones(z.shape), ones, rows, cols, 0, rows)
    assert np.array_equal(ones, beta.astype(np.float64))


def nodes(random, patches=40, own=6):
    """Nodes in large patches in a row, each of which reaches its neighbours."""
    start = np.arange(patches + 1) * own
    places = random.normal(size=(patches * own, 6)).astype(np.float32) * 0.3
    places[:, 0] += np.repeat(np.arange(patches), own)
    sums = random.random((patches * own, 4)).astype(np.float32)
    near = [[q for q in (p - 1, p, p + 1) if 0 <= q < patches] for p in range(patches)]
    indptr = np.concatenate([[0], np.cumsum([len(each) for each in near])])
    return places, sums, start, indptr, np.concatenate(near)


@needs_compiler
def test_pair_sums_match_their_twin_and_the_definition():
    places, sums, start, indptr, near = nodes(rng())
    found, twin = (np.zeros((len(places), 28), np.float32) for _ in range(2))
    kernels.pair_sums(places, sums, start, indptr, near, 0, 40, 6.25, found)
    pair_twins.pair_sums(places, sums, start, indptr, near, 0, 40, 6.25, twin)
    assert np.abs(found - twin).max() < 2e-5 * np.abs(twin).max()
    # the definition, for all nodes at once
    p = places.astype(np.float64)
    step2 = ((p[:, None] - p[None]) ** 2).cumsum(axis=2)
    weight = np.exp(-step2[..., 5] / 2) * (step2[..., 2] <= 6.25)
    patch = np.repeat(np.arange(40), 6)
    weight *= np.abs(patch[:, None] - patch[None]) <= 1
    moments = np.hstack([sums, (sums[:, :, None] * places[:, None]).reshape(-1, 24)])
    assert np.abs(found - weight @ moments).max() < 2e-5 * np.abs(twin).max()


@needs_compiler
def test_sums_at_faces_match_their_twin():
    random = rng()
    places, sums, start, indptr, near = nodes(random)
    at_nodes = np.zeros((len(places), 28), np.float32)
    kernels.pair_sums(places, sums, start, indptr, near, 0, 40, 6.25, at_nodes)
    of_face = random.integers(0, len(places), 500)
    where, lead = random.normal(size=(2, 500, 3))
    found, twin = np.empty((500, 4)), np.empty((500, 4))
    kernels.at_faces(at_nodes, places, of_face, where, lead, found)
    pair_twins.at_faces(at_nodes, places, of_face, where, lead, twin)
    assert np.abs(found - twin).max() < 1e-5 * np.abs(twin).max()


@needs_compiler
def test_pair_sums_skip_only_sources_beyond_the_radius():
    # many large patches that reach each other, most of them too far away: whole blocks of sources are skipped
    places, sums, start, _, _ = nodes(rng(), own=11)
    indptr, near = np.arange(41) * 40, np.tile(np.arange(40), 40)
    found, twin = (np.zeros((len(places), 28), np.float32) for _ in range(2))
    for loops, out in ((kernels, found), (pair_twins, twin)):
        loops.pair_sums(places, sums, start, indptr, near, 0, 40, 6.25, out)
    assert np.abs(found - twin).max() < 2e-5 * np.abs(twin).max()


def cells(random):
    """A guide, sources of two levels, and cells up to 60 pixels away."""
    guide, sources = plain(random, (3, 3000)), plain(random, (2, 3, 3000))
    levels, shifts = random.integers(0, 2, 50), random.integers(-60, 61, 50)
    return guide, sources, levels, shifts, -np.abs(plain(random, 50))


@needs_compiler
def test_pixel_sums_match_their_twin_and_the_definition():
    guide, sources, levels, shifts, logs = cells(rng())
    found, twin = (np.full((3, 2800), np.nan, np.float32) for _ in range(2))
    kernels.pixel_sums(guide, sources, levels, shifts, logs, 100, 2900, found)
    pixel_twins.pixel_sums(guide, sources, levels, shifts, logs, 100, 2900, twin)
    assert np.abs(twin).max() > 1
    assert np.abs(found - twin).max() < 1e-5
    other = 777 + shifts
    weight = np.exp(logs - ((guide[:, other].T.astype(float) - guide[:, 777]) ** 2).sum(axis=1))
    assert np.abs(found[:, 677] - weight @ sources[levels, :, other]).max() < 1e-5


@needs_compiler
def test_cells_beyond_the_picture_are_refused():
    guide, sources, levels, shifts, logs = cells(rng())
    out = np.empty((3, 2800), np.float32)
    for wrong_levels, wrong_shifts in ((levels + 1, shifts), (levels, shifts + 101), (levels, shifts - 101)):
        with pytest.raises(ValueError, match="the sizes of the arrays do not match"):
            kernels.pixel_sums(guide, sources, wrong_levels, wrong_shifts, logs, 100, 2900, out)


@needs_compiler
def test_wrong_arrays_are_refused():
    places, sums, start, indptr, near = nodes(rng())
    out = np.zeros((len(places), 28), np.float32)
    with pytest.raises(TypeError, match=r"array 0: expected numbers of kind 'f'"):
        kernels.pair_sums(places.astype(float), sums, start, indptr, near, 0, 40, 6.25, out)
    for wrong in (near + 38, near - 3):
        with pytest.raises(ValueError, match="the sizes of the arrays do not match"):
            kernels.pair_sums(places, sums, start, indptr, wrong, 0, 40, 6.25, out)
    with pytest.raises(ValueError, match="the sizes of the arrays do not match"):
        kernels.pair_sums(places, sums, start, indptr, near, 0, 41, 6.25, out)
    arguments, _ = grid_arguments("coarse_step", rng())
    with pytest.raises(ValueError, match="the sizes of the arrays do not match"):
        kernels.coarse_step(*arguments[:-2], SIZE + 1, 0.5)
    with pytest.raises((ValueError, BufferError), match=r"contiguous|not match"):
        kernels.pair_sums(places[::2], sums, start, indptr, near, 0, 40, 6.25, out)


def test_results_do_not_depend_on_the_number_of_threads(monkeypatch, dome):
    d = dome(300, 700)
    normal_map = nm.NormalMap.from_array(d.normals, mask=d.inside)
    mesh = nm.read_mesh(ROOT / "samples" / "vase.ply")
    found = []
    for threads in (1, 2, 5):
        monkeypatch.setattr(parallel, "cores", lambda count=threads: count)
        found.append((nm.relief(normal_map).height.z_mm, nm.smooth(mesh).mesh.vertices))
    for heights, vertices in found[1:]:
        assert np.array_equal(heights, found[0][0])
        assert np.array_equal(vertices, found[0][1])


def test_numpy_replaces_the_compiled_loops():
    code = "from nmaptool import kernels; assert not kernels.IS_COMPILED; print(kernels.pair_sums.__module__)"
    environment = {**os.environ, "NMAPTOOL_KERNELS": "numpy"}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, text=True, env=environment)
    assert done.stdout.strip() == "nmaptool.kernels.pair_twins"
    tests = ["tests/test_solver.py", "tests/test_multigrid.py", "tests/test_smooth.py"]
    words = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *tests]
    done = subprocess.run(words, capture_output=True, check=False, text=True, env=environment, cwd=ROOT)
    assert done.returncode == 0, done.stdout[-2000:]
