"""A section through a relief as a plot with axes in mm."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Srgb
from nmaptool.shading.section import Section

# the profile is at least this high, as a share of its length; heights are exaggerated for it by one of these factors
_LEAST_SHARE = 0.09
_FACTORS = (1, 2, 5, 10, 20, 50, 100)
_LONGER_SIDE_PX, _DPI = 1200, 100
# inches to the left, to the right, below and above the axes; the least height of the axes
_EDGES, _LEAST_TALL = (0.72, 0.2, 0.55, 0.4), 0.5


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
    low, high = min(back_mm, float(np.nanmin(cut.z_mm))), float(np.nanmax(cut.z_mm))
    factor = exaggeration(length, high - low)
    wide = (_LONGER_SIDE_PX if size_px is None else size_px) / _DPI
    beside, around = 0.02 * length, 0.12 * (high - low)
    left, right, below, above = (inches / wide if place < 2 else inches for place, inches in enumerate(_EDGES))
    # both axes have the same scale, but for the factor
    axes_wide = wide * (1 - left - right)
    axes_tall = axes_wide * (high - low + 2 * around) * factor / (length + 2 * beside)
    axes_tall = min(max(_LEAST_TALL, axes_tall), wide - below - above)
    tall = axes_tall + below + above
    figure = Figure(figsize=(wide, tall), dpi=_DPI)
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((left, below / tall, 1 - left - right, axes_tall / tall))
    axes.fill_between(cut.along_mm, cut.z_mm, back_mm, color="#c9c2b8", linewidth=0)
    axes.plot(cut.along_mm, cut.z_mm, color="#3a3530", linewidth=1.2)
    axes.set_aspect(factor)
    axes.set_xlim(cut.along_mm[0] - beside, cut.along_mm[-1] + beside)
    axes.set_ylim(low - around, high + around)
    axes.set_xlabel(f"{'y' if cut.axis == 'x' else 'x'}, mm")
    axes.set_ylabel("height, mm")
    axes.grid(alpha=0.35)
    scale = "heights to scale" if factor == 1 else f"heights {factor} times exaggerated"
    axes.set_title(f"Section at {cut.axis} = {cut.at_mm:.4g} mm, {scale}", fontsize=10)
    canvas.draw()
    return np.array(canvas.buffer_rgba())[..., :3]
