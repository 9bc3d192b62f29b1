"""Every blend mode: formulas, bit-exact identities, inverses and limits."""

import numpy as np
import pytest
from compose_cases import FLAT, angles_deg, from_slopes, random_normals

from nmaptool.composition.blend_vectors import blend_normals as blend
from nmaptool.core.vectors import slopes
from nmaptool.maps.detail import encode_detail
from nmaptool.options import BLEND_MODES as MODES

A, B = random_normals(seed=1), random_normals(seed=2)


def unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def overlay(a, b):
    a, b = (a + 1) / 2, (b + 1) / 2
    return unit(2 * np.where(a < 0.5, 2 * a * b, 1 - 2 * (1 - a) * (1 - b)) - 1)


def rnm(a, b):
    t, u = a + FLAT, b * (-1, -1, 1)
    return unit(t * (t * u).sum(axis=-1, keepdims=True) / t[..., 2:] - u)


FORMULAS = {
    "rnm": rnm,
    "pd": lambda a, b: unit(np.dstack([a[..., :2] * b[..., 2:] + b[..., :2] * a[..., 2:], a[..., 2] * b[..., 2]])),
    "whiteout": lambda a, b: unit(np.dstack([a[..., :2] + b[..., :2], a[..., 2] * b[..., 2]])),
    "udn": lambda a, b: unit(np.dstack([a[..., :2] + b[..., :2], a[..., 2]])),
    "linear": lambda a, b: unit(a + b),
    "overlay": overlay,
}


def test_the_table_lists_the_six_modes():
    assert set(MODES) == set(FORMULAS)


@pytest.mark.parametrize("mode", FORMULAS)
def test_modes_follow_their_published_formulas(mode):
    steep = np.hypot(A[..., 0], A[..., 1]) / A[..., 2]
    gentle = (steep < 40) & (np.hypot(B[..., 0], B[..., 1]) / B[..., 2] < 40)
    expected = FORMULAS[mode](A.astype(np.float64), B.astype(np.float64))
    assert angles_deg(blend(A, B, mode), expected)[gentle].max() < 2e-4
    assert gentle.mean() > 0.9


@pytest.mark.parametrize("mode", FORMULAS)
@pytest.mark.parametrize("strength", [0.0, 0.3, 1.0, 2.5])
def test_every_result_has_unit_length(mode, strength):
    away = -random_normals(seed=3)  # normals that face away, too
    for base, detail in ((A, B), (away, B), (A, away), (away, away)):
        assert np.abs(np.linalg.norm(blend(base, detail, mode, strength), axis=-1) - 1).max() < 1e-6


@pytest.mark.parametrize("mode", ["rnm", "pd", "whiteout", "udn"])
@pytest.mark.parametrize("strength", [1.0, 0.4, 3.0])
def test_a_flat_detail_changes_nothing(mode, strength):
    for base in (A, -A):
        assert np.array_equal(blend(base, np.broadcast_to(FLAT, base.shape), mode, strength), base)


@pytest.mark.parametrize("mode", ["rnm", "pd", "whiteout"])
def test_a_flat_base_gives_the_detail_bit_for_bit(mode):
    for detail in (B, -B):
        assert np.array_equal(blend(np.broadcast_to(FLAT, B.shape), detail, mode), detail)


@pytest.mark.parametrize("mode", FORMULAS)
def test_strength_zero_changes_nothing(mode):
    assert np.array_equal(blend(A, B, mode, 0), A)
    each = np.zeros(A.shape[:2], np.float32)
    each[3:9, 5:20] = 0.5
    mixed = blend(A, B, mode, each)
    assert np.array_equal(mixed[each == 0], A[each == 0])
    assert np.array_equal(mixed[each > 0], blend(A, B, mode, 0.5)[each > 0])


def test_reoriented_blending_undoes_rotation_detail_and_partial_derivatives_undo_slope_detail():
    original, base = random_normals(seed=4, lowest=0.3), random_normals(seed=5, lowest=0.3)
    assert angles_deg(blend(base, encode_detail(original, base, "rotation"), "rnm"), original).max() < 1e-4
    assert angles_deg(blend(base, encode_detail(original, base, "slope"), "pd"), original).max() < 1e-3
    # also for a base that faces straight away
    away = np.broadcast_to(-FLAT, original.shape)
    assert angles_deg(blend(away, encode_detail(original, away, "rotation"), "rnm"), original).max() < 1e-4


def test_slopes_of_two_surfaces_add():
    y, x = np.mgrid[0:60, 0:80] / 10.0
    first, second = (np.cos(x), np.sin(y)), (0.3 * np.sin(x + y), 0.3 * np.sin(x + y))
    expected = from_slopes(first[0] + second[0], first[1] + second[1])
    assert np.abs(blend(from_slopes(*first), from_slopes(*second), "pd") - expected).max() < 1e-5


@pytest.mark.parametrize("strength", [0.25, 2.0])
@pytest.mark.parametrize("mode", ["rnm", "pd", "whiteout"])
def test_strength_scales_the_slopes_of_the_detail(mode, strength):
    detail = random_normals(seed=6, lowest=0.2)
    faded = blend(np.broadcast_to(FLAT, detail.shape), detail, mode, strength)
    for before, after in zip(slopes(detail, 40), slopes(faded, 40), strict=True):
        assert np.abs(after - strength * before).max() < 1e-4 * np.abs(before).max()


def test_strength_scales_linear_and_mixes_overlay():
    assert angles_deg(blend(A, B, "linear", 0.5), unit(A + 0.5 * B)).max() < 1e-4
    full = overlay(A.astype(np.float64), B.astype(np.float64))
    assert angles_deg(blend(A, B, "overlay", 0.5), unit(A + 0.5 * (full - A))).max() < 1e-4


def test_opposite_normals_give_the_base():
    assert np.array_equal(blend(A, -A, "linear"), A)


def test_any_shape_from_one_vector_to_an_image_is_accepted():
    one = blend(A[0, 0], B[0, 0], "rnm")
    assert one.shape == (3,)
    assert np.array_equal(one, blend(A, B, "rnm")[0, 0])
    big = [np.tile(v, (20, 20, 1)) for v in (A, B)]  # more than one chunk
    assert np.array_equal(blend(*big, "pd")[-40:, -50:], blend(A, B, "pd"))


def test_arguments_are_not_changed_and_bad_ones_are_named():
    before = A.copy(), B.copy()
    blend(A, B, "whiteout", 0.7)
    assert np.array_equal(A, before[0]) and np.array_equal(B, before[1])
    with pytest.raises(ValueError, match="unknown mode 'screen': use one of rnm, pd"):
        blend(A, B, "screen")
    with pytest.raises(ValueError, match="must have the same shape"):
        blend(A, B[:-1], "rnm")
    for strength in (-1.0, np.nan, np.full(A.shape[:2], -0.1)):
        with pytest.raises(ValueError, match="strength must be finite and zero or more"):
            blend(A, B, "rnm", strength)
