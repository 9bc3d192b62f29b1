"""Soft edges, fading masks, curved and flat backgrounds, and errors for arguments that are not maps."""

import dataclasses

import numpy as np
import pytest
from relief_cases import dome, normal_map, rolling, solve

import nmaptool as nm
from nmaptool.core.errors import InputError, UsageError
from nmaptool.core.grid import corner_sum, height_slopes
from nmaptool.reliefs.domain import build_domain
from nmaptool.reliefs.targets import Weights, build_targets


def test_a_soft_edge_softens_the_detail_too():
    original, _, detail = dome(bumps=1)
    half = dataclasses.replace(original, coverage=(original.coverage * 0.6).astype(np.float32))
    full_domain, half_domain = (build_domain("plane", m.foreground, m.foreground, m.coverage) for m in (original, half))
    weights = Weights(1.0, 0.01, 1.0)
    whole = build_targets(original, detail, full_domain, weights, 3.0, "eq6")
    soft = build_targets(half, detail, half_domain, weights, 3.0, "eq6")
    assert np.allclose(soft.p, 0.6 * whole.p, atol=1e-6)
    assert np.allclose(soft.beta, 0.6 * whole.beta, rtol=1e-6)


@pytest.mark.parametrize("energy", ["eq6", "eq4"])
def test_flat_detail_does_not_change_a_curved_background(energy):
    roll = rolling()
    original, flat = normal_map(*height_slopes(roll)), normal_map(*np.zeros((2, 96, 96)))
    background = nm.Height(roll * 100 / 96, np.ones((96, 96), bool), nm.Frame(96, 96, 100 / 96))
    relief = solve(original, flat, background="surface", surface=background, mask=dome()[0].foreground, mu=1.0,
                   delta=0.0, energy=energy, tolerance=1e-12)  # fmt: skip
    assert np.abs(relief.z_mm - background.z_mm).max() < 1e-6 * np.ptp(roll)


def test_soft_edges_follow_the_slopes_of_a_curved_background():
    roll = rolling()
    original = normal_map(*height_slopes(roll))
    soft = (0.5 + 0.5 * dome()[0].foreground).astype(np.float32)
    domain = build_domain("surface", soft >= 0.5, soft >= 0.5, soft, roll)
    targets = build_targets(original, None, domain, Weights(0, 0.01, 1.0), 3.0, "eq6")
    assert np.abs(targets.p - height_slopes(roll)[0]).max() < 1e-6


def test_a_gradual_mask_fades_over_its_whole_ramp():
    original = dome(kind="full")[0]
    ramp = np.broadcast_to(np.clip((np.arange(96) - 20) / 50, 0, 1).astype(np.float32), (96, 96))
    relief = solve(original, mask=ramp, beta=1e-4)
    assert relief.foreground[48, 24]
    assert not relief.foreground[48, :21].any()
    step = (np.arange(96) > 45).astype(np.float32)
    assert not solve(original, mask=np.broadcast_to(step, (96, 96)), beta=1e-4).foreground[48, :46].any()


def test_the_insides_of_letters_follow_the_map():
    """A ring embossed on a flat map: the enclosed area is as low as the plate."""
    row, col = np.mgrid[0:121, 0:121]
    r = np.hypot(row - 60, col - 60)
    z = 4 * np.clip((np.minimum(r - 20, 45 - r)) / 4, 0, 1)
    ring = normal_map(*height_slopes(z))
    outside = np.hypot(*(np.mgrid[0:120, 0:120] + 0.5 - 60)) > 46
    flat = dataclasses.replace(ring, foreground=~outside, flat_background=True)
    inside, top = (60, 60), (60, 60 + 32)

    def share_filled(source, **options):
        height = solve(source, **options).z_mm
        return height[inside] / height[top]

    assert share_filled(dataclasses.replace(flat, flat_background=False), delta=20.0) > 0.5
    assert share_filled(flat, delta=20.0) < 0.35
    assert abs(share_filled(flat, beta=0.0)) < 0.02
    assert any("`beta=0` keeps every height" in w for w in solve(flat).report.warnings)
    assert not any("`beta` 0" in w for w in solve(flat, beta=0.0).report.warnings)


