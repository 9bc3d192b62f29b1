"""Write a composition to files."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import partial

import numpy as np

from nmaptool.io.output.map_pictures import mask_picture
from nmaptool.io.output.normal_map import WrittenMap, map_outputs
from nmaptool.io.output.targets import Destination
from nmaptool.io.output.transaction import Metadata
from nmaptool.options import WriteOptions
from nmaptool.types.composition import Composition


def composed_map(
    composition: Composition, recipe: str | None = None, kept: Mapping[str, str] | None = None
) -> WrittenMap:
    """Return the map of a composition with its metadata and pictures, ready to write.

    Parameters
    ----------
    composition : Composition
    recipe : str, optional
        How the map was made, for its metadata. Default: command, options and layers as JSON.
    kept : mapping, optional
        Metadata of the map's source file.
    """
    if recipe is None:
        values = composition.report.to_dict()
        recipe = json.dumps({key: values[key] for key in ("command", "options", "layers")})
    walls = np.zeros_like(composition.placed) if composition.walls is None else composition.walls
    pictures = {"placed": partial(mask_picture, composition.placed), "walls": partial(mask_picture, walls)}
    return WrittenMap(composition.normal_map, {"recipe": recipe}, kept or {}, pictures)


def write_composition(
    composition: Composition,
    output: Destination,
    options: WriteOptions | None = None,
    *,
    curl: Destination | None = None,
    placed: Destination | None = None,
    walls: Destination | None = None,
    report: Destination | None = None,
    metadata: Metadata | None = None,
    recipe: str | None = None,
    overwrite: bool = False,
) -> None:
    """Write a composition: all files appear, or none.

    The map is written as by `write_normal_map`, with the recipe that made it in its metadata.

    Parameters
    ----------
    composition : Composition
    output : str, Path or OutputStream
        The map: .png, .exr or .tif.
    options : WriteOptions, optional
    curl : str, Path or OutputStream, optional
        Picture of |curl|, .png: see `nmaptool.curl_picture`.
    placed : str, Path or OutputStream, optional
        Mask of the layers above the lowest, .png: use it as the mask of a relief.
    walls : str, Path or OutputStream, optional
        Mask of the layers with ``edge="wall"``, .png: use it as the wall mask of a relief.
    report : str, Path or OutputStream, optional
        JSON report of the run.
    metadata : mapping, optional
        What to put in the report. Default: ``composition.report.to_dict()``.
    recipe : str, optional
        How the map was made, for its metadata. Default: command, options and layers as JSON.
    overwrite : bool
        Replace files that exist.

    Raises
    ------
    UsageError
        If an extension, or the bits for it, are not supported.
    OutputError
        If a file cannot be written, or exists and ``overwrite`` is False.

    Examples
    --------
    >>> base, detail = (nm.read_normal_map(f"samples/medal_{name}.png") for name in ("base", "detail"))
    >>> nm.write_composition(nm.blend(base, detail), "medal.png", report="medal.json")
    """
    pictures = {"curl": curl, "placed": placed, "walls": walls}
    outputs = map_outputs(output, options, pictures=pictures, report=report, overwrite=overwrite)
    outputs.write(composed_map(composition, recipe), metadata or composition.report.to_dict())
