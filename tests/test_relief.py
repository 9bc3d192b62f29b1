"""What a relief must do as its options change: the trends of the paper's Fig. 16, exact heights, identities."""

import dataclasses

import numpy as np
import pytest

import nmaptool as nm
from nmaptool.errors import InputError, UsageError
from nmaptool.formulation.domain import lay_out
from nmaptool.formulation.targets import Weights, aim
from nmaptool.grid import corner_sum, height_slopes, touching
from nmaptool.solver import QuadSystem, prepare, slope_load
from nmaptool.vectors import unit


def normal_map(p, q, foreground=None, name="map"):
    normals = unit(np.stack([-p, -q, np.ones_like(p)], axis=-1))
    coverage = np.ones(p.shape, np.float32) if foreground is None else foreground.astype(np.float32)
    normals[coverage == 0] = (0, 0, 1)
    return nm.NormalMap(normals, coverage, nm.Frame(*p.shape), name=name)


def dome(side=96, bumps=0.0, base=1.0, kind="masked"):
    """A dome with bumps: (O, B, D) maps; the dome's disc is the foreground."""
    y, x = (side - np.mgrid[0 : side + 1, 0 : side + 1][0], np.mgrid[0 : side + 1, 0 : side + 1][1])
    u, v = (x - side / 2) / (0.42 * side), (y - side / 2) / (0.42 * side)
    smooth = base * 0.35 * side * np.exp(-1.5 * (u**2 + v**2))
    fine = bumps * np.cos(2 * np.pi * x * 12 / side) * np.cos(2 * np.pi * y * 12 / side) * side / 100
    centre = (np.arange(side) + 0.5 - side / 2) / (0.42 * side)
    disc = np.hypot(centre[:, None], centre) < 1 if kind == "masked" else None
    maps = [normal_map(*height_slopes(z), disc) for z in (smooth + fine, smooth)]
    return maps[0], maps[1], normal_map(*height_slopes(fine), disc)


def solve(original, detail=None, **changes):
    given = {k: changes.pop(k) for k in list(changes) if k.endswith("_map") or k in ("mask", "surface")}
    return nm.relief(original, detail, options=nm.ReliefOptions(**changes), **given)


def foreground_heights(relief):
    return relief.z_mm[touching(relief.foreground) & ~touching(~relief.foreground)]


def test_mean_height_grows_with_delta():
    original = dome()[0]
    means = [foreground_heights(solve(original, beta=0.01, delta=d)).mean() for d in (1.0, 5.0, 10.0, 20.0)]
    assert np.all(np.diff(means) > 0.1 * np.diff([1, 5, 10, 20]) * 100 / 1000)


def test_larger_beta_is_flatter():
    original, delta = dome(bumps=1)[0], 12.0
    shares = []
    for beta in (0.0001, 0.0004, 0.0016, 0.0064):
        relief = solve(original, beta=beta, delta=delta)
        target = delta * 100 / 1000
        shares.append((np.abs(foreground_heights(relief) - target) < 0.2 * target).mean())
    assert np.all(np.diff(shares) > 0.05)


def band_energies(relief):
    """Slope energy in the bumps' band and below it."""
    z = np.where(touching(relief.foreground), relief.z_mm, 0)
    p, q = height_slopes(z)
    spectrum = sum(np.abs(np.fft.fft2(s * np.hanning(len(s))[:, None] * np.hanning(len(s)))) ** 2 for s in (p, q))
    frequency = np.hypot(*np.meshgrid(*[np.fft.fftfreq(len(p)) * len(p)] * 2))
    return spectrum[(frequency > 12) & (frequency < 24)].sum(), spectrum[frequency < 8].sum()


def test_larger_mu_raises_detail_over_base():
    original, _, detail = dome(bumps=1)
    weights = np.array([0.0, 0.1, 0.5, 2.0])
    ratios = []
    for mu in weights:
        fine, coarse = band_energies(solve(original, detail, mu=float(mu), beta=1e-8))
        ratios.append(fine / coarse)
    assert np.all(np.diff(ratios) > 0)
    # with a long reach nothing but mu acts: base slopes shrink by 1 + mu, detail keeps its size
    assert np.allclose(np.array(ratios) / ratios[0], (1 + weights) ** 2, rtol=0.05)
    near = [np.divide(*band_energies(solve(original, detail, mu=float(mu), beta=1e-3))) for mu in weights]
    assert np.all(np.diff(near) > 0)


