"""The controls of the page: names, help and ranges of the options, derived from the options classes."""

from __future__ import annotations

import dataclasses
import re
from dataclasses import dataclass
from typing import Any

from nmaptool.core.units import Length
from nmaptool.options import ReliefOptions, SolidOptions
from nmaptool.options.fields import Options, descriptions, kind_of
from nmaptool.options.kinds import Choice, Count, Numeric, Switch


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


def controls() -> list[dict[str, Any]]:
    """Return one mapping for each control: group, name, label, help, kind, default, choices and slider."""
    return [{"group": group, **_control(name)} for group, names in GROUPS.items() for name in names]


def _control(name: str) -> dict[str, Any]:
    options: type[Options] = ReliefOptions if name in _names(ReliefOptions) else SolidOptions
    field = next(f for f in dataclasses.fields(options) if f.name == name)
    kind, slider = kind_of(field), SLIDERS.get(name)
    assert kind is not None
    told = re.sub(r"--([a-z-]+)", lambda flag: flag[1].replace("-", " "), descriptions(options)[name])
    return {
        "name": name,
        "label": name.replace("_", " "),
        "help": told,
        "kind": _kind(kind),
        "default": plain(field.default),
        "example": kind.such_as,
        "choices": list(kind.names) if isinstance(kind, Choice) else [],
        "slider": None if slider is None else dataclasses.asdict(slider),
    }


def _names(options: type[Options]) -> set[str]:
    return {f.name for f in dataclasses.fields(options)}


def _kind(kind: Any) -> str:
    if isinstance(kind, Choice):
        return "choice"
    if isinstance(kind, Switch):
        return "switch"
    if isinstance(kind, Count | Numeric):
        return "number"
    return "length" if type(kind).__name__ == "LengthText" else "text"


def plain(value: Any) -> Any:
    """Return an option's value as JSON holds it: lengths as text."""
    return str(value) if isinstance(value, Length) else value


def plain_options(options: Options) -> dict[str, Any]:
    """Return options as JSON holds them."""
    return {name: plain(value) for name, value in vars(options).items()}
