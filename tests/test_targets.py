"""The system, built in float32 bands, against its definition in float64 in one piece."""

import numpy as np
import pytest
from relief_cases import dome, normal_map, rolling
from scipy import ndimage

from nmaptool.core.grid import corner_sum, dilated, height_slopes
from nmaptool.core.vectors import slopes
from nmaptool.reliefs.domain import build_domain
from nmaptool.reliefs.targets import Weights, build_targets, capped_slopes
from nmaptool.solver import slope_load


def randoms(rows, cols, seed=0):
    """Two random maps, a motif, its soft coverage and weight maps."""
    rng = np.random.default_rng(seed)
    maps = [normal_map(*rng.normal(size=(2, rows, cols))) for _ in range(2)]
    motif = rng.random((rows, cols)) > 0.3
    return maps, motif, *rng.random((4, rows, cols), np.float32)


@pytest.mark.parametrize("shape", [(1, 1), (1, 40), (40, 1), (33, 17), (420, 500)])
@pytest.mark.parametrize("energy", ["eq6", "eq4"])
def test_bands_in_float32_give_the_system_of_the_definition(shape, energy):
    (original, detail), motif, share, mu, beta, delta = randoms(*shape)
    base = np.random.default_rng(1).normal(size=np.add(shape, 1))
    motif.flat[0] = True
    domain = build_domain("surface", motif, motif, share, base)
    weights = Weights(0.7, 0.02, 5.0, mu, beta, delta)
    found = build_targets(original, detail, domain, weights, 1.2, energy)

    acting, soft = motif.astype(float), motif * share.astype(float)
    m = 0.7 * mu.astype(float) * acting
    k = acting + m * (energy == "eq6")
    first, second, ground = slopes(original.normals, 1.2), slopes(detail.normals, 1.2), height_slopes(base)
    p, q = (soft * (s - g * acting) + m * soft * d + k * g for s, d, g in zip(first, second, ground, strict=True))
    pulled = 0.02 * beta.astype(float) * soft
    load = slope_load(p, q) + corner_sum(pulled) / 4 * base
    assert {a.dtype for a in (found.weight, found.p, found.q, found.beta, found.pull)} == {np.dtype(np.float32)}
    for seen, expected in (
        (found.weight, k),
        (found.p, p),
        (found.q, q),
        (found.beta, corner_sum(pulled) / 4),
        (found.pull, corner_sum(pulled * delta) / 4),
        (found.shape_load(base), load),
    ):
        assert seen.shape == expected.shape
        assert np.abs(seen - expected).max() <= 1e-6 * max(np.abs(expected).max(), 1)
    steep = np.hypot(*(original.normals[..., axis] for axis in range(2))) > 1.2 * original.normals[..., 2]
    assert found.steep_share == pytest.approx(steep[motif].mean(), abs=2 / motif.sum() * (steep.size > 1000))


def test_a_missing_base_counts_as_0_and_missing_weight_maps_as_1():
    (original, detail), motif, share, *_ = randoms(50, 60)
    ones = np.ones((50, 60), np.float32)
    bare = build_targets(
        original, detail, build_domain("plane", motif, motif, share), Weights(1.0, 0.1, 2.0), 3.0, "eq6"
    )
    zero = build_domain("plane", motif, motif, share, np.zeros((51, 61)))
    full = build_targets(original, detail, zero, Weights(1.0, 0.1, 2.0, ones, ones, ones), 3.0, "eq6")
    assert bare.pull is bare.beta
    for name in ("weight", "p", "q", "beta", "pull"):
        assert np.array_equal(getattr(bare, name), getattr(full, name))
    assert np.array_equal(bare.shape_load(None), full.shape_load(zero.base_px))


def test_given_slopes_are_not_changed():
    original, _, detail = dome(64, bumps=1)
    known = capped_slopes(original.normals, 3.0), capped_slopes(detail.normals, 3.0)
    before = [a.copy() for each in known for a in (each.p, each.q, each.steep)]
    domain = build_domain("surface", original.foreground, original.foreground, None, rolling(64))
    weights = Weights(0.5, 0.1, 2.0)
    found = build_targets(original, detail, domain, weights, 3.0, "eq6", known)
    assert np.array_equal(found.p, build_targets(original, detail, domain, weights, 3.0, "eq6").p)
    after = [a for each in known for a in (each.p, each.q, each.steep)]
    assert all(np.array_equal(a, b) for a, b in zip(before, after, strict=True))


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (9, 1), (4, 5), (40, 60)])
@pytest.mark.parametrize("px", [1, 2, 6])
def test_dilation_matches_scipy(shape, px):
    mask = np.random.default_rng(2).random(shape) > 0.97
    mask.flat[-1] = True
    assert np.array_equal(dilated(mask, px), ndimage.binary_dilation(mask, np.ones((3, 3)), iterations=px))