def test_base_alone_keeps_the_structure_without_the_detail():
    original, base, _ = dome(bumps=1)
    fine, coarse = band_energies(solve(original))
    fine_base, coarse_base = band_energies(solve(base))
    assert fine_base < 0.05 * fine
    assert coarse_base == pytest.approx(coarse, rel=0.1)


def test_held_plate_is_flat_and_heights_are_linear_in_delta():
    original = dome(bumps=1)[0]
    at = [solve(original, delta=d, tolerance=1e-13).z_mm for d in (0.0, 7.0, 21.0)]
    assert np.abs((at[2] - at[0]) - 3 * (at[1] - at[0])).max() < 1e-9 * np.ptp(at[2])
    for z in at:
        assert not z[touching(~original.foreground)].any()


def test_nothing_held_shifts_by_delta():
    original = dome(bumps=1)[0]
    for background in ("free", "cut"):
        low, high = (solve(original, background=background, delta=d, tolerance=1e-12) for d in (0.0, 10.0))
        inside = low.height.vertex_mask
        assert np.allclose((high.z_mm - low.z_mm)[inside], 10 * 100 / 1000, atol=1e-7)


def test_held_outline_carves_no_groove():
    """Were the outline free between the flat plate and the steep motif, it would sink below the plate."""
    side = 96
    original = dome(side, base=2.0)[0]
    fg = original.foreground
    domain = lay_out("plane", fg, fg)
    weights = Weights(0.0, 0.001 / 0.096**2, 20 * 0.096)
    everywhere = dataclasses.replace(domain, acting=np.ones_like(fg), held=~touching(fg))
    depth = {}
    for name, layout in (("free outline", everywhere), ("held outline", domain)):
        targets = aim(original, None, layout, weights, 3.0, "eq6")
        solver = prepare(QuadSystem(targets.weight, targets.beta, layout.held))
        z = solver.solve(slope_load(targets.p, targets.q) + weights.delta * targets.pull).z
        rim = touching(fg) & touching(~fg)
        depth[name] = z[rim].min()
    assert depth["free outline"] < -0.2
    assert depth["held outline"] == 0


@pytest.mark.parametrize("fit", ["scale", "slope", "delta"])
@pytest.mark.parametrize("background", ["plane", "cut"])
def test_height_is_exact(fit, background):
    original = dome(bumps=1)[0]
    if fit == "delta" and background == "cut":
        with pytest.raises(InputError, match="changing delta alone, which has no effect here: it stays at"):
            solve(original, background=background, height=nm.length("9mm"), fit=fit)
        return
    relief = solve(original, background=background, height=nm.length("9mm"), fit=fit)
    low, high = relief.height.range_mm
    assert high - low == pytest.approx(9, abs=1e-6)
    assert relief.report.height_range_mm == pytest.approx(9, abs=1e-6)


def test_fit_slope_keeps_delta_and_fit_delta_keeps_slopes():
    original = dome(bumps=1)[0]
    options = {"beta": 0.01, "tolerance": 1e-12}
    shape = solve(original, delta=0.0, **options).z_mm
    pull = solve(original, delta=20.0, **options).z_mm - shape
    by_slope = solve(original, delta=20.0, height=nm.length("8mm"), fit="slope", **options)
    by_delta = solve(original, delta=20.0, height=nm.length("8mm"), fit="delta", **options)
    assert np.allclose(by_slope.z_mm, by_slope.report.scale * shape + pull, atol=1e-8)
    assert np.allclose(by_delta.z_mm, shape + by_delta.report.delta_px / (20 * 0.096) * pull, atol=1e-8)


def test_height_below_the_least_names_it():
    original = dome(bumps=1)[0]
    with pytest.raises(
        InputError, match=r"--height 0.01mm: cannot be reached by changing delta alone, the least is"
    ) as e:
        solve(original, height=nm.length("0.01mm"), fit="delta")
    least = float(str(e.value).split("the least is ")[1].split()[0])
    reached = solve(original, height=nm.Length(least * 1.001, "mm"), fit="delta")
    assert reached.report.height_range_mm == pytest.approx(least, rel=2e-3)


def test_flat_relief_cannot_be_scaled():
    flat = normal_map(*np.zeros((2, 20, 20)))
    with pytest.raises(InputError, match="the relief is flat and cannot be scaled"):
        solve(flat, height=nm.length("3mm"))


