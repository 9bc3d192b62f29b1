"""``nmap compose stack``."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from nmaptool.core.errors import NmaptoolError
from nmaptool.core.units import Length
from nmaptool.options import CanvasOptions, ReadOptions, WriteOptions
from nmaptool_cli.compose.outputs import MapOutputs, MapWriter, report_header, say_composition, say_map
from nmaptool_cli.session import COMPOSING, INPUTS, OUTPUTS, READING, RUN, STREAM, RunOptions, Session, input_files

if TYPE_CHECKING:
    import nmaptool as nm
    from nmaptool.core.progress import Progress


def stack(
    recipe: str,
    /,
    *,
    folder: Annotated[Path | None, Parameter(group=INPUTS)] = None,
    outputs: Annotated[MapOutputs, Parameter(name="*", group=OUTPUTS)] = MapOutputs(),
    placed: Annotated[Path | None, Parameter(group=OUTPUTS)] = None,
    writing: Annotated[WriteOptions, Parameter(name="*", group=OUTPUTS)] = WriteOptions(),
    size: Annotated[str | None, Parameter(group=COMPOSING)] = None,
    width: Annotated[Length | None, Parameter(group=COMPOSING)] = None,
    reading: Annotated[ReadOptions, Parameter(name="*", group=READING)] = ReadOptions(),
    run: Annotated[RunOptions, Parameter(name="*", group=RUN)] = RunOptions(),
) -> None:
    """Compose the layers of a recipe.

    Any number of layers with place, mode, strength and mask, in groups or not; docs/recipes.md tells every key.

    Example: nmap compose stack scene.toml -o scene.exr --report scene.json

    Parameters
    ----------
    recipe:
        TOML file, or a map that was composed by one, which is in its metadata; - reads TOML from standard input.
    folder:
        What the recipe's files are relative to. Default: its own folder; the current one for standard input.
    placed:
        Picture of where layers lie above the lowest, .png: the --mask of nmap relief for a background that keeps its
        own height.
    size:
        Columns x rows of the canvas. Default: what the recipe says, else those of the lowest layer.
    width:
        Width of the whole picture, such as 100mm. Default: what the recipe says, else the lowest layer.
    """
    session = Session(run)
    given = CanvasOptions(size, width)
    import nmaptool as nm

    if recipe == STREAM and folder is None:
        folder = Path()
    with input_files(recipe) as (source,):
        assert source is not None
        read = nm.read_recipe(source, folder=folder, name=recipe, max_megapixels=reading.max_megapixels)
    canvas = CanvasOptions(given.size or read.canvas.size, given.width or read.canvas.width, read.canvas.ground)
    read = dataclasses.replace(read, canvas=canvas)
    place = Path(read.folder)
    files = (str(place / name) for name in (*read.sources, *read.files))
    writer = MapWriter(session, outputs, writing, run, (recipe, *files), placed=placed)
    with session.progress() as progress:
        layers = nm.read_stack(read, reading)
        result = _composed(layers, reading.max_megapixels, progress)
    for each in layers.maps:
        say_map(session, each)
    _tell(session, layers)
    metadata = report_header(
        layers.maps,
        files={"recipe": recipe, "recipes": read.sources, "layers": read.files},
        reading=dataclasses.asdict(reading),
        outside=layers.outside,
        hidden=read.hidden,
        notes=read.notes,
    )
    writer.write_composition(result, metadata, nm.to_toml(layers.recipe))
    say_composition(session, result)
    writer.finish()


def _composed(layers: nm.Stack, max_megapixels: float, progress: Progress | None) -> nm.Composition:
    """The composition; what is wrong is told in the recipe's words, for it has ``at`` where others have ``--at``."""
    import nmaptool as nm

    try:
        return nm.compose(layers.layers, layers.canvas, max_megapixels=max_megapixels, progress=progress)
    except NmaptoolError as error:
        text = str(error).replace("--at", "at").replace("--scale", "scale")
        raise type(error)(f"{layers.recipe.name}: {text}") from None


def _tell(session: Session, layers: nm.Stack) -> None:
    """What of the recipe was left out, and what it reads from elsewhere."""
    for label in layers.recipe.hidden:
        session.say(f"{label}: hidden, left out")
    for note in layers.recipe.notes:
        session.warn(note)
    for name in layers.outside:
        session.warn(f"{layers.recipe.name}: reads {name}, which lies outside the recipe's folder")
