"""Printers and mills: one table of the values that they set."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from nmaptool.core.units import Length
from nmaptool.options.fields import Options, option
from nmaptool.options.kinds import Choice
from nmaptool.options.length_kinds import LengthText


@dataclass(frozen=True)
class Machine:
    """What a printer or mill sets.

    Parameters
    ----------
    description : str
    values : mapping
        Fields of `MachineOptions` and `nmaptool.SolidOptions`; lengths as text.
    is_ball : bool
        Whether its tool is a ball, which makes sharp ridges, but no sharp grooves.
    """

    description: str
    values: Mapping[str, str]
    is_ball: bool = False

    @property
    def listed(self) -> str:
        """The values as text, such as "pitch 0.1mm, base 2mm"."""
        return ", ".join(f"{name.replace('_', ' ')} {value}" for name, value in self.values.items())


MACHINES: dict[str, Machine] = {
    "fdm-0.4": Machine(
        "filament printer with a 0.4 mm nozzle",
        {"pitch": "0.1mm", "base": "2mm", "max_error": "0.02mm", "finest": "0.4mm"},
    ),
    "resin-0.05": Machine(
        "resin printer with pixels of 0.05 mm",
        {"pitch": "0.05mm", "base": "1.5mm", "max_error": "0.005mm", "finest": "0.1mm"},
    ),
    "cnc-3mm": Machine(
        "mill that finishes with a ball nose of 3 mm",
        {"pitch": "0.15mm", "base": "6mm", "max_error": "0.01mm", "finest": "3mm"},
        is_ball=True,
    ),
    "laser-254dpi": Machine(
        "laser engraver with 254 dots per inch",
        {"pitch": "0.1mm", "base": "3mm", "max_error": "0.02mm", "finest": "0.2mm"},
    ),
}


def _described() -> dict[str, str]:
    return {name: machine.description for name, machine in MACHINES.items()}


@dataclass(frozen=True)
class MachineOptions(Options, group="Machine"):
    """The machine that makes the relief.

    Parameters
    ----------
    for_:
        Machine that the relief is made on: sets --pitch, --base, --max-error and --finest, unless they are given.
    pitch:
        Size of a pixel of the relief, such as 0.05mm. Finer or coarser maps are resampled. Default: the pixels of the
        map; finer where letters need it.
    finest:
        Width of the finest detail that the machine can make, such as 0.4mm. Finer detail is reported.
    """

    for_: str | None = option(None, Choice("fdm-0.4", _described))
    pitch: Length | None = option(None, LengthText("0.05mm", absolute=True))
    finest: Length | None = option(None, LengthText("0.4mm", absolute=True, sets="the width of the finest detail"))

    @staticmethod
    def values_of(machine: str | None, options: type[Options]) -> dict[str, Any]:
        """The values that a machine gives to a class of options; none without one."""
        if machine is None:
            return {}
        names = {f.name for f in fields(options)}
        return {name: value for name, value in MACHINES[machine].values.items() if name in names}
