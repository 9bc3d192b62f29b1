"""Identities and equivariance of the relief, its other inputs, its backgrounds, and inputs that do not fit."""

import dataclasses

import numpy as np
import pytest
from relief_cases import dome, normal_map, rolling, solve

import nmaptool as nm
from nmaptool.core.errors import InputError, UsageError
from nmaptool.core.grid import corner_sum, height_slopes, touching_vertices
from nmaptool.reliefs.domain import build_domain
from nmaptool.reliefs.targets import Weights, build_targets


def test_eq4_equals_eq6_with_other_parameters():
    """z4(mu, beta, delta) = (1 + mu) z6(mu, beta6, delta6), beta6 = beta (1 + mu), delta6 = delta / (1 + mu)."""
    original, _, detail = dome(bumps=1)
    mu, beta, delta = 0.7, 0.02, 9.0
    four = solve(original, detail, energy="eq4", mu=mu, beta=beta, delta=delta, tolerance=1e-12).z_mm
    six = solve(original, detail, mu=mu, beta=beta * (1 + mu), delta=delta / (1 + mu), tolerance=1e-12).z_mm
    # weights are float32
    assert np.abs(four - (1 + mu) * six).max() < 1e-6 * np.ptp(four)


def test_flat_detail_adds_nothing_in_eq4_and_compresses_in_eq6():
    original = dome(bumps=1)[0]
    flat = dome(bumps=0, base=0)[0]
    alone = solve(original, tolerance=1e-12)
    assert np.array_equal(solve(original, flat, energy="eq4", mu=0.5, tolerance=1e-12).z_mm, alone.z_mm)
    options = {"beta": 0.002, "delta": 0.0, "tolerance": 1e-12}
    six = solve(original, flat, mu=1.0, **options).z_mm
    assert np.allclose(2 * six, solve(original, **{**options, "beta": 0.001}).z_mm, atol=1e-8)


def turned(source, quarter_turns):
    normals = np.rot90(source.normals, quarter_turns).copy()
    x, y = normals[..., 0].copy(), normals[..., 1].copy()
    for _ in range(quarter_turns):
        x, y = -y, x
    normals[..., 0], normals[..., 1] = x, y
    coverage = np.rot90(source.coverage, quarter_turns).copy()
    return nm.NormalMap(normals, coverage, nm.Frame(*coverage.shape))


@pytest.mark.parametrize("quarter_turns", [1, 2, 3])
@pytest.mark.parametrize("kind", ["masked", "full"])
def test_rotating_the_map_rotates_the_relief(quarter_turns, kind):
    original = dome(bumps=1, kind=kind)[0]
    straight = solve(original, tolerance=1e-11).z_mm
    result = solve(turned(original, quarter_turns), tolerance=1e-11).z_mm
    assert np.abs(np.rot90(straight, quarter_turns) - result).max() < 1e-6 * np.ptp(straight)


def test_mirroring_the_map_mirrors_the_relief():
    original = dome(bumps=1)[0]
    lopsided = dataclasses.replace(original, coverage=(original.coverage * (np.arange(96) > 30)).astype(np.float32),
                                   foreground=original.foreground & (np.arange(96) > 30))  # fmt: skip
    flipped = nm.NormalMap(
        lopsided.normals[:, ::-1] * np.array([-1, 1, 1], np.float32),
        lopsided.coverage[:, ::-1].copy(), lopsided.frame, lopsided.foreground[:, ::-1].copy(),
    )  # fmt: skip
    straight = solve(lopsided, tolerance=1e-11).z_mm
    assert np.abs(straight[:, ::-1] - solve(flipped, tolerance=1e-11).z_mm).max() < 1e-6 * np.ptp(straight)


@pytest.mark.parametrize("name", ["mu_map", "beta_map", "delta_map"])
def test_weight_maps_multiply_the_scalar(name):
    original, _, detail = dome(bumps=1)
    ones = np.ones(original.frame.shape, np.float32)
    plain = solve(original, detail, mu=0.4, beta=0.01, delta=16.0)
    assert np.array_equal(solve(original, detail, mu=0.4, beta=0.01, delta=16.0, **{name: ones}).z_mm, plain.z_mm)
    halved = {"mu": 0.4, "beta": 0.01, "delta": 16.0}
    halved[name[:-4]] /= 2
    by_map = solve(original, detail, mu=0.4, beta=0.01, delta=16.0, **{name: ones / 2}).z_mm
    assert np.array_equal(by_map, solve(original, detail, **halved).z_mm)
    assert not np.array_equal(by_map, plain.z_mm)


