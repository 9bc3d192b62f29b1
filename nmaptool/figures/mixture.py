"""Draw the lengths of residuals, the two Gaussians and the threshold (paper, Fig. 5)."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Srgb
from nmaptool.types.mixture import Mixture

_BARS = 100


def mixture_plot(mixture: Mixture) -> Srgb:
    """Draw a mixture."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 4.5), dpi=150, layout="constrained")
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    end = _end(mixture)
    bars = np.linspace(0, end, _BARS + 1)
    mass = np.concatenate([[0], np.cumsum(mixture.density * np.diff(mixture.edges))])
    share = np.diff(np.interp(bars, mixture.edges, mass))
    axes.bar(bars[:-1], share / np.diff(bars), np.diff(bars), align="edge", color="0.82", label="residuals")
    x = np.linspace(0, end, 600)
    low, high = mixture.low.density(x), mixture.high.density(x)
    if mixture.form != "none":
        axes.plot(x, low, color="tab:blue", label=_named("base", mixture.low.mean, mixture.low.weight))
        axes.plot(x, high, color="tab:orange", label=_named("detail", mixture.high.mean, mixture.high.weight))
        axes.plot(x, low + high, color="0.35", linewidth=1, linestyle=":", label="both")
        axes.axvline(mixture.theta, color="tab:red", label=f"theta {mixture.theta:.4f} ({mixture.form})")
    axes.set_xlim(0, end)
    axes.set_ylim(0, 1.15 * float((share / np.diff(bars)).max()))
    axes.set_xlabel("length of the residual |n - filtered n|")
    axes.set_ylabel("share of the surface per unit length")
    axes.legend(frameon=False)
    canvas.draw()
    return np.array(canvas.buffer_rgba())[..., :3]


def _named(name: str, mean: float, weight: float) -> str:
    return f"{name}: mean {mean:.4f}, share {weight:.0%}"


def _end(mixture: Mixture) -> float:
    """Return the end of the x axis: the 99.9th percentile of the histogram, but beyond the threshold."""
    mass = np.cumsum(mixture.density * np.diff(mixture.edges))
    last = float(mixture.edges[1:][np.searchsorted(mass, 0.999 * mass[-1])])
    return min(max(1.1 * last, 0.01, 1.2 * mixture.theta if mixture.form != "none" else 0.0), 2.0)