def test_arguments_that_are_not_maps_are_named():
    original = dome()[0]
    with pytest.raises(UsageError, match="the original must be a NormalMap, found str; read one with read_normal_map"):
        nm.relief("a.png")
    with pytest.raises(UsageError, match="the detail map must be a NormalMap, found ReliefOptions"):
        nm.relief(original, nm.ReliefOptions())
    with pytest.raises(UsageError, match="the curved background must be a NormalMap or a Height, found str"):
        solve(original, background="surface", surface="x.png")
    with pytest.raises(UsageError, match="the mask must be an array of numbers, found str"):
        solve(original, mask="mask.png")
    with pytest.raises(UsageError, match="the beta map must be an array of numbers, found str"):
        solve(original, beta_map="m.png")
    with pytest.raises(UsageError, match="`mu_map`: has no effect without a detail map"):
        solve(original, mu_map=original.coverage)
    for bad in (np.full((96, 96), np.nan), np.full((96, 96), 60, np.uint8), np.full((96, 96), -0.1)):
        with pytest.raises(InputError, match="the mask must hold values from 0 to 1"):
            solve(original, mask=bad)
    holes = np.ones((96, 96), bool)
    holes[4, 4] = False
    for surface, message in (
        (nm.Height(np.zeros((97, 97)), holes, nm.Frame(96, 96, 100 / 96)), "the curved background has holes"),
        (
            nm.Height(np.zeros((97, 97)), holes | True, nm.Frame(96, 96, 10.0)),
            "has 10 mm per pixel but the relief 1.042",
        ),
    ):
        with pytest.raises(InputError, match=message):
            solve(original, background="surface", surface=surface)


def test_lengths_may_be_text():
    original = dome()[0]
    relief = solve(original, height="3mm", width="48mm")
    assert relief.report.height_range_mm == pytest.approx(3)
    assert relief.pitch_mm == 0.5


def test_checked_arrays_are_read_only():
    original = dome()[0]
    relief = solve(original)
    for array in (
        original.normals,
        original.coverage,
        original.foreground,
        relief.foreground,
        relief.z_mm,
        relief.mask,
    ):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


@pytest.mark.parametrize("kind", ["masked", "full"])
def test_vanishing_beta_gives_the_shape_of_beta_0_at_the_height_of_delta(kind):
    original = dome(bumps=1, kind=kind)[0]
    options = {"background": "cut", "per_pixel": True, "tolerance": 1e-10}
    shape = solve(original, beta=0.0, **options)
    inside = shape.height.vertex_mask
    for beta, delta in ((1e-9, 20.0), (1e-9, 1e6)):
        relief = solve(original, beta=beta, delta=delta, **options)
        weight = corner_sum(original.foreground.astype(float))[inside]
        heights = relief.z_mm[inside] / relief.pitch_mm
        assert np.average(heights, weights=weight) == pytest.approx(delta, abs=1e-6)
        off = (relief.z_mm - shape.z_mm)[inside]
        assert np.ptp(off) < 1e-4 * np.ptp(shape.z_mm)


def test_a_relief_ends_where_its_ground_ends():
    y, x = np.mgrid[0:80, 0:80] - 39.5
    ball = np.hypot(x, y) < 30
    height = np.sqrt(np.maximum(60.0**2 - x * x - y * y, 1))
    normals = np.dstack([x / 60, -y / 60, height / 60]).astype(np.float32)
    normals[~ball] = (0, 0, 1)
    ground = nm.NormalMap(normals, ball.astype(np.float32), nm.Frame(80, 80))
    motif = np.hypot(x, y) < 12
    relief = solve(ground, background="surface", surface=ground, mask=motif.astype(np.float32), delta=0.0)
    assert np.array_equal(relief.height.domain, ball)
    inside = relief.height.vertex_mask
    yv, xv = np.mgrid[0:81, 0:81] - 40.0
    expected = np.sqrt(60.0**2 - xv**2 - yv**2, where=inside, out=np.zeros((81, 81)))[inside]
    made = relief.z_mm[inside] / relief.pitch_mm
    assert np.abs(made - made.mean() - expected + expected.mean()).max() < 0.05
    # an overhanging motif is level with the nearest ground
    over = nm.NormalMap(normals, np.ones((80, 80), np.float32), nm.Frame(80, 80))
    wide = solve(over, background="surface", surface=ground, mask=(np.hypot(x - 28, y) < 8).astype(np.float32))
    assert wide.height.domain.sum() > ball.sum()
    assert wide.z_mm[wide.height.vertex_mask].min() >= -1e-6
