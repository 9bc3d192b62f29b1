"""How a relief changes with its options: the trends of the paper's Fig. 16, exact heights, resolution."""

import dataclasses

import numpy as np
import pytest
from relief_cases import dome, foreground_heights, normal_map, solve

import nmaptool as nm
from nmaptool.core.errors import InputError
from nmaptool.core.grid import height_slopes, touching_vertices
from nmaptool.reliefs.domain import build_domain
from nmaptool.reliefs.targets import Weights, build_targets
from nmaptool.solver import QuadSystem, prepare


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
    """Slope energy in the frequency band of the bumps and below it."""
    z = np.where(touching_vertices(relief.foreground), relief.z_mm, 0)
    p, q = height_slopes(z)
    spectrum = sum(np.abs(np.fft.fft2(s * np.hanning(len(s))[:, None] * np.hanning(len(s)))) ** 2 for s in (p, q))
    frequency = np.hypot(*np.meshgrid(*[np.fft.fftfreq(len(p)) * len(p)] * 2))
    return spectrum[(frequency > 12) & (frequency < 24)].sum(), spectrum[frequency < 8].sum()


def test_larger_mu_strengthens_detail_relative_to_base():
    original, _, detail = dome(bumps=1)
    weights = np.array([0.0, 0.1, 0.5, 2.0])
    ratios = []
    for mu in weights:
        fine, coarse = band_energies(solve(original, detail, mu=float(mu), beta=1e-8))
        ratios.append(fine / coarse)
    assert np.all(np.diff(ratios) > 0)
    # with a long reach, only mu matters: base slopes shrink by 1 + mu, detail keeps its size
    assert np.allclose(np.array(ratios) / ratios[0], (1 + weights) ** 2, rtol=0.05)
    near = [np.divide(*band_energies(solve(original, detail, mu=float(mu), beta=1e-3, delta=10.0))) for mu in weights]
    assert np.all(np.diff(near) > 0)


def test_the_base_alone_keeps_the_structure_without_the_detail():
    original, base, _ = dome(bumps=1)
    fine, coarse = band_energies(solve(original))
    fine_base, coarse_base = band_energies(solve(base))
    assert fine_base < 0.05 * fine
    assert coarse_base == pytest.approx(coarse, rel=0.1)


def test_a_held_plate_is_flat_and_heights_are_linear_in_delta():
    original = dome(bumps=1)[0]
    at = [solve(original, delta=d, tolerance=1e-13).z_mm for d in (0.0, 7.0, 21.0)]
    assert np.abs((at[2] - at[0]) - 3 * (at[1] - at[0])).max() < 1e-9 * np.ptp(at[2])
    for z in at:
        assert not z[touching_vertices(~original.foreground)].any()


def test_a_relief_without_held_vertices_shifts_by_delta():
    original = dome(bumps=1)[0]
    for background in ("free", "cut"):
        low, high = (solve(original, background=background, delta=d, tolerance=1e-12) for d in (0.0, 10.0))
        inside = low.height.vertex_mask
        assert np.allclose((high.z_mm - low.z_mm)[inside], 10 * 100 / 1000, atol=1e-7)


def test_held_outline_carves_no_groove():
    """A free outline between the flat plate and the steep motif would sink below the plate."""
    side = 96
    original = dome(side, base=2.0)[0]
    fg = original.foreground
    domain = build_domain("plane", fg, fg)
    weights = Weights(0.0, 0.001 / 0.096**2, 20 * 0.096)
    everywhere = dataclasses.replace(domain, acting=np.ones_like(fg), held=~touching_vertices(fg))
    depth = {}
    for name, layout in (("free outline", everywhere), ("held outline", domain)):
        targets = build_targets(original, None, layout, weights, 3.0, "eq6")
        solver = prepare(QuadSystem(targets.weight, targets.beta, layout.held))
        z = solver.solve(targets.shape_load(None) + weights.delta * targets.pull).z
        rim = touching_vertices(fg) & touching_vertices(~fg)
        depth[name] = z[rim].min()
    assert depth["free outline"] < -0.2
    assert depth["held outline"] == 0


@pytest.mark.parametrize("fit", ["scale", "slope", "delta"])
@pytest.mark.parametrize("background", ["plane", "cut"])
def test_the_height_is_exact(fit, background):
    original = dome(bumps=1)[0]
    if fit == "delta" and background == "cut":
        with pytest.raises(InputError, match="changing delta does not change the height, which is"):
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