def test_a_delta_map_lifts_only_where_it_is_bright():
    original = dome()[0]
    right = np.broadcast_to((np.arange(96) > 48).astype(np.float32), (96, 96))
    both = solve(original, beta=1.0, delta=30.0, delta_map=right).z_mm
    assert both[48, 60:75].mean() == pytest.approx(30 * 100 / 1000, rel=0.2)
    assert abs(both[48, 20:36].mean()) < 0.5


def test_per_pixel_uses_beta_and_delta_unscaled():
    original = dome()[0]
    literal = solve(original, beta=0.01 / 0.096**2, delta=10 * 0.096, per_pixel=True)
    assert np.allclose(literal.z_mm, solve(original, beta=0.01, delta=10.0).z_mm, atol=1e-12)
    assert literal.report.reach_px == pytest.approx(10 * 0.096)


def test_a_mask_selects_the_motif_and_feathers_it():
    original = dome(kind="full")[0]
    mask = dome()[0].foreground
    relief = solve(original, mask=mask)
    assert np.array_equal(relief.foreground, mask)
    assert not relief.z_mm[touching_vertices(~mask)].any()
    centre = (np.arange(96) + 0.5 - 48) / 40
    soft = np.clip((1 - np.hypot(centre[:, None], centre)) * 3, 0, 1).astype(np.float32)
    p_hard, p_soft = (height_slopes(solve(original, mask=m, beta=1e-5).z_mm)[0] for m in (soft >= 0.5, soft))
    rim = (soft >= 0.5) & (soft < 0.7)
    assert np.abs(p_soft[rim]).mean() < 0.8 * np.abs(p_hard[rim]).mean()


@pytest.mark.parametrize("as_height", [True, False])
def test_a_curved_background_is_held_and_delta_counts_from_it(as_height):
    roll = rolling()
    p, q = height_slopes(roll)
    foreground = dome()[0].foreground
    original = normal_map(p, q)  # the motif equals the background, so only delta may raise it
    pitch = 100 / 96
    if as_height:
        background = nm.Height(roll * pitch, np.ones((96, 96), bool), nm.Frame(96, 96, pitch))
    else:
        background, roll = normal_map(p, q), roll - roll.min()
    same = solve(original, background="surface", surface=background, mask=foreground, delta=0.0, tolerance=1e-12)
    assert np.abs(same.z_mm - roll * pitch).max() < 1e-6 * np.ptp(roll)
    raised = solve(original, background="surface", surface=background, mask=foreground, delta=20.0, beta=1.0)
    above = raised.z_mm / pitch - roll
    assert np.abs(above[touching_vertices(~foreground)]).max() < 1e-6
    assert above[48, 48] == pytest.approx(20 * 0.096, rel=0.02)
    exact = solve(original, background="surface", surface=background, mask=foreground, height=nm.length("3mm"))
    assert np.ptp(exact.z_mm - roll * pitch) == pytest.approx(3, abs=1e-6)
    assert exact.report.relief_range_mm == pytest.approx(3, abs=1e-6)


def test_a_free_background_follows_its_own_normals():
    roll = rolling()
    relief = solve(normal_map(*height_slopes(roll)), background="free", beta=0.0)
    z = relief.z_mm / relief.pitch_mm
    assert np.abs((z - z.mean()) - (roll - roll.mean())).max() < 1e-6 * np.ptp(roll)
    assert relief.mask.all()
    assert any("`delta` has no effect" in warning for warning in relief.report.warnings)


def test_steep_normals_are_capped():
    steep = normal_map(np.full((8, 40), 50.0), np.zeros((8, 40)))
    for cap in (1.0, 3.0):
        relief = solve(steep, background="free", beta=0.0, slope_cap=cap)
        slope = np.diff(relief.z_mm, axis=1) / relief.pitch_mm
        assert np.allclose(slope, cap, atol=1e-6)
        assert relief.report.steep_share == 1
    away = np.zeros((4, 4, 3), np.float32)
    away[...] = (0.6, 0, -0.8)
    p, q = nm.relief(nm.NormalMap(away, np.ones((4, 4), np.float32), nm.Frame(4, 4)),
                     options=nm.ReliefOptions(background="free", beta=0.0)).z_mm[0, :2]  # fmt: skip
    assert (q - p) == pytest.approx(-3 * 25, rel=1e-6)


