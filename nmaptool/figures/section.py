"""A section through a relief as a plot with axes in mm."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Srgb
from nmaptool.shading.section import Section

# the profile is at least this high, as a share of its length; heights are exaggerated for it by one of these factors
_LEAST_SHARE = 0.09
_FACTORS = (1, 2, 5, 10, 20, 50, 100)
_LONGER_SIDE_PX, _DPI = 1200, 100


def exaggeration(length_mm: float, range_mm: float) -> int:
    """The factor by which a plot shows heights larger.

    >>> exaggeration(40, 6), exaggeration(100, 1.2)
    (1, 10)
    """
    fitting = (factor for factor in _FACTORS if range_mm * factor >= _LEAST_SHARE * length_mm)
    return next(fitting, _FACTORS[-1])


def section_figure(cut: Section, back_mm: float, size_px: int | None = None) -> Srgb:
    """Plot a section: the material in grey, axes in mm, and the factor by which heights are exaggerated.

    Parameters
    ----------
    cut : Section
    back_mm : float
        Height of the back.
    size_px : int, optional
        Longer side. Default: 1200.

    Returns
    -------
    (h, w, 3) uint8
        sRGB, for display.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    length = float(np.ptp(cut.along_mm))
    solid = np.isfinite(cut.z_mm)
    low, high = (float(v) for v in (min(back_mm, np.nanmin(cut.z_mm)), np.nanmax(cut.z_mm))) if solid.any() else (0, 1)
    factor = exaggeration(length, high - low)
    wide = (_LONGER_SIDE_PX if size_px is None else size_px) / _DPI
    shown = (high - low) * 1.25 * factor / length
    tall = min(wide, wide * 0.86 * shown + 1.45)
    figure = Figure(figsize=(wide, tall), dpi=_DPI)
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0.62 / wide + 0.02, 0.62 / tall, 0.94 - 0.62 / wide, 1 - 1.12 / tall))
    axes.fill_between(cut.along_mm, cut.z_mm, back_mm, color="#c9c2b8", linewidth=0)
    axes.plot(cut.along_mm, cut.z_mm, color="#3a3530", linewidth=1.2)
    axes.set_aspect(factor)
    margin = 0.12 * (high - low)
    axes.set_xlim(cut.along_mm[0] - 0.02 * length, cut.along_mm[-1] + 0.02 * length)
    axes.set_ylim(low - margin, high + margin)
    axes.set_xlabel(f"{'y' if cut.axis == 'x' else 'x'}, mm")
    axes.set_ylabel("height, mm")
    axes.grid(alpha=0.35)
    scale = "heights to scale" if factor == 1 else f"heights {factor} times exaggerated"
    axes.set_title(f"Section at {cut.axis} = {cut.at_mm:.4g} mm, {scale}", fontsize=10)
    canvas.draw()
    return np.array(canvas.buffer_rgba())[..., :3]
