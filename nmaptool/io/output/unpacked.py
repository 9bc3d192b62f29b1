"""Write unpacked layers to a folder: a map per layer, the masks, and the recipe that composes them again."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TypeAlias

from nmaptool.core.errors import OutputError, UsageError
from nmaptool.io.output.map_pictures import mask_picture
from nmaptool.io.output.targets import Destination, place_of
from nmaptool.io.output.transaction import Metadata, Outputs, Target
from nmaptool.io.output.unpacked_recipe import layer_files, recipe_text
from nmaptool.io.pictures.normal_maps import normal_picture
from nmaptool.io.pictures.writer import write_pictures
from nmaptool.options.formats import LAYER_FORMATS
from nmaptool.types.unpacked import UnpackResult

_RECIPE = "recipe.toml"
Files: TypeAlias = Sequence[Mapping[str, str]]


def unpacked_outputs(
    folder: str | Path,
    unpacked: UnpackResult | None = None,
    *,
    format: str = "exr",
    report: Destination | None = None,
    overwrite: bool = False,
) -> Outputs[UnpackResult]:
    """The plan of `write_unpacked`; without ``unpacked``, which names the layers, it can only be checked."""
    place = Path(folder)
    files = [] if unpacked is None else layer_files(unpacked, format)
    layers = list(_layer_targets(place, files, LAYER_FORMATS.get(format, False)))
    recipe = Target(place / _RECIPE, "a recipe", (".toml",), partial(_write_recipe, files))
    source = None if unpacked is None else Path(unpacked.name)
    paths = [place / entry[kind] for entry in files for kind in ("file", "mask") if kind in entry]
    return Outputs(
        [*layers, recipe],
        place_of(report),
        overwrite,
        [place],
        "layers are unpacked into a folder; give another name",
        rules=[partial(_check_format, format), partial(_check_source, source, paths)],
    )


def _layer_targets(folder: Path, files: Files, floating: bool) -> Iterator[Target[UnpackResult]]:
    for number, entry in enumerate(files):
        yield Target(folder / entry["file"], "a layer", (), partial(_write_map, number, floating))
        if "mask" in entry:
            yield Target(folder / entry["mask"], "a mask", (".png",), partial(_write_mask, number))


def _check_format(format: str) -> None:
    if format not in LAYER_FORMATS:
        raise UsageError(f"`format={format!r}`: use one of {', '.join(LAYER_FORMATS)}")


def _check_source(source: Path | None, paths: Sequence[Path]) -> None:
    if source is not None and source.exists() and any(path.exists() and path.samefile(source) for path in paths):
        raise OutputError(f"{source}: is both input and output; unpack it into another folder")


def write_unpacked(
    unpacked: UnpackResult,
    folder: str | Path,
    *,
    format: str = "exr",
    report: Destination | None = None,
    overwrite: bool = False,
    metadata: Metadata | None = None,
) -> list[Path]:
    """Write a map per layer, masks, and ``recipe.toml``: all files appear, or none.

    Parameters
    ----------
    unpacked : UnpackResult
    folder : str or Path
        Created if missing.
    format : str
        ``exr`` (floats) or ``png`` (16 bits).
    report : str, Path or OutputStream, optional
        JSON report of the run.
    overwrite : bool
        Replace files that exist.
    metadata : mapping, optional
        What to put in the report. Default: ``unpacked.to_dict()``.

    Returns
    -------
    list of Path
        The files that were written.

    Raises
    ------
    UsageError
        If a format or extension is not supported.
    OutputError
        If a file cannot be written, or exists and ``overwrite`` is False.

    Examples
    --------
    >>> flat = np.full((32, 48, 3), (0.0, 0, 1))
    >>> written = nm.write_unpacked(nm.unpack(nm.pack([flat])), "unpacked", format="png")
    >>> sorted(path.suffix for path in written)
    ['.png', '.toml']
    """
    outputs = unpacked_outputs(folder, unpacked, format=format, report=report, overwrite=overwrite)
    outputs.write(unpacked, unpacked.to_dict() if metadata is None else metadata)
    return outputs.paths


def _write_map(number: int, floating: bool, unpacked: UnpackResult, path: Path) -> None:
    write_pictures([normal_picture(unpacked.layers[number].normal_map, 32 if floating else 16)], path)


def _write_mask(number: int, unpacked: UnpackResult, path: Path) -> None:
    mask = unpacked.layers[number].mask
    assert mask is not None
    write_pictures([mask_picture(mask)], path)


def _write_recipe(files: Files, unpacked: UnpackResult, path: Path) -> None:
    path.write_text(recipe_text(unpacked, files), encoding="utf-8")
