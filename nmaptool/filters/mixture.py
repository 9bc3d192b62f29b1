"""The detail threshold: fit two Gaussians to the residual lengths and find where they cross (paper, Sec. 3.1)."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.types.mixture import Gaussian, Mixture

_BINS = 2000
_LONGEST = 2.0  # of a difference of unit vectors
_STEPS = 2000
_SETTLED = 1e-9
# residuals that differ by less (half a degree) come from the facets of a smooth surface, or from rounding
_NOTHING = 0.009


def fit_mixture(lengths: Float64, weights: Float64) -> Mixture:
    """Model residual lengths by two Gaussians and find the threshold.

    Parameters
    ----------
    lengths : (N,) float64
        Lengths |n - nb| in [0, 2].
    weights : (N,) float64
        Areas, so the result does not depend on how finely a surface is divided; not all 0.

    Returns
    -------
    Mixture
    """
    return fit_histogram(*length_histogram(lengths, weights))


def length_histogram(lengths: Float64, weights: Float64) -> tuple[Float64, Float64]:
    """Return the sums of weights, and of weights times lengths, in each bin; those of parts may be added.

    Parameters
    ----------
    lengths, weights : (N,) float64
        As for `fit_mixture`.
    """
    lengths = lengths.clip(0, _LONGEST)
    mass, _ = np.histogram(lengths, _edges(), weights=weights)
    inner, _ = np.histogram(lengths, _edges(), weights=weights * lengths)
    return mass, inner


def _edges() -> Float64:
    return np.linspace(0, _LONGEST, _BINS + 1)


def fit_histogram(mass: Float64, inner: Float64) -> Mixture:
    """Model a histogram of residual lengths, as `length_histogram` makes it, by two Gaussians."""
    edges = _edges()
    total = mass.sum()
    mass = mass / total
    # the means within the bins, so a spike inside one bin keeps its position
    x = np.where(mass > 0, inner / np.where(mass > 0, mass * total, 1), (edges[:-1] + edges[1:]) / 2)
    density = mass / np.diff(edges)
    among = np.cumsum(mass)
    longest, shortest = (float(x[np.searchsorted(among, share)]) for share in (0.999, 0.001))
    spread = longest - shortest
    if spread < _NOTHING:
        only = Gaussian(1.0, float((mass * x).sum()), 0.0)
        return Mixture(edges, density, only, Gaussian(0.0, only.mean, 0.0), _LONGEST, "none", 0)
    low, high, steps = _expect_and_maximise(x, mass)
    theta, form = crossing(low, high)
    return Mixture(edges, density, low, high, theta, form, steps)


def _expect_and_maximise(x: Float64, mass: Float64) -> tuple[Gaussian, Gaussian, int]:
    """Fit two Gaussians to the histogram by EM, starting from Otsu's split."""
    narrowest = 0.5 * _LONGEST / _BINS
    share = np.cumsum(mass)
    moment = np.cumsum(mass * x)
    with np.errstate(divide="ignore", invalid="ignore"):
        between = (moment[-1] * share - moment) ** 2 / (share * (1 - share))
    split = int(np.nanargmax(np.where((share > 0) & (share < 1 - 1e-12), between, -1)))
    belongs = (np.arange(len(x)) <= split).astype(float)
    parts = [(0.5, 0.0, 1.0)] * 2
    before = -np.inf
    steps = 0
    while steps < _STEPS:
        steps += 1
        parts = []
        for part in (belongs, 1 - belongs):
            weight = max(float((mass * part).sum()), 1e-12)
            mean = float((mass * part * x).sum()) / weight
            variance = float((mass * part * (x - mean) ** 2).sum()) / weight
            parts.append((weight, mean, max(float(np.sqrt(variance)), narrowest)))
        logs = [np.log(w) - np.log(s) - 0.5 * ((x - m) / s) ** 2 for w, m, s in parts]
        top = np.maximum(*logs)
        both = top + np.log(np.exp(logs[0] - top) + np.exp(logs[1] - top))
        belongs = np.exp(logs[0] - both)
        likelihood = float((mass * both).sum())
        if abs(likelihood - before) < _SETTLED:
            break
        before = likelihood
    low, high = sorted((Gaussian(*part) for part in parts), key=lambda part: part.mean)
    return low, high, steps


def crossing(low: Gaussian, high: Gaussian) -> tuple[float, str]:
    """Return where two Gaussians have the same density between their means.

    Returns
    -------
    theta, form
        The crossing of the weighted densities, else of the unweighted ones, else the midpoint of the means.
    """
    for form, ratio in (
        ("weighted", low.weight * high.sigma / (high.weight * low.sigma)),
        ("unweighted", high.sigma / low.sigma),
    ):
        a = 0.5 / high.sigma**2 - 0.5 / low.sigma**2
        b = low.mean / low.sigma**2 - high.mean / high.sigma**2
        c = 0.5 * (high.mean / high.sigma) ** 2 - 0.5 * (low.mean / low.sigma) ** 2 + np.log(ratio)
        for root in np.roots([a, b, c] if abs(a) > 1e-12 * abs(b) else [b, c]):
            if abs(root.imag) < 1e-9 and low.mean < root.real < high.mean:
                return float(root.real), form
    return (low.mean + high.mean) / 2, "midpoint"
