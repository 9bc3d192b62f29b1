"""Draw the comparison of two schemes as one figure (paper, Fig. 13)."""

from __future__ import annotations

import textwrap
from pathlib import PurePath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Srgb
from nmaptool.types.comparison import Comparison, RenderedView

_COLORS = {"gsfg": "tab:blue", "poisson": "tab:orange"}
_CURVES = (
    ("tab:blue", "o", "-"),
    ("tab:green", "^", ":"),
    ("tab:cyan", "s", ":"),
    ("tab:orange", "o", "-"),
    ("tab:red", "s", "--"),
)
_MAP = "viridis"


def comparison_figure(comparison: Comparison) -> Srgb:
    """Draw a comparison: rebuilt meshes, vertex deviations in one colour scale, histograms, curves, verdicts."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.ticker import ScalarFormatter

    figure = Figure(figsize=(16, 10.4), dpi=110)
    canvas = FigureCanvasAgg(figure)
    pictures = figure.add_gridspec(2, 2, left=0.02, right=0.555, top=0.88, bottom=0.19, wspace=0.04, hspace=0.3)
    scale = figure.add_gridspec(1, 1, left=0.575, right=0.588, top=0.88, bottom=0.19)
    plots = figure.add_gridspec(2, 1, left=0.685, right=0.98, top=0.9, bottom=0.19, hspace=0.26)
    # the largest deviation may be that of a single vertex, so the colour scale ends at the 99.5th percentile
    top = max(float(np.percentile(each.deviation_mm, 99.5)) for each in comparison.contenders.values())
    for row, (name, each) in enumerate(comparison.contenders.items()):
        view, share = comparison.rendered_views[name], 100 / comparison.diagonal_mm
        _show(figure.add_subplot(pictures[row, 0]), _grey(view), _title(comparison, name))
        first = f"vertex deviation: rms {each.rms_mm:.3g}, largest {each.max_mm:.3g} mm"
        hausdorff = f"Hausdorff {each.hausdorff_mm:.3g} mm"
        second = (
            f"{hausdorff}; rms {each.rms_mm * share:.3g}%, Hausdorff {each.hausdorff_mm * share:.3g}% of the diagonal"
        )
        caption = f"{first}\n{second}"
        _show(figure.add_subplot(pictures[row, 1]), _colored(view, top), caption)
    numbers = ScalarFormatter()
    numbers.set_powerlimits((-2, 4))
    bar = figure.colorbar(_scale(top), cax=figure.add_subplot(scale[0]), extend="max", format=numbers)
    bar.set_label("vertex deviation from the original, mm")
    _histograms(figure.add_subplot(plots[0]), comparison)
    _curves(figure.add_subplot(plots[1]), comparison)
    title = f"{PurePath(comparison.name).name}: {comparison.faces} faces, diagonal {comparison.diagonal_mm:.4g} mm"
    figure.suptitle(f"{title}; both rebuilt to the same base normals", fontsize=14, y=0.965)
    summary = [f"The paper's claim {verdict.summary}." for verdict in comparison.verdicts]
    text = "\n".join(line for each in summary for line in textwrap.wrap(each, 190))
    figure.text(0.03, 0.125, text, fontsize=11, va="top", linespacing=1.5)
    canvas.draw()
    return np.array(canvas.buffer_rgba())[..., :3]


def _title(comparison: Comparison, name: str) -> str:
    each = comparison.contenders[name]
    o = each.options
    stated = "gSfG" if name == "gsfg" else "Poisson"
    pull = "" if o.scheme == "gsfg" else f", closeness {o.closeness:g}"
    steps = "one solve" if o.steps == 1 else f"{o.steps} steps"
    return f"{stated} ({o.scheme}, {steps}{pull})\nmean normal deviation {each.normal_mean_deg:.2f} degrees"


def _show(axes: Any, picture: NDArray[np.float32], title: str) -> None:
    axes.imshow(picture, interpolation="antialiased")
    axes.set_title(title, fontsize=9)
    axes.set_xticks([])
    axes.set_yticks([])
    for side in axes.spines.values():
        side.set_visible(False)


def _halved(samples: NDArray[np.float32]) -> NDArray[np.float32]:
    rows, cols = samples.shape[0] // 2, samples.shape[1] // 2
    return np.asarray(samples[: 2 * rows, : 2 * cols].reshape(rows, 2, cols, 2, -1).mean(axis=(1, 3)))


def _grey(view: RenderedView) -> NDArray[np.float32]:
    seen = np.isfinite(view.deviation_mm)
    light = np.where(seen, view.shade, 1)[..., None] ** 0.8
    return _halved(np.repeat(light, 3, axis=2).astype(np.float32)).clip(0, 1)


def _colored(view: RenderedView, top: float) -> NDArray[np.float32]:
    from matplotlib import colormaps

    seen = np.isfinite(view.deviation_mm)
    share = np.where(seen, view.deviation_mm, 0) / max(top, 1e-300)
    color = colormaps[_MAP](share.clip(0, 1))[..., :3]
    # shaded enough to show the form, but little enough to keep the colours readable
    lit = color * (0.55 + 0.45 * view.shade[..., None])
    return _halved(np.where(seen[..., None], lit, 1).astype(np.float32)).clip(0, 1)


def _scale(top: float) -> Any:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    return ScalarMappable(Normalize(0, max(top, 1e-300)), _MAP)


def _histograms(axes: Any, comparison: Comparison) -> None:
    edges = comparison.edges_deg
    for name, each in comparison.contenders.items():
        stated = "gSfG" if name == "gsfg" else "Poisson"
        label = f"{stated}: mean {each.normal_mean_deg:.2f}, median {each.normal_median_deg:.2f} degrees"
        axes.stairs(100 * each.histogram, edges, color=_COLORS[name], fill=True, alpha=0.25)
        axes.stairs(100 * each.histogram, edges, color=_COLORS[name], label=label, linewidth=1.5)
    axes.set_xlim(0, edges[-1])
    axes.set_xlabel("deviation of face normals from their targets, degrees (the last bar includes all larger ones)")
    axes.set_ylabel("% of the surface")
    axes.legend(frameon=False)


def _curves(axes: Any, comparison: Comparison) -> None:
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    for (name, points), (color, marker, line) in zip(comparison.curves.items(), _CURVES, strict=True):
        ordered = sorted(points, key=lambda p: p.normal_deg)
        x, y = ([getattr(p, key) for p in ordered] for key in ("normal_deg", "rms_mm"))
        axes.plot(x, y, color=color, marker=marker, linestyle=line, label=name, markersize=5)
    for name, each in comparison.contenders.items():
        axes.plot(each.normal_mean_deg, each.rms_mm, "*", color=_COLORS[name], markersize=15, markeredgecolor="black")
    for axis, set_scale in ((axes.xaxis, axes.set_xscale), (axes.yaxis, axes.set_yscale)):
        set_scale("log")
        axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axis.set_major_formatter(FuncFormatter(lambda value, place: f"{value:.4g}"))
        axis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("mean normal deviation, degrees (stars: as shown; lower left is better)")
    axes.set_ylabel("rms vertex deviation, mm")
    axes.legend(frameon=False)
    axes.grid(alpha=0.3, which="both")
