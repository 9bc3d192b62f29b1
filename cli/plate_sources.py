"""The plate of `nmap relief`: what a recipe, the preset and the flags say about it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nmaptool.core.errors import UsageError
from nmaptool.options.plates import FrameOptions, MachineOptions, PlateOptions, TextOptions
from nmaptool.options.plates.frame import PROFILE
from nmaptool.options.plates.plate import SHAPE
from nmaptool.options.plates.text import is_font_file
from nmaptool.options.relief_presets import PresetOptions
from nmaptool_cli.run import Run

if TYPE_CHECKING:
    import nmaptool as nm

# flags that name files, and what tells a file from a name
_FILES = {"shape": SHAPE.is_file, "frame_profile": PROFILE.is_file, "font": is_font_file}

# an option and the values of it that others need
_ONLY_WITH = {
    ("shape", "rect", "oval"): ("aspect",),
    ("shape", "rect"): ("corner",),
    ("text_path", "line"): ("text_at", "text_rotate"),
    ("text_path", "arc", "circle", "ring"): ("text_inset",),
}


def plate_of(run: Run, recipe: nm.Recipe | None) -> nm.RecipePlate:
    """The plate, with the values of a recipe, the preset and the flags; the last ones count.

    A preset that makes a plate replaces the plate and the frame of a recipe, but not its texts and its machine. One for
    work without a plate leaves out all but the machine. The machine sets what is left.

    Raises
    ------
    UsageError
        If a frame or text is given without a plate, or values contradict each other.
    """
    import nmaptool as nm

    own = nm.RecipePlate() if recipe is None else recipe.plate or nm.RecipePlate()
    preset = run[PresetOptions]
    if preset.values_of(PlateOptions):
        own = nm.RecipePlate(preset.values_of(PlateOptions), preset.values_of(FrameOptions), own.texts, own.machine)
    elif preset.preset is not None and recipe is not None and own.plate:
        run.say(f"  the plate of {recipe.name} is left out: the preset {preset.preset} is for work without one")
        own = nm.RecipePlate(machine=own.machine)
    is_elsewhere = recipe is not None
    flags = {
        options: _absolute(run.named(options)) if is_elsewhere else run.named(options)
        for options in (PlateOptions, FrameOptions, TextOptions, MachineOptions)
    }
    plate = {**_kept(own.plate, flags[PlateOptions]), **flags[PlateOptions]}
    for name, other in (("emboss", "engrave"), ("engrave", "emboss")):
        if flags[PlateOptions].get(name):
            plate[other] = flags[PlateOptions].get(other, False)
    frame = {**own.frame, **flags[FrameOptions]}
    machine = {**own.machine, **flags[MachineOptions]}
    texts = _texts(own.texts, flags[TextOptions])
    if plate.get("shape") is None:
        given = next((name for name, value in frame.items() if value is not None), None) or ("text" if texts else None)
        if given is not None:
            raise UsageError(f"`{given}`: needs a plate, such as `shape='round'`")
    return nm.RecipePlate(plate, frame, texts, machine)


def _absolute(flags: Mapping[str, Any]) -> dict[str, Any]:
    """Flags for a recipe: their files are relative to the current folder, those of the recipe to its own."""
    return {
        name: str(Path(value).absolute()) if name in _FILES and _FILES[name](value) else value
        for name, value in flags.items()
    }


def _texts(own: tuple[Mapping[str, Any], ...], flags: Mapping[str, Any]) -> tuple[Mapping[str, Any], ...]:
    """A text on the command line replaces those of a recipe; without one, its other flags change all of them."""
    if "text" in flags:
        return (flags,)
    if flags and not own:
        raise UsageError(f"`{next(iter(flags))}`: needs a text, such as `text='ANNO MMXXVI'`")
    return tuple({**_kept(text, flags), **flags} for text in own)


def _kept(own: Mapping[str, Any], flags: Mapping[str, Any]) -> dict[str, Any]:
    """Values of a preset or recipe, without those that have no meaning for the shape or path of the flags."""
    dropped: set[str] = set()
    for (name, *accepted), others in _ONLY_WITH.items():
        if name in flags and flags[name] not in accepted:
            dropped |= set(others)
    return {name: value for name, value in own.items() if name not in dropped}