def test_same_shape_at_500_and_1000_px():
    low, high = (solve(dome(side, bumps=1)[0], height=nm.length("5mm")) for side in (500, 1000))
    difference = low.z_mm - high.z_mm[::2, ::2]
    assert np.sqrt((difference**2).mean()) < 0.02 * 5


def test_eq4_is_eq6_in_other_units():
    """z4(mu, beta, delta) = (1 + mu) z6(mu, beta (1 + mu)... with beta6 = beta (1 + mu), delta6 = delta/(1 + mu))."""
    original, _, detail = dome(bumps=1)
    mu, beta, delta = 0.7, 0.02, 9.0
    four = solve(original, detail, energy="eq4", mu=mu, beta=beta, delta=delta, tolerance=1e-12).z_mm
    six = solve(original, detail, mu=mu, beta=beta * (1 + mu), delta=delta / (1 + mu), tolerance=1e-12).z_mm
    assert np.abs(four - (1 + mu) * six).max() < 1e-9 * np.ptp(four)


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
def test_turning_the_map_turns_the_relief(quarter_turns, kind):
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


def test_delta_map_lifts_only_where_it_is_bright():
    original = dome()[0]
    right = np.broadcast_to((np.arange(96) > 48).astype(np.float32), (96, 96))
    both = solve(original, beta=1.0, delta=30.0, delta_map=right).z_mm
    assert both[48, 60:75].mean() == pytest.approx(30 * 100 / 1000, rel=0.2)
    assert abs(both[48, 20:36].mean()) < 0.5


def test_per_pixel_takes_beta_and_delta_literally():
    original = dome()[0]
    literal = solve(original, beta=0.01 / 0.096**2, delta=10 * 0.096, per_pixel=True)
    assert np.allclose(literal.z_mm, solve(original, beta=0.01, delta=10.0).z_mm, atol=1e-12)
    assert literal.report.reach_px == pytest.approx(10 * 0.096)


def test_mask_chooses_the_motif_and_feathers_it():
    original = dome(kind="full")[0]
    mask = dome()[0].foreground
    relief = solve(original, mask=mask)
    assert np.array_equal(relief.foreground, mask)
    assert not relief.z_mm[touching(~mask)].any()
    centre = (np.arange(96) + 0.5 - 48) / 40
    soft = np.clip((1 - np.hypot(centre[:, None], centre)) * 3, 0, 1).astype(np.float32)
    p_hard, p_soft = (height_slopes(solve(original, mask=m, beta=1e-5).z_mm)[0] for m in (soft >= 0.5, soft))
    rim = (soft >= 0.5) & (soft < 0.7)
    assert np.abs(p_soft[rim]).mean() < 0.8 * np.abs(p_hard[rim]).mean()


def rolling(side=96):
    _, x = np.mgrid[0 : side + 1, 0 : side + 1]
    return 6 * np.sin(x / 20.0)


@pytest.mark.parametrize("as_height", [True, False])
def test_surface_background_is_held_and_delta_counts_from_it(as_height):
    roll = rolling()
    p, q = height_slopes(roll)
    foreground = dome()[0].foreground
    original = normal_map(p, q)  # the motif is the background itself: nothing may stand out of it but delta
    pitch = 100 / 96
    if as_height:
        background = nm.Height(roll * pitch, np.ones((96, 96), bool), nm.Frame(96, 96, pitch))
    else:
        background, roll = normal_map(p, q), roll - roll.min()
    same = solve(original, background="surface", surface=background, mask=foreground, delta=0.0, tolerance=1e-12)
    assert np.abs(same.z_mm - roll * pitch).max() < 1e-6 * np.ptp(roll)
    raised = solve(original, background="surface", surface=background, mask=foreground, delta=20.0, beta=1.0)
    above = raised.z_mm / pitch - roll
    assert np.abs(above[touching(~foreground)]).max() < 1e-6
    assert above[48, 48] == pytest.approx(20 * 0.096, rel=0.02)
    exact = solve(original, background="surface", surface=background, mask=foreground, height=nm.length("3mm"))
    assert np.ptp(exact.z_mm - roll * pitch) == pytest.approx(3, abs=1e-6)
    assert exact.report.relief_range_mm == pytest.approx(3, abs=1e-6)


def test_free_background_follows_its_own_normals():
    roll = rolling()
    relief = solve(normal_map(*height_slopes(roll)), background="free", beta=0.0)
    z = relief.z_mm / relief.pitch_mm
    assert np.abs((z - z.mean()) - (roll - roll.mean())).max() < 1e-6 * np.ptp(roll)
    assert relief.mask.all()
    assert any("delta has no effect" in warning for warning in relief.report.warnings)


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


