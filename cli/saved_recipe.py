"""The recipe of a run of `nmap relief`, to print, edit and repeat."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nmaptool.core.errors import UsageError
from nmaptool.options import ReadOptions, ReliefFiles, ReliefOptions, SolidOptions
from nmaptool.options.fields import Options
from nmaptool.options.plates import FrameOptions, MachineOptions, PlateOptions, TextOptions
from nmaptool.types.recipe import READ_KEYS, RELIEF_KEYS
from nmaptool_cli.relief_sources import Sources
from nmaptool_cli.run import Run
from nmaptool_cli.streams import STREAM, standard_output

if TYPE_CHECKING:
    import nmaptool as nm


def recipe_text(run: Run, name: str, sources: Sources, place: Path) -> str:
    """The recipe as TOML; values that are defaults are left out.

    Raises
    ------
    UsageError
        If a map comes from standard input, or the recipe would go to another folder than the one it was read from.
    """
    from nmaptool.composition.recipe_toml import to_toml

    folder = Path.cwd() if str(place) == STREAM else place.absolute().parent
    recipe = _of_maps(run, name, sources, folder) if sources.recipe is None else _of_recipe(sources.recipe, folder)
    return to_toml(recipe)


def print_recipe(text: str) -> None:
    """Write a recipe to standard output."""
    with standard_output() as stream:
        stream.write(text.encode())


def _of_maps(run: Run, name: str, sources: Sources, folder: Path) -> nm.Recipe:
    import nmaptool as nm

    if name == STREAM:
        raise UsageError("`save_recipe`: a recipe names its map; give a file instead of standard input")
    reading = {key: value for key, value in run.named(ReadOptions).items() if key in READ_KEYS}
    files = {role: None if file is None else _relative(file, folder) for role, file in sources.files.items()}
    relief = nm.RecipeRelief(
        ReliefFiles(**{f.name: files.get(f.name) for f in fields(ReliefFiles)}),
        {name: value for name, value in _changed(sources.options, ReliefOptions).items() if name in RELIEF_KEYS},
        _changed(sources.solid, SolidOptions),
    )
    layer = nm.RecipeLayer(_relative(name, folder), read=reading)
    return nm.Recipe((layer,), relief=relief, plate=_plate(sources.plate))


def _of_recipe(recipe: nm.Recipe, folder: Path) -> nm.Recipe:
    if folder != Path(recipe.folder or ".").absolute():
        raise UsageError(
            f"`save_recipe`: file names in {recipe.name} are relative to its folder; save the new recipe beside it"
        )
    plate = None if recipe.plate is None else _plate(recipe.plate)
    return dataclasses.replace(recipe, plate=plate)


def _plate(plate: nm.RecipePlate) -> nm.RecipePlate:
    import nmaptool as nm

    texts = tuple(_given(text, TextOptions) for text in plate.texts)
    return nm.RecipePlate(
        _given(plate.plate, PlateOptions),
        _given(plate.frame, FrameOptions),
        texts,
        _given(plate.machine, MachineOptions),
    )


def _given(values: Mapping[str, Any], options: type[Options]) -> dict[str, Any]:
    """Values that differ from the defaults, read."""
    return _changed(options(**values), options)


def _changed(made: Options, options: type[Options]) -> dict[str, Any]:
    default = options()
    found = {f.name: getattr(made, f.name) for f in fields(options)}
    return {name: value for name, value in found.items() if value != getattr(default, name)}


def _relative(file: str, folder: Path) -> str:
    return Path(os.path.relpath(file, folder)).as_posix()
