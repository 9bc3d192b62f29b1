"""``nmap compose stack``."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from nmaptool.core.units import Length
from nmaptool.options import CanvasOptions, ReadOptions, WriteOptions
from nmaptool.options.fields import Options, option
from nmaptool.options.kinds import SignedText
from nmaptool.options.length_kinds import LengthText
from nmaptool_cli.command import command
from nmaptool_cli.compose.edits import finish_edit
from nmaptool_cli.compose.recipes import errors_of
from nmaptool_cli.outputs import PlacedOutputs
from nmaptool_cli.run import Run
from nmaptool_cli.streams import STREAM

if TYPE_CHECKING:
    import nmaptool as nm


@dataclass(frozen=True)
class RecipeFolder(Options, group="Inputs"):
    """The folder of the recipe's files.

    Parameters
    ----------
    folder:
        Folder that the recipe's file names are relative to. Default: the folder of the recipe; for standard input, the
        current folder.
    """

    folder: Path | None = option(None)


@dataclass(frozen=True)
class StackCanvas(Options, group="Canvas"):
    """Replaces the canvas of the recipe.

    Parameters
    ----------
    size:
        Size of the canvas, columns x rows in pixels. Default: the recipe's size, otherwise that of the lowest layer.
    width:
        Width of the whole picture, such as 100mm. Default: the recipe's width, otherwise that of the lowest layer.
    """

    size: str | None = option(None, SignedText("1000x900"))
    width: Length | None = option(None, LengthText("100mm"))


@command(RecipeFolder, PlacedOutputs, WriteOptions, StackCanvas, ReadOptions)
def stack(run: Run, recipe: str, /) -> None:
    """Compose the layers of a recipe.

    A recipe has any number of layers, in groups or not, each with its position, mode, strength and mask. All keys are
    described in docs/recipes.md.

    Example: nmap compose stack scene.toml -o scene.exr --report scene.json

    Parameters
    ----------
    recipe:
        TOML file, or a map composed from a recipe, which is stored in its metadata; - reads TOML from standard input.
    """
    flags, reading = run[PlacedOutputs], run[ReadOptions]
    given = CanvasOptions(run[StackCanvas].size, run[StackCanvas].width)
    read = _read(run, recipe)
    canvas = CanvasOptions(given.size or read.canvas.size, given.width or read.canvas.width, read.canvas.ground)
    read = dataclasses.replace(read, canvas=canvas)
    outputs = flags.plan(run[WriteOptions], run.options.json, placed=flags.placed, walls=flags.walls)
    place = Path(read.folder)
    # checked as inputs: none of them may be an output
    run.begin(outputs, recipe=recipe, files=tuple(str(place / name) for name in (*read.sources, *read.files)))
    import nmaptool as nm
    from nmaptool.io.output.composition import composed_map

    with run.progress() as progress:
        layers = nm.read_stack(read, reading)
        with errors_of(layers):
            limit = reading.max_megapixels
            result = nm.compose(layers.layers, layers.canvas, max_megapixels=limit, progress=progress)
    flags.check_walls(result)
    written = composed_map(result, nm.to_toml(layers.recipe))
    files = {"recipe": recipe, "recipes": list(read.sources), "layers": list(read.files)}
    facts = {"outside": list(layers.outside), "hidden": list(read.hidden), "notes": list(read.notes)}
    more = list(notes_of(layers))
    finish_edit(run, outputs, result, layers.maps, written=written, more=more, files=files, **facts)


def _read(run: Run, recipe: str) -> nm.Recipe:
    """The recipe, with the recipes that it includes."""
    import nmaptool as nm

    folder = run[RecipeFolder].folder
    if recipe == STREAM and folder is None:
        folder = Path()
    run.begin(recipe=recipe)
    with run.work() as (files, _):
        limit = run[ReadOptions].max_megapixels
        return nm.read_recipe(files["recipe"], folder=folder, name=recipe, max_megapixels=limit)


def notes_of(layers: nm.Stack) -> Iterator[str]:
    """Hidden layers, notes, and files outside the recipe's folder."""
    for label in layers.recipe.hidden:
        yield f"{label}: hidden, left out"
    for note in layers.recipe.notes:
        yield f"nmap: warning: {note}"
    for name in layers.outside:
        yield f"nmap: warning: {layers.recipe.name}: reads {name}, which is outside the recipe's folder"
