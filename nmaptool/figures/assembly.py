"""The assembly sheet of a relief in parts: a plan with the name and the size of each."""

from __future__ import annotations

from typing import Any

import numpy as np

from nmaptool.core.arrays import Srgb
from nmaptool.types.parts import Assembly, PlacedPart
from nmaptool.types.shown import counted

_LONGER_SIDE_PX, _DPI = 1600, 100
# inches to the left, to the right, below and above the plan; the least width of the sheet
_EDGES, _LEAST_WIDE = (0.75, 0.25, 0.6, 0.55), 5.0
_LINE, _INK, _PAPER, _LEFT_OUT = "#c2401c", "#1d1a17", "#fbf8f2", "#8d877d"
# sizes of labels in points, and their letters and lines as a share of that
_SMALLEST_PT, _LARGEST_PT, _LETTER, _LINE_HEIGHT = 3.5, 12.0, 0.62, 1.45
_POINTS_PER_INCH = 72
# share of a part that its label fills at most
_ROOM = 0.84


def assembly_picture(assembly: Assembly, picture: Srgb | None = None, size_px: int | None = None) -> Srgb:
    """Draw a plan of the parts with axes in mm, seen from the front.

    Parameters
    ----------
    assembly : Assembly
    picture : (h, w, 3) uint8, optional
        The whole relief, to show below the plan.
    size_px : int, optional
        Longer side. Default: 1600.

    Returns
    -------
    (h, w, 3) uint8
        sRGB, for display.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    width_mm, height_mm = assembly.size_mm
    longer = (_LONGER_SIDE_PX if size_px is None else size_px) / _DPI
    left, right, below, above = _EDGES
    scale = min((longer - left - right) / width_mm, (longer - below - above) / height_mm)
    wide, tall = max(width_mm * scale + left + right, _LEAST_WIDE), height_mm * scale + below + above
    figure = Figure(figsize=(wide, tall), dpi=_DPI)
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((left / wide, below / tall, width_mm * scale / wide, height_mm * scale / tall))
    if picture is not None:
        axes.imshow(picture, extent=(0, width_mm, 0, height_mm), aspect="auto", interpolation="antialiased")
    axes.set_xlim(0, width_mm)
    axes.set_ylim(0, height_mm)
    for x in assembly.cuts_x_mm[1:-1]:
        axes.axvline(x, color=_LINE, linewidth=1.1)
    for y in assembly.cuts_y_mm[1:-1]:
        axes.axhline(height_mm - y, color=_LINE, linewidth=1.1)
    for part in assembly.parts:
        _label(axes, _box(assembly, part.row, part.col), _lines(part), scale)
    for row, col in assembly.left_out:
        _hatch(axes, _box(assembly, row, col))
    axes.set_xlabel("x, mm")
    axes.set_ylabel("y, mm")
    axes.set_title(_title(assembly), fontsize=10.5, loc="left")
    canvas.draw()
    return np.array(canvas.buffer_rgba())[..., :3]


def _box(assembly: Assembly, row: int, col: int) -> tuple[float, float, float, float]:
    """Left, lower, right and upper edge of a part in mm."""
    x, y, tall = assembly.cuts_x_mm, assembly.cuts_y_mm, assembly.size_mm[1]
    return x[col], tall - y[row + 1], x[col + 1], tall - y[row]


def _lines(part: PlacedPart) -> list[str]:
    """What a label says: the files, and the size."""
    names = part.files or (f"{part.row}, {part.col}",)
    return [*names, " x ".join(f"{side:.2f}" for side in part.size_mm) + " mm"]


def _label(axes: Any, box: tuple[float, float, float, float], lines: list[str], scale: float) -> None:
    """Write a label into a part as large as it fits; leave out its last lines where it does not."""
    left, lower, right, upper = box
    across, down = ((side * scale * _ROOM * _POINTS_PER_INCH) for side in (right - left, upper - lower))
    while lines:
        longest = max(len(line) for line in lines)
        size = min(_LARGEST_PT, across / (longest * _LETTER), down / (len(lines) * _LINE_HEIGHT))
        if size >= _SMALLEST_PT:
            paper = {"facecolor": _PAPER, "edgecolor": "none", "alpha": 0.82, "boxstyle": "round,pad=0.25"}
            text, middle = "\n".join(lines), ((left + right) / 2, (lower + upper) / 2)
            axes.text(*middle, text, ha="center", va="center", fontsize=size, color=_INK, bbox=paper)
            return
        lines = lines[:-1]


def _hatch(axes: Any, box: tuple[float, float, float, float]) -> None:
    """Hatch a part that is left out."""
    from matplotlib.patches import Rectangle

    left, lower, right, upper = box
    size = (right - left, upper - lower)
    axes.add_patch(Rectangle((left, lower), *size, fill=False, hatch="//", edgecolor=_LEFT_OUT, linewidth=0))


def _title(assembly: Assembly) -> str:
    wide, tall = assembly.size_mm
    left_out = f", {len(assembly.left_out)} left out (hatched)" if assembly.left_out else ""
    parts = counted(len(assembly.parts), "part")
    return f"{wide:.5g} x {tall:.5g} mm in {assembly.cols} x {assembly.rows}: {parts}{left_out}, seen from the front"
