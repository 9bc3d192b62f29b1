"""The controls of the page: names, help and ranges of the options, derived from the options classes."""

from __future__ import annotations

import dataclasses
import functools
from dataclasses import dataclass
from typing import Any

from nmaptool.options import ReliefOptions, SolidOptions
from nmaptool.studio.forms.descriptions import described


@dataclass(frozen=True)
class Slider:
    """The range of a slider; typed values may lie outside. ``steps`` counts steps from end to end."""

    low: float
    high: float
    is_log: bool = False
    steps: int = 400


# headings and their controls, in the order of the page
GROUPS = {
    "Shape": ("mu", "beta", "delta", "slope_cap", "energy"),
    "Size": ("height", "fit", "width"),
    "Outline": ("background", "edge"),
    "Solid": ("base", "triangles"),
    "Advanced": (
        *("edge_height", "outline_round", "outline", "shell", "hollow", "one_piece", "max_error"),
        *("per_pixel", "solver", "tolerance", "max_iterations"),
    ),
}
# lengths are in mm
SLIDERS = {
    "mu": Slider(0.0, 4.0),
    "beta": Slider(1e-5, 0.1, is_log=True),
    "delta": Slider(-200.0, 200.0),
    "slope_cap": Slider(0.3, 10.0, is_log=True),
    "height": Slider(0.2, 30.0, is_log=True),
    "width": Slider(10.0, 500.0, is_log=True),
    "base": Slider(0.5, 20.0, is_log=True),
}


@functools.cache
def controls() -> list[dict[str, Any]]:
    """Return the description of each control, with its group and its slider."""
    return [_control(group, name) for group, names in GROUPS.items() for name in names]


def _control(group: str, name: str) -> dict[str, Any]:
    is_relief = any(f.name == name for f in dataclasses.fields(ReliefOptions))
    (told,) = described(ReliefOptions if is_relief else SolidOptions, [name])
    slider = SLIDERS.get(name)
    return {"group": group, **told, "slider": None if slider is None else dataclasses.asdict(slider)}
