"""Values of the relief options for kinds of work: one table for `nmap relief --preset` and the studio.

Heights and bases are shares of the longer side, so a preset serves every size. Nothing heavy is imported here, so that
``nmap --help`` stays quick.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

from nmaptool.options.fields import Options, option
from nmaptool.options.kinds import Choice
from nmaptool.options.relief import ReliefOptions
from nmaptool.options.solid import SolidOptions


@dataclass(frozen=True)
class ReliefPreset:
    """Values for a kind of work.

    Parameters
    ----------
    description : str
        What the work is and how the values shape it, in one line.
    options, solid : mapping
        Fields of `nmaptool.ReliefOptions` and `nmaptool.SolidOptions`; the others in `COVERED` have their defaults.
    """

    description: str
    options: Mapping[str, Any]
    solid: Mapping[str, Any] = field(default_factory=dict)

    @property
    def values(self) -> dict[str, Any]:
        """A value for every covered option; lengths as text."""
        return {**_defaults(), **self.options, **self.solid}


# what a preset decides: shape, height, outline and solid, but neither the width nor how the solver works
COVERED = (
    *("mu", "beta", "delta", "slope_cap", "energy", "per_pixel", "height", "fit"),
    *("background", "edge", "edge_height", "outline_round"),
    *("base", "shell", "hollow", "max_error", "triangles"),
)


def _defaults() -> dict[str, Any]:
    defaults = {f.name: f.default for options in (ReliefOptions, SolidOptions) for f in fields(options)}
    return {name: defaults[name] for name in COVERED}


RELIEF_PRESETS: dict[str, ReliefPreset] = {
    "coin": ReliefPreset(
        "very low and crisp, on a flat field",
        {"mu": 0.6, "beta": 0.003, "delta": 20.0, "slope_cap": 2.0, "height": "1.5%"},
        {"base": "4%"},
    ),
    "medal": ReliefPreset(
        "low, with rounded forms and clear detail",
        {"mu": 0.3, "beta": 0.001, "delta": 25.0, "slope_cap": 3.0, "height": "4%"},
        {"base": "3%"},
    ),
    "plaque": ReliefPreset(
        "fuller forms, to be seen from a few steps away",
        {"mu": 0.2, "beta": 0.0005, "delta": 30.0, "slope_cap": 3.0, "height": "6%"},
        {"base": "4%"},
    ),
    "wood-panel": ReliefPreset(
        "deep and soft, without slopes that a ball-nose cutter cannot reach",
        {"mu": 0.05, "beta": 0.0003, "delta": 40.0, "slope_cap": 1.5, "height": "7%"},
        {"base": "6%"},
    ),
    "cameo": ReliefPreset(
        "the motif stands on its ground with a sharp edge",
        {"mu": 0.2, "beta": 0.0008, "delta": 40.0, "slope_cap": 4.0, "height": "5%", "edge": "wall"},
        {"base": "3%"},
    ),
    "lithograph-stone": ReliefPreset(
        "almost flat: only outlines and fine detail stand",
        {"mu": 1.0, "beta": 0.02, "delta": 10.0, "slope_cap": 1.5, "height": "0.8%"},
        {"base": "5%"},
    ),
    "game-prop": ReliefPreset(
        "the full form, cut out, with few triangles",
        {"mu": 1.0, "beta": 0.0001, "delta": 30.0, "slope_cap": 6.0, "background": "cut"},
        {"triangles": "50k"},
    ),
}


def _described() -> dict[str, str]:
    return {name: preset.description for name, preset in RELIEF_PRESETS.items()}


@dataclass(frozen=True)
class PresetOptions(Options, group="Relief"):
    """Values to begin with.

    Parameters
    ----------
    preset:
        Values for a kind of work, which other flags change; those of a recipe give way to it.
    """

    preset: str | None = option(None, Choice("coin", _described))

    def values_of(self, options: type[Options]) -> dict[str, Any]:
        """The values that the preset gives to a class of options; none without a preset."""
        if self.preset is None:
            return {}
        names = {f.name for f in fields(options)}
        return {name: value for name, value in RELIEF_PRESETS[self.preset].values.items() if name in names}
