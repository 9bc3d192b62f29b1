"""The two Gaussians that model the residuals of a filter (paper, Sec. 3.1)."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.types.shown import OneLine


@dataclass(frozen=True)
class Gaussian:
    """One component of the mixture: its weight, and the mean and standard deviation of its residual lengths."""

    weight: float
    mean: float
    sigma: float

    def density(self, x: Float64) -> Float64:
        """Weighted density at residual lengths; 0 everywhere if all residuals are equal."""
        if self.sigma <= 0:
            return np.zeros_like(x)
        peak = self.weight / (self.sigma * np.sqrt(2 * np.pi))
        return np.asarray(peak * np.exp(-0.5 * ((x - self.mean) / self.sigma) ** 2))


@dataclass(frozen=True, eq=False, repr=False)
class Mixture(OneLine):
    """Lengths of residuals, the two Gaussians that model them, and the threshold (paper, Sec. 3.1 and Fig. 5).

    Attributes
    ----------
    edges : (B+1,) float64
        Edges of the histogram bins, 0 to 2.
    density : (B,) float64
        Share of the area per unit of length; integrates to 1.
    low, high : Gaussian
        Residuals of the base and of detail: the components with the lower and the higher mean.
    theta : float
        Residuals longer than this are detail.
    form : str
        Where theta lies. ``weighted``: where the weighted densities cross between the means; ``unweighted``: where the
        unweighted ones do; ``midpoint``: halfway, because neither cross there; ``none``: all residuals are equal, so
        nothing is detail.
    iterations : int
        Iterations of expectation maximisation.
    """

    edges: Float64
    density: Float64
    low: Gaussian
    high: Gaussian
    theta: float
    form: str
    iterations: int

    def to_dict(self) -> dict[str, Any]:
        """Plain values for JSON; the histogram in 100 bins."""
        coarse = self.density.reshape(100, -1).mean(axis=1)
        return {
            "theta": self.theta,
            "form": self.form,
            "iterations": self.iterations,
            "low": dataclasses.asdict(self.low),
            "high": dataclasses.asdict(self.high),
            "histogram": {"from": 0.0, "to": float(self.edges[-1]), "density": [round(float(d), 6) for d in coarse]},
        }

    def _line(self) -> str:
        return f"theta {self.theta:.4g} ({self.form}), means {self.low.mean:.4g} and {self.high.mean:.4g}"