def test_an_unreachable_height_names_the_least_one():
    original = dome(bumps=1)[0]
    with pytest.raises(InputError, match=r"`height='0.01mm'`: changing delta alone gives at least") as e:
        solve(original, height=nm.length("0.01mm"), fit="delta")
    least = float(str(e.value).split("gives at least ")[1].split()[0])
    reached = solve(original, height=nm.Length(least * 1.001, "mm"), fit="delta")
    assert reached.report.height_range_mm == pytest.approx(least, rel=2e-3)


def test_a_flat_relief_cannot_be_scaled():
    flat = normal_map(*np.zeros((2, 20, 20)))
    with pytest.raises(InputError, match="the relief is flat, so no factor gives it a height"):
        solve(flat, height=nm.length("3mm"))


def test_the_shape_is_the_same_at_500_and_1000_px():
    low, high = (solve(dome(side, bumps=1)[0], height=nm.length("5mm")) for side in (500, 1000))
    difference = low.z_mm - high.z_mm[::2, ::2]
    assert np.sqrt((difference**2).mean()) < 0.02 * 5


def test_fits_never_turn_the_relief_inside_out():
    original = dome(bumps=1)[0]
    with pytest.raises(InputError, match=r"changing the slopes alone gives at least"):
        solve(original, beta=1e-4, delta=200.0, height=nm.length("9mm"), fit="slope")
    for height in ("6mm", "20mm", "40mm"):
        try:
            relief = solve(original, beta=1e-5, height=nm.length(height), fit="delta")
        except InputError as error:
            assert "gives at least" in str(error)
        else:
            assert relief.report.delta_px >= 0
    engraved = solve(original, beta=0.01, delta=-20.0, height=nm.length("12mm"), fit="delta")
    assert engraved.report.delta_px < 0


def test_nearly_vanishing_slopes_give_a_warning():
    original, options = dome(bumps=1)[0], {"beta": 1e-4, "delta": 200.0, "fit": "slope"}
    with pytest.raises(InputError, match="gives at least") as caught:
        solve(original, height=nm.length("9mm"), **options)
    least = float(str(caught.value).split("gives at least ")[1].split()[0])
    relief = solve(original, height=nm.Length(least * 1.002, "mm"), **options)
    assert 0 < relief.report.scale < 0.05
    assert any("little shape is left" in w or "little of the shape" in w for w in relief.report.warnings)


def test_the_reach_matches_the_energy():
    original, _, detail = dome(bumps=1)
    six, four = (solve(original, detail, mu=3.0, beta=0.01, energy=e).report.reach_px for e in ("eq6", "eq4"))
    assert six == pytest.approx(2 * four)
    assert four == pytest.approx(10 * 0.096)


def test_width_is_horizontal_even_in_tall_images():
    row, col = np.mgrid[0:61, 0:31]
    tall = normal_map(*height_slopes(4 * np.exp(-((col - 15) ** 2 + (row - 30) ** 2) / 40)))
    assert solve(tall, width=nm.length("60mm")).pitch_mm == 2
    relief = solve(tall, width=nm.length("60mm"), height=nm.length("5%"))
    assert relief.report.height_range_mm == pytest.approx(0.05 * 60 * 2)  # of the longer side


@pytest.mark.parametrize("shape", ["plane", "islands", "hole"])
def test_known_surfaces_are_reproduced_exactly(shape):
    row, col = np.mgrid[0:61, 0:81]
    z = {"plane": 0.3 * col - 0.2 * row, "islands": 0.01 * col**2, "hole": 3 * np.sin(col / 9) + 0.2 * row}[shape]
    inside = np.ones((60, 80), bool)
    if shape == "islands":
        inside[:, 38:42] = False
    elif shape == "hole":
        inside[20:30, 30:50] = False
    relief = solve(normal_map(*height_slopes(z), inside), background="cut", beta=0.0, slope_cap=50.0)
    for part in [np.s_[:, :39], np.s_[:, 42:]] if shape == "islands" else [np.s_[:]]:
        on = relief.height.vertex_mask[part]
        error = (relief.z_mm[part] / relief.pitch_mm - z[part])[on]
        # normals are float32: slopes are accurate to about 1e-7
        assert np.ptp(error) < 2e-6 * np.ptp(z)