def test_size_comes_from_width_file_or_assumption():
    original = dome()[0]
    assert solve(original).pitch_mm == pytest.approx(100 / 96)
    assert solve(original).report.pitch_from == "assumed"
    known = dataclasses.replace(original, frame=nm.Frame(96, 96, 0.25))
    assert (solve(known).pitch_mm, solve(known).report.pitch_from) == (0.25, "file")
    given = solve(known, width=nm.length("48mm"))
    assert (given.pitch_mm, given.report.pitch_from) == (0.5, "given")
    assert np.allclose(given.z_mm, 2 * solve(known).z_mm)


def test_report_says_what_was_done():
    original, _, detail = dome(bumps=1)
    relief = solve(original, detail, mu=0.2, beta=0.01, delta=10.0)
    report = relief.report
    assert report.solver == "amg"
    assert report.unknowns == (touching(relief.foreground) & ~touching(~relief.foreground)).sum()
    assert (report.islands, report.floating_islands) == (1, 0)
    assert report.reach_px == pytest.approx(np.sqrt(1.2 / 0.01) * 0.096)
    assert report.reach_mm == pytest.approx(report.reach_px * relief.pitch_mm)
    inside = relief.z_mm[touching(relief.foreground)]
    assert report.below_background_share == (inside < 0).mean()
    assert report.to_dict()["options"]["mu"] == 0.2
    assert solve(original, beta=0.0, background="cut").report.to_dict()["reach_px"] is None
    assert solve(dome(kind="full")[0]).report.solver == "dct"


def test_inputs_are_never_changed():
    original, _, detail = dome(bumps=1)
    before = [a.copy() for a in (original.normals, original.coverage, original.foreground, detail.normals)]
    solve(original, detail)
    for array, copy in zip(
        (original.normals, original.coverage, original.foreground, detail.normals), before, strict=True
    ):
        assert np.array_equal(array, copy)


def test_misfits_are_named():
    original, small = dome()[0], dome(40)[0]
    with pytest.raises(InputError, match="map is 96 x 96 pixels but the detail map map is 40 x 40; make them the same"):
        solve(original, small)
    with pytest.raises(InputError, match="but the mask is 40 x 40"):
        solve(original, mask=small.foreground)
    with pytest.raises(InputError, match="but the curved background is 40 x 40"):
        solve(original, background="surface", surface=small)
    for name in ("mu", "beta", "delta"):
        with pytest.raises(InputError, match=f"but the {name} map is 40 x 40"):
            solve(original, **{f"{name}_map": small.coverage})
    with pytest.raises(InputError, match="the beta map must be finite and not negative"):
        solve(original, beta_map=np.full((96, 96), -1, np.float32))
    with pytest.raises(InputError, match="the delta map must be finite"):
        solve(original, delta_map=np.full((96, 96), np.nan, np.float32))
    with pytest.raises(InputError, match="the mask selects nothing"):
        solve(original, mask=np.zeros((96, 96)))
    with pytest.raises(InputError, match="the mask selects only background"):
        solve(original, mask=~original.foreground)
    with pytest.raises(InputError, match="every pixel is background"):
        solve(dataclasses.replace(original, foreground=np.zeros((96, 96), bool)))
    with pytest.raises(InputError, match="a curved background must be defined everywhere"):
        solve(original, background="surface", surface=original)
    with pytest.raises(UsageError, match="--background surface: needs the curved background"):
        solve(original, background="surface")
    with pytest.raises(UsageError, match="--surface: only goes with --background surface, not plane"):
        solve(original, surface=original)


def test_domain_of_each_background():
    foreground = np.zeros((5, 6), bool)
    foreground[1:4, 2:5] = True
    covered = np.ones((5, 6), bool)
    covered[0] = False
    plane = lay_out("plane", foreground, covered)
    assert plane.surface.all()
    assert (~plane.held).sum() == 4  # the inner vertices of 3 x 3 faces
    cut, free = lay_out("cut", foreground, covered), lay_out("free", foreground, covered)
    assert np.array_equal(cut.acting, foreground)
    assert np.array_equal(free.acting, covered)
    assert not (cut.held.any() or free.held.any())
    targets = aim(normal_map(*np.zeros((2, 5, 6))), None, free, Weights(0, 0.4, 1.0), 3.0, "eq6")
    assert np.array_equal(targets.beta, 0.1 * corner_sum(foreground.astype(float)))
