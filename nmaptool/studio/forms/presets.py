"""Presets of the relief options: those of the library, and the user's own, one recipe each in a folder."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from nmaptool.core.errors import InputError, NmaptoolError, OutputError, UsageError, reason_of
from nmaptool.io.recipes.reader import read_relief
from nmaptool.io.recipes.writer import write_relief_table
from nmaptool.options.fields import read_values
from nmaptool.options.formats import RECIPE_ENDING
from nmaptool.options.plates import FrameOptions, PlateOptions
from nmaptool.options.relief_presets import COVERED, RELIEF_PRESETS, ReliefPreset
from nmaptool.studio.document import Document
from nmaptool.studio.files.store import plain_name
from nmaptool.studio.forms.descriptions import plain
from nmaptool.types.recipe import RecipeRelief
from nmaptool.types.recipe_plate import RecipePlate

# an own preset also keeps the size
_OWN = (*COVERED, "width")
_MOST = 200
_LONGEST_NAME = 60


class Presets:
    """The presets that the studio offers.

    Parameters
    ----------
    folder : Path
        Of the user's own; it is made when the first one is saved.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def message(self) -> dict[str, Any]:
        """Return the message that shows them."""
        return {"kind": "presets", "presets": self.listed()}

    def listed(self) -> list[dict[str, Any]]:
        """Return name, description and kind of every preset, for the page."""
        own = sorted(path.stem for path in self._folder.glob(f"*{RECIPE_ENDING}"))[:_MOST]
        return [
            *(
                {"name": name, "description": preset.description, "is_own": False}
                for name, preset in RELIEF_PRESETS.items()
            ),
            *({"name": name, "description": self._described(name), "is_own": True} for name in own),
        ]

    def values(self, name: str, *, is_own: bool) -> dict[str, Any]:
        """Return the options that a preset sets.

        Raises
        ------
        UsageError
            If there is no such preset.
        InputError, LimitError
            If its file cannot be read, or holds values that are not accepted.
        """
        if not is_own:
            if name not in RELIEF_PRESETS:
                raise UsageError(f"{name!r}: there is no such preset; use one of {', '.join(RELIEF_PRESETS)}")
            return RELIEF_PRESETS[name].values
        relief = self._read(name)
        given = {key: value for key, value in {**relief.options, **relief.solid}.items() if key in _OWN}
        return {**ReliefPreset("", {}).values, **given}

    def plate(self, name: str, present: RecipePlate | None, *, is_own: bool) -> RecipePlate | None:
        """Return the plate that a preset makes; texts and machine of the present one stay.

        A preset for work without a plate removes it with its texts. One of the user's own leaves it as it is.
        """
        if is_own:
            return present
        preset, present = RELIEF_PRESETS[name], present or RecipePlate()
        if not preset.plate:
            return RecipePlate(machine=present.machine) if present.machine else None
        plate, frame = read_values(PlateOptions, preset.plate), read_values(FrameOptions, preset.frame)
        return RecipePlate(plate, frame, present.texts, present.machine)

    def save(self, name: str, document: Document, *, overwrite: bool = False) -> None:
        """Keep the options of a document under a name.

        Raises
        ------
        InputError
            If the name is not one, or there is such a preset and ``overwrite`` is False.
        OutputError
            If the file cannot be written.
        """
        path = self._path(name)
        if name.strip() in RELIEF_PRESETS:
            raise InputError(f"{name.strip()}: is the name of a preset that comes with nmaptool; choose another one")
        if path.exists() and not overwrite:
            raise InputError(f"{path.stem}: there is a preset with this name; choose another one, or replace it")
        relief = RecipeRelief(
            options={key: value for key, value in document.relief.options.items() if key in _OWN},
            solid={key: value for key, value in document.relief.solid.items() if key in _OWN},
        )
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputError(f"{self._folder}: cannot be made ({reason_of(error)})") from None
        write_relief_table(relief, path, overwrite=overwrite)

    def delete(self, name: str) -> None:
        """Delete one of the user's own.

        Raises
        ------
        InputError
            If there is none with this name.
        OutputError
            If it cannot be deleted.
        """
        path = self._path(name)
        if not path.is_file():
            raise InputError(f"{path.stem}: there is no preset of yours with this name")
        try:
            path.unlink()
        except OSError as error:
            raise OutputError(f"{path}: cannot be deleted ({reason_of(error)})") from None

    def _path(self, name: str) -> Path:
        if not name.strip() or len(name) > _LONGEST_NAME:
            raise InputError(f"give the preset a name of at most {_LONGEST_NAME} letters")
        return self._folder / f"{plain_name(name)}{RECIPE_ENDING}"

    def _read(self, name: str) -> RecipeRelief:
        path = self._path(name)
        if not path.is_file():
            raise InputError(f"{path.stem}: there is no preset of yours with this name")
        return read_relief(path, name=path.name)

    def _described(self, name: str) -> str:
        """What it changes, or why it cannot be used."""
        try:
            relief = self._read(name)
        except NmaptoolError as error:
            return str(error)
        return _changes({**relief.options, **relief.solid})


def _changes(given: Mapping[str, Any]) -> str:
    parts = [f"{name.replace('_', ' ')} {plain(value)}" for name, value in given.items() if name in _OWN]
    return ", ".join(parts) or "every option has its default"
