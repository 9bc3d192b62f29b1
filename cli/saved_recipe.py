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
    import nmaptool as nm
    from nmaptool.composition.recipe_toml import to_toml

    own = Path.cwd() if sources.recipe is None else Path(sources.recipe.folder or ".").absolute()
    folder = own if str(place) == STREAM else place.absolute().parent
    recipe, files = _of_maps(run, name, sources, folder) if sources.recipe is None else _of_recipe(sources, folder)
    relief = nm.RecipeRelief(
        files,
        {key: value for key, value in _changed(sources.options, ReliefOptions).items() if key in RELIEF_KEYS},
        _changed(sources.solid, SolidOptions),
    )
    # files of flags are relative to the current folder for maps, and absolute for a recipe
    named = sources.plate.renamed(
        lambda file: _relative(file, folder) if sources.recipe is None or Path(file).is_absolute() else file
    )
    return to_toml(dataclasses.replace(recipe, relief=relief, plate=_plate(named)))


def print_recipe(text: str) -> None:
    """Write a recipe to standard output."""
    with standard_output() as stream:
        stream.write(text.encode())


def _of_maps(run: Run, name: str, sources: Sources, folder: Path) -> tuple[nm.Recipe, ReliefFiles]:
    import nmaptool as nm

    if name == STREAM:
        raise UsageError("`save_recipe`: a recipe names its map; give a file instead of standard input")
    reading = {key: value for key, value in run.named(ReadOptions).items() if key in READ_KEYS}
    files = {role: None if file is None else _relative(file, folder) for role, file in sources.files.items()}
    return nm.Recipe((nm.RecipeLayer(_relative(name, folder), read=reading),)), ReliefFiles(**files)


def _of_recipe(sources: Sources, folder: Path) -> tuple[nm.Recipe, ReliefFiles]:
    recipe = sources.recipe
    assert recipe is not None  # the caller asks only then
    assert recipe.relief is not None  # made of the flags
    if folder != Path(recipe.folder or ".").absolute():
        raise UsageError(
            f"`save_recipe`: file names in {recipe.name} are relative to its folder; save the new recipe beside it"
        )
    files = {
        role: _relative(file, folder) if file is not None and Path(file).is_absolute() else file
        for role, file in vars(recipe.relief.files).items()
    }
    return recipe, ReliefFiles(**files)


def _plate(plate: nm.RecipePlate) -> nm.RecipePlate:
    import nmaptool as nm

    return nm.RecipePlate(
        _changed(PlateOptions(**plate.plate), PlateOptions),
        _changed(FrameOptions(**plate.frame), FrameOptions),
        tuple(_changed(TextOptions(**text), TextOptions) for text in plate.texts),
        _changed(plate.machine_options, MachineOptions),
    )


def _changed(made: Options, options: type[Options]) -> dict[str, Any]:
    """The values that are not the defaults."""
    default = options()
    found: Mapping[str, Any] = {f.name: getattr(made, f.name) for f in fields(options)}
    return {name: value for name, value in found.items() if value != getattr(default, name)}


def _relative(file: str, folder: Path) -> str:
    try:
        return Path(os.path.relpath(file, folder)).as_posix()
    except ValueError:  # on another drive of Windows
        return Path(file).absolute().as_posix()