def test_the_size_comes_from_width_file_or_default():
    original = dome()[0]
    assert solve(original).pitch_mm == pytest.approx(100 / 96)
    assert solve(original).report.pitch_from == "assumed"
    known = dataclasses.replace(original, frame=nm.Frame(96, 96, 0.25))
    assert (solve(known).pitch_mm, solve(known).report.pitch_from) == (0.25, "file")
    given = solve(known, width=nm.length("48mm"))
    assert (given.pitch_mm, given.report.pitch_from) == (0.5, "given")
    assert np.allclose(given.z_mm, 2 * solve(known).z_mm)


def test_the_report_states_what_was_done():
    original, _, detail = dome(bumps=1)
    relief = solve(original, detail, mu=0.2, beta=0.01, delta=10.0)
    report = relief.report
    assert report.solver == "multigrid"
    assert report.unknowns == (touching_vertices(relief.foreground) & ~touching_vertices(~relief.foreground)).sum()
    assert (report.islands, report.floating_islands) == (1, 0)
    assert report.reach_px == pytest.approx(np.sqrt(1.2 / 0.01) * 0.096)
    assert report.reach_mm == pytest.approx(report.reach_px * relief.pitch_mm)
    inside = relief.z_mm[touching_vertices(relief.foreground)]
    assert report.below_background_share == (inside < 0).mean()
    assert report.to_dict()["options"]["mu"] == 0.2
    assert solve(original, beta=0.0, background="cut").report.to_dict()["reach_px"] is None
    assert solve(dome(kind="full")[0]).report.solver == "dct"


def test_inputs_are_not_changed():
    original, _, detail = dome(bumps=1)
    before = [a.copy() for a in (original.normals, original.coverage, original.foreground, detail.normals)]
    solve(original, detail)
    for array, copy in zip(
        (original.normals, original.coverage, original.foreground, detail.normals), before, strict=True
    ):
        assert np.array_equal(array, copy)


def test_inputs_that_do_not_fit_are_named():
    original, small = dome()[0], dome(40)[0]
    with pytest.raises(InputError, match="map is 96 x 96 pixels but the detail map map is 40 x 40; make them the same"):
        solve(original, small)
    with pytest.raises(InputError, match="but the mask is 40 x 40"):
        solve(original, mask=small.foreground)
    with pytest.raises(InputError, match="but the curved background is 40 x 40"):
        solve(original, background="surface", surface=small)
    for name in ("mu", "beta", "delta"):
        with pytest.raises(InputError, match=f"but the {name} map is 40 x 40"):
            solve(original, original, **{f"{name}_map": small.coverage})
    with pytest.raises(InputError, match="the beta map: values must be finite, not negative and at most"):
        solve(original, beta_map=np.full((96, 96), -1, np.float32))
    with pytest.raises(InputError, match="the delta map: values must be finite and at most"):
        solve(original, delta_map=np.full((96, 96), np.nan, np.float32))
    with pytest.raises(InputError, match="the mask selects nothing"):
        solve(original, mask=np.zeros((96, 96)))
    with pytest.raises(InputError, match="the mask selects only background"):
        solve(original, mask=~original.foreground)
    with pytest.raises(InputError, match="every pixel is background"):
        solve(dataclasses.replace(original, foreground=np.zeros((96, 96), bool)))
    nothing = dataclasses.replace(original, coverage=np.zeros((96, 96), np.float32))
    with pytest.raises(InputError, match=r"every pixel is background .* use `background_color='none'`"):
        solve(original, background="surface", surface=nothing)
    with pytest.raises(UsageError, match="`background='surface'`: needs the curved background"):
        solve(original, background="surface")
    with pytest.raises(UsageError, match="`surface`: needs `background='surface'`, found plane"):
        solve(original, surface=original)


def test_each_background_has_its_domain():
    foreground = np.zeros((5, 6), bool)
    foreground[1:4, 2:5] = True
    covered = np.ones((5, 6), bool)
    covered[0] = False
    plane = build_domain("plane", foreground, covered)
    assert plane.surface.all()
    assert (~plane.held).sum() == 4  # the inner vertices of 3 x 3 faces
    cut, free = build_domain("cut", foreground, covered), build_domain("free", foreground, covered)
    assert np.array_equal(cut.acting, foreground)
    assert np.array_equal(free.acting, covered)
    assert not (cut.held.any() or free.held.any())
    targets = build_targets(normal_map(*np.zeros((2, 5, 6))), None, free, Weights(0, 0.4, 1.0), 3.0, "eq6")
    assert np.array_equal(targets.beta, np.float32(0.4) / 4 * corner_sum(foreground.astype(np.float32)))
