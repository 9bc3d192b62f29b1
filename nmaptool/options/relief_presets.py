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
    plate, frame : mapping
        Fields of `nmaptool.PlateOptions` and `nmaptool.FrameOptions`.
    """

    description: str
    options: Mapping[str, Any]
    solid: Mapping[str, Any] = field(default_factory=dict)
    plate: Mapping[str, Any] = field(default_factory=dict)
    frame: Mapping[str, Any] = field(default_factory=dict)

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
        "round, very low and crisp, with a rim",
        {"mu": 0.6, "beta": 0.002, "delta": 20.0, "slope_cap": 2.0, "height": "2%"},
        {"base": "4%"},
        {"shape": "round", "margin": "2%"},
        {"frame": "3.5%", "frame_height": "2.2%"},
    ),
    "medal": ReliefPreset(
        "round and low, with rounded forms, clear detail and a row of beads",
        {"mu": 0.3, "beta": 0.001, "delta": 25.0, "slope_cap": 3.0, "height": "4%"},
        {"base": "3%"},
        {"shape": "round", "margin": "3%"},
        {"frame": "5%", "frame_height": "3%", "frame_profile": "bead"},
    ),
    "cameo": ReliefPreset(
        "oval; the motif stands on its ground with a sharp edge, in a half-round frame",
        {"mu": 0.2, "beta": 0.0008, "delta": 40.0, "slope_cap": 4.0, "height": "5%", "edge": "wall"},
        {"base": "3%"},
        {"shape": "oval", "aspect": "3:4", "margin": "3%"},
        {"frame": "5%", "frame_height": "4%", "frame_profile": "round"},
    ),
    "plaque": ReliefPreset(
        "rectangular with round corners; fuller forms, to be seen from a few steps away",
        {"mu": 0.2, "beta": 0.0005, "delta": 30.0, "slope_cap": 3.0, "height": "6%"},
        {"base": "4%"},
        {"shape": "rect", "corner": "5%", "margin": "4%"},
        {"frame": "4%", "frame_height": "4%", "frame_profile": "bevel"},
    ),
    "pendant": ReliefPreset(
        "round and low, with a loop",
        {"mu": 0.4, "beta": 0.001, "delta": 25.0, "slope_cap": 3.0, "height": "4%"},
        {"base": "4%"},
        {"shape": "round", "margin": "3%", "loop": "9%"},
        {"frame": "5%", "frame_height": "4%", "frame_profile": "rope"},
    ),
    "tile": ReliefPreset(
        "square; the picture covers it, inside a flat border",
        {"mu": 0.2, "beta": 0.0005, "delta": 30.0, "slope_cap": 3.0, "height": "5%"},
        {"base": "6%"},
        {"shape": "rect", "aspect": "1:1", "fill": "cover"},
        {"frame": "3%", "frame_height": "5%"},
    ),
    "box-lid": ReliefPreset(
        "rectangular with round corners, hollow from below, so that it sits on a box",
        {"mu": 0.2, "beta": 0.0005, "delta": 30.0, "slope_cap": 3.0, "height": "5%"},
        {"base": "8%", "hollow": "2.5%"},
        {"shape": "rect", "corner": "6%", "margin": "4%"},
        {"frame": "3.5%", "frame_height": "3%", "frame_profile": "round"},
    ),
    "wood-panel": ReliefPreset(
        "deep and soft, without slopes that a ball-nose cutter cannot reach",
        {"mu": 0.05, "beta": 0.0003, "delta": 40.0, "slope_cap": 1.5, "height": "7%"},
        {"base": "6%"},
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
        preset = RELIEF_PRESETS[self.preset]
        values = {**preset.values, **preset.plate, **preset.frame}
        return {name: value for name, value in values.items() if name in names}
