"""Two Gaussians fitted to a histogram, and the threshold between them."""

import numpy as np
import pytest

from nmaptool.figures.mixture import mixture_plot
from nmaptool.filters.mixture import crossing, fit_mixture
from nmaptool.types.mixture import Gaussian


def drawn(*parts, seed=0):
    """Random lengths drawn from Gaussians (count, mean, sigma)."""
    random = np.random.default_rng(seed)
    lengths = np.concatenate([random.normal(mean, sigma, count) for count, mean, sigma in parts])
    return np.abs(lengths).clip(0, 2)


def test_the_parts_of_a_mixture_are_found():
    lengths = drawn((60_000, 0.2, 0.03), (40_000, 0.7, 0.1))
    found = fit_mixture(lengths, np.ones(len(lengths)))
    assert (found.low.weight, found.high.weight) == (pytest.approx(0.6, abs=0.005), pytest.approx(0.4, abs=0.005))
    assert (found.low.mean, found.high.mean) == (pytest.approx(0.2, abs=0.002), pytest.approx(0.7, abs=0.004))
    assert (found.low.sigma, found.high.sigma) == (pytest.approx(0.03, rel=0.02), pytest.approx(0.1, rel=0.02))
    assert found.form == "weighted"
    assert 0.28 < found.theta < 0.42
    width = np.diff(found.edges)
    assert (found.density * width).sum() == pytest.approx(1)
    assert ((found.low.density(found.edges) + found.high.density(found.edges))[:-1] * width).sum() == pytest.approx(
        1, abs=0.01
    )


def test_faces_are_weighted_by_area():
    lengths = drawn((5_000, 0.1, 0.02), (5_000, 0.6, 0.05))
    areas = np.where(np.arange(10_000) < 5_000, 3.0, 1.0)
    found = fit_mixture(lengths, areas)
    assert found.low.weight == pytest.approx(0.75, abs=0.003)
    thirds = fit_mixture(np.concatenate([np.repeat(lengths[:5_000], 3), lengths[5_000:]]), np.ones(20_000))
    assert found.theta == pytest.approx(thirds.theta, rel=1e-6)


@pytest.mark.parametrize(
    ("low", "high", "form"),
    [
        (Gaussian(0.7, 0.1, 0.03), Gaussian(0.3, 0.5, 0.1), "weighted"),
        (Gaussian(0.5, 0.1, 0.05), Gaussian(0.5, 0.5, 0.05), "weighted"),  # equal widths make the equation linear
        (Gaussian(0.995, 0.1, 0.05), Gaussian(0.005, 0.2, 0.06), "unweighted"),
        (Gaussian(0.5, 0.1, 0.001), Gaussian(0.5, 0.1003, 1.0), "midpoint"),
    ],
)
def test_theta_is_where_the_densities_cross_between_the_means(low, high, form):
    theta, found = crossing(low, high)
    assert found == form
    assert low.mean < theta < high.mean
    at = np.array([theta])
    ratio = low.density(at) / high.density(at)
    if form == "weighted":
        assert ratio == pytest.approx(1, rel=1e-6)
    elif form == "unweighted":
        assert ratio == pytest.approx(low.weight / high.weight, rel=1e-6)
    else:
        assert theta == (low.mean + high.mean) / 2


@pytest.mark.parametrize("length", [0.0, 0.25, 2.0])
def test_equal_residuals_are_not_detail(length):
    found = fit_mixture(np.full(100, length), np.ones(100))
    assert found.form == "none"
    assert not (np.full(100, length) > found.theta).any()
    assert mixture_plot(found).std() > 0


def test_two_spikes_are_separated():
    found = fit_mixture(np.r_[np.zeros(900), np.full(100, 0.5)], np.ones(1000))
    assert 0 < found.theta < 0.5
    assert found.low.weight == pytest.approx(0.9)


def test_the_figure_shows_the_threshold_at_its_position():
    lengths = drawn((6_000, 0.2, 0.03), (4_000, 0.7, 0.1))
    found = fit_mixture(lengths, np.ones(len(lengths)))
    picture = mixture_plot(found).astype(int)
    red = (picture[..., 0] > 180) & (picture[..., 1] < 80) & (picture[..., 2] < 80)
    column = np.median(np.nonzero(red[200:])[1])
    blue = (picture[..., 2] > 140) & (picture[..., 0] < 80)
    orange = (picture[..., 0] > 230) & (abs(picture[..., 1] - 127) < 30) & (picture[..., 2] < 60)
    tops = [np.nonzero(color.any(axis=1))[0] for color in (blue, orange)]
    assert all(len(rows) for rows in tops)
    assert np.nonzero(blue[100:300])[1].min() < column < np.nonzero(orange[300:500])[1].max()
