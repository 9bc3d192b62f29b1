"""Convert a normal map file to another format."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from nmaptool.composition.conversion import convert_image
from nmaptool.core.errors import UsageError
from nmaptool.io.output.composition import composed_map
from nmaptool.io.output.normal_map import WrittenMap, bits_of, map_outputs
from nmaptool.io.output.targets import Destination, place_of
from nmaptool.io.pictures.normal_maps import read_raster, split_layer
from nmaptool.options import ReadOptions, WriteOptions
from nmaptool.types.composition import Composition
from nmaptool.types.picture import RasterImage

# attributes that the writer sets
_RENEWED = ("version", "kind", "green", "zero_code", "encoding", "pitch_mm", "recipe")


def convert(
    path_in: str | Path,
    path_out: Destination,
    reading: ReadOptions | None = None,
    writing: WriteOptions | None = None,
    *,
    curl: Destination | None = None,
    report: Destination | None = None,
    overwrite: bool = False,
) -> Composition:
    """Convert a normal map file: format, bits, green direction, zero code; all three components are written.

    As on every reading, vectors of other than unit length are normalised, anti-aliased rims are un-mixed, and the
    coverage of a background becomes alpha. Valid vectors keep their codes: conversion to the same bits and zero code,
    or to more bits and back, is lossless. Pixels with alpha 0 become flat. The file keeps the pitch, the layer's name
    and the recipe.

    Parameters
    ----------
    path_in : str or Path
        ``FILE`` or ``FILE.exr:layer``.
    path_out : str, Path or OutputStream
        .png, .exr or .tif.
    reading : ReadOptions, optional
    writing : WriteOptions, optional
    curl : str, Path or OutputStream, optional
        Picture of |curl|, .png: see `nmaptool.curl_picture`.
    report : str, Path or OutputStream, optional
        JSON report of the run.
    overwrite : bool
        Replace files that exist.

    Returns
    -------
    Composition
        The map and its `nmaptool.ConvertReport`.

    Raises
    ------
    UsageError
        If an extension or the bits are not supported, or the output is the input.
    InputError, LimitError
        As `nmaptool.read_normal_map`.
    OutputError
        If a file cannot be written, or exists and ``overwrite`` is False.

    Examples
    --------
    >>> nm.convert("samples/medal_base.png", "base.exr").normal_map
    <NormalMap samples/medal_base.png: 248 x 248 px, pitch unknown, 72% covered>
    """
    reading, writing = reading or ReadOptions(), writing or WriteOptions()
    outputs = map_outputs(path_out, writing, pictures={"curl": curl}, report=report, overwrite=overwrite)
    outputs.check()
    source = split_layer(str(path_in))[0]
    if any(path.exists() and source.exists() and path.samefile(source) for path in outputs.paths):
        raise UsageError(f"{path_in}: is also an output; give another name for the output")
    image = read_raster(path_in, reading)
    result, settled = convert_image(image, bits_of(place_of(path_out), writing), reading, writing)
    metadata = {"input": str(path_in), **result.report.to_dict(), "outputs": outputs.names}
    outputs.write(converted_map(image, result, settled), metadata)
    return result


def converted_map(image: RasterImage, result: Composition, settled: WriteOptions) -> WrittenMap:
    """Return the converted map, ready to write, with the attributes of its file that still apply.

    Parameters
    ----------
    image : RasterImage
    result : Composition
    settled : WriteOptions
        As returned by `nmaptool.composition.conversion.convert_image`.
    """
    recipe = recipe_of(image.attributes.get("recipe"), result.report.command, result.report.options)
    return replace(composed_map(result, recipe, kept_attributes(image)), options=settled)


def kept_attributes(image: RasterImage) -> dict[str, str]:
    """The attributes of a file that still apply to its converted map."""
    kept = {key: " ".join(value.split()) for key, value in image.attributes.items() if key not in _RENEWED}
    if image.layer is not None:
        kept.setdefault("layer", image.layer)
    return kept


def recipe_of(before: str | None, command: str, options: Mapping[str, Any]) -> str:
    """The conversion as JSON, with the earlier recipe of the file under ``before``."""
    recipe: dict[str, Any] = {"command": command, "options": dict(options)}
    if before is None:
        return json.dumps(recipe)
    try:
        return json.dumps({**recipe, "before": json.loads(before)})
    except (ValueError, RecursionError):  # not JSON, or nested too deeply: it is kept as text
        return json.dumps({**recipe, "before": before})
