"""The tables of a recipe that describe a plate, and the keys in them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any

from nmaptool.core.mentions import written_name
from nmaptool.options.fields import Options
from nmaptool.options.plates import FrameOptions, MachineOptions, PlateOptions, TextOptions
from nmaptool.options.plates.frame import PROFILE
from nmaptool.options.plates.plate import SHAPE
from nmaptool.options.plates.text import is_font_file
from nmaptool.options.solid import SolidOptions
from nmaptool.types.shown import OneLine

# what a machine does not set where one of these is given
_INSTEAD = {"base": ("base", "shell"), "max_error": ("max_error", "triangles")}


@dataclass(frozen=True)
class Table:
    """A table of a recipe.

    Attributes
    ----------
    options : type of Options
        What its keys set.
    prefix : str
        What the fields begin with that the keys leave out.
    renamed : mapping
        Other names of keys, by field.
    """

    options: type[Options]
    prefix: str = ""
    renamed: Mapping[str, str] = field(default_factory=dict)

    def key(self, name: str) -> str:
        """The key of a field."""
        return self.renamed.get(name) or written_name(name).removeprefix(self.prefix)

    @property
    def keys(self) -> dict[str, str]:
        """Fields by their keys."""
        return {self.key(f.name): f.name for f in fields(self.options)}


PLATE_TABLES = {
    "plate": Table(PlateOptions),
    "frame": Table(FrameOptions, "frame_", {"frame": "width"}),
    "text": Table(TextOptions, "text_"),
    "machine": Table(MachineOptions),
}


@dataclass(frozen=True, repr=False)
class RecipePlate(OneLine):
    """The plate of a recipe, as it is given.

    Parameters
    ----------
    plate, frame, machine : mapping
        Fields of `nmaptool.PlateOptions`, `nmaptool.FrameOptions` and `nmaptool.MachineOptions`.
    texts : tuple of mapping
        Fields of `nmaptool.TextOptions` for each text.

    Raises
    ------
    UsageError
        If a value is not accepted, or values contradict each other.
    """

    plate: Mapping[str, Any] = field(default_factory=dict)
    frame: Mapping[str, Any] = field(default_factory=dict)
    texts: tuple[Mapping[str, Any], ...] = ()
    machine: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        PlateOptions(**self.plate)
        FrameOptions(**self.frame)
        MachineOptions(**self.machine)
        for text in self.texts:
            TextOptions(**text)

    @property
    def machine_options(self) -> MachineOptions:
        """The machine, with what it sets where nothing else is given."""
        return MachineOptions(**{**MachineOptions.values_of(self.machine.get("for_"), MachineOptions), **self.machine})

    def solid_values(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Fields of `nmaptool.SolidOptions`: those given, and what the machine sets besides."""
        values = MachineOptions.values_of(self.machine.get("for_"), SolidOptions)
        known = {name: value for name, value in given.items() if value is not None}
        beside = {name: value for name, value in values.items() if not any(each in known for each in _INSTEAD[name])}
        return {**given, **beside}

    def renamed(self, new: Callable[[str], str]) -> RecipePlate:
        """The same with other names of its files: drawings and font files."""
        plate, frame = dict(self.plate), dict(self.frame)
        for given, name, kind in ((plate, "shape", SHAPE), (frame, "frame_profile", PROFILE)):
            if given.get(name) is not None and kind.is_file(given[name]):
                given[name] = new(given[name])
        texts = (
            {**text, "font": new(text["font"])} if is_font_file(text.get("font", "")) else text for text in self.texts
        )
        return RecipePlate(plate, frame, tuple(texts), self.machine)

    def _line(self) -> str:
        given = {**self.plate, **self.frame, **self.machine}
        named = [f"{written_name(name)} {value}" for name, value in given.items() if value is not None]
        return ", ".join([*named, *(f"text {text.get('text')!r}" for text in self.texts)]) or "no plate"
