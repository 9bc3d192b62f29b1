"""The plate of `nmap relief`: what the machine, a recipe, the preset and the flags say about it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from nmaptool.core.errors import UsageError
from nmaptool.options.fields import Options
from nmaptool.options.plates import FrameOptions, MachineOptions, PlateOptions, TextOptions
from nmaptool.options.relief_presets import PresetOptions
from nmaptool_cli.run import Run

if TYPE_CHECKING:
    import nmaptool as nm


def machine_values(run: Run, options: type[Options], own: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """What the machine sets; one that is given as a flag replaces that of a recipe."""
    machine = run[MachineOptions].for_ or (own or {}).get("for_")
    return MachineOptions.values_of(machine, options)


def plate_of(run: Run, recipe: nm.RecipePlate | None) -> nm.RecipePlate:
    """The plate, with the values of the machine, a recipe, the preset and the flags; the last ones count.

    Raises
    ------
    UsageError
        If a frame or text is given without a plate.
    """
    import nmaptool as nm

    own = recipe or nm.RecipePlate()
    plate = {**own.plate, **run[PresetOptions].values_of(PlateOptions), **run.named(PlateOptions)}
    if plate.get("emboss"):
        plate["engrave"] = False
    frame = {**own.frame, **run[PresetOptions].values_of(FrameOptions), **run.named(FrameOptions)}
    machine = {**machine_values(run, MachineOptions, own.machine), **own.machine, **run.named(MachineOptions)}
    texts = _texts(run, own.texts)
    if plate.get("shape") is None:
        given = next((name for name, value in frame.items() if value is not None), None) or ("text" if texts else None)
        if given is not None:
            raise UsageError(f"`{given}`: needs a plate, such as `shape='round'`")
    return nm.RecipePlate(plate, frame, texts, machine)


def _texts(run: Run, own: tuple[Mapping[str, Any], ...]) -> tuple[dict[str, Any], ...]:
    """A text on the command line replaces those of a recipe; without one, its other flags change all of them."""
    named = run.named(TextOptions)
    if "text" in named:
        return (named,)
    if named and not own:
        raise UsageError(f"`{next(iter(named))}`: needs a text, such as `text='ANNO MMXXVI'`")
    return tuple({**text, **named} for text in own)
