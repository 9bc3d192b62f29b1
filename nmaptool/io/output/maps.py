"""An edited normal map and the pictures beside it to files, all of them or none."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from nmaptool._version import __version__
from nmaptool.core.arrays import Float32
from nmaptool.core.errors import UsageError
from nmaptool.figures.curl import BRIGHTEST, DARKEST, curl_picture
from nmaptool.io.pictures.normal_maps import check_ending, map_picture
from nmaptool.io.pictures.writer import Picture, write_pictures
from nmaptool.io.replace import check_targets, named, written_beside
from nmaptool.maps.codec import grey_codes
from nmaptool.options import WriteOptions
from nmaptool.types.composition import Composition
from nmaptool.types.normal_map import NormalMap


@dataclass(frozen=True)
class MapFiles:
    """Where an edited map goes.

    Parameters
    ----------
    output : Path
        The map: .png, .exr or .tif.
    options : WriteOptions
    pictures : mapping of str to Path
        Pictures beside it, .png, by kind: ``curl``, ``placed``, ...
    report : Path or None
        .json.
    overwrite : bool
        Replace files that exist.
    """

    output: Path
    options: WriteOptions = field(default_factory=WriteOptions)
    pictures: Mapping[str, Path] = field(default_factory=dict)
    report: Path | None = None
    overwrite: bool = False

    @property
    def targets(self) -> list[Path]:
        """All files: the map, the pictures, the report."""
        return [self.output, *self.pictures.values(), *([self.report] if self.report else [])]

    def check(self) -> None:
        """Refuse what could not be written, before any work is done.

        Raises
        ------
        UsageError
            If an ending is not offered or a file is named twice.
        OutputError
            If a target cannot be written or exists.
        """
        check_ending(self.output, self.options)
        for kind, path in self.pictures.items():
            if path.suffix.lower() != ".png":
                raise UsageError(f"{path}: the {kind} picture is written as .png")
        if self.report is not None and self.report.suffix.lower() != ".json":
            raise UsageError(f"{self.report}: a report is written as .json")
        check_targets(self.targets, self.overwrite)


def write_map_files(
    files: MapFiles,
    normal_map: NormalMap,
    pictures: Mapping[str, Callable[[], Picture]],
    metadata: Mapping[str, Any],
    recipe: str,
    attributes: Mapping[str, str] | None = None,
) -> None:
    """Write a map, pictures and a report: all files appear, or none.

    Parameters
    ----------
    files : MapFiles
    normal_map : NormalMap
    pictures : mapping of str to callable
        Makes the picture of each kind in ``files.pictures``; ``curl`` is known here.
    account : mapping
        What to put in the report.
    recipe : str
        How the map came about, for its metadata.
    attributes : mapping, optional
        More metadata of the map.

    Raises
    ------
    UsageError, OutputError
        As `MapFiles.check`, or if writing fails.
    """
    files.check()
    known: dict[str, Callable[[], Picture]] = {"curl": partial(curl_image, normal_map), **pictures}
    with written_beside(files.targets, files.overwrite) as beside:
        for target, temporary in zip(files.targets, beside, strict=True):
            with named(target, temporary):
                if target is files.report:
                    temporary.write_text(json.dumps(metadata, indent=2) + "\n")
                elif target is files.output:
                    picture = map_picture(normal_map, target.suffix.lower(), files.options)
                    facts = {**(attributes or {}), **picture.attributes, "recipe": recipe}
                    write_pictures(temporary, [replace(picture, attributes=facts)])
                else:
                    kind = next(kind for kind, path in files.pictures.items() if path is target)
                    write_pictures(temporary, [known[kind]()])


def curl_image(normal_map: NormalMap) -> Picture:
    """`nmaptool.curl_picture` as a file holds it, its scale in the metadata."""
    scale = {"black": repr(DARKEST), "white": repr(BRIGHTEST), "unit": "slope per px"}
    facts = {"kind": "curl", "version": __version__, **scale}
    return Picture(curl_picture(normal_map), ("R", "G", "B"), facts)


def write_composition(
    composition: Composition,
    output: str | Path,
    options: WriteOptions | None = None,
    *,
    curl: str | Path | None = None,
    placed: str | Path | None = None,
    report: str | Path | None = None,
    overwrite: bool = False,
    metadata: Mapping[str, Any] | None = None,
    recipe: str | None = None,
) -> None:
    """Write a composition: all files appear, or none.

    Parameters
    ----------
    composition : Composition
    output : str or Path
        The map: .png, .exr or .tif.
    options : WriteOptions, optional
    curl : str or Path, optional
        Picture of |curl|, .png: see `nmaptool.curl_picture`.
    placed : str or Path, optional
        Where layers lie above the lowest, .png: the mask for a relief of them.
    report : str or Path, optional
        JSON account of the run.
    overwrite : bool
        Replace files that exist.
    metadata : mapping, optional
        What to put in the report. Default: ``composition.report.to_dict()``.
    recipe : str, optional
        How the map came about, for its metadata. Default: command, options and layers as JSON.

    Raises
    ------
    UsageError
        If an ending is not offered.
    OutputError
        If a file cannot be written, or exists and ``overwrite`` is False.

    Examples
    --------
    >>> base, detail = (nm.read_normal_map(f"samples/medal_{name}.png") for name in ("base", "detail"))
    >>> nm.write_composition(nm.blend(base, detail), "medal.png", report="medal.json")
    """
    named_pictures = {"curl": curl, "placed": placed}
    pictures = {kind: Path(path) for kind, path in named_pictures.items() if path is not None}
    files = MapFiles(Path(output), options or WriteOptions(), pictures, Path(report) if report else None, overwrite)
    recipe = composition_recipe(composition) if recipe is None else recipe
    values = metadata or composition.report.to_dict()
    write_map_files(files, composition.normal_map, {"placed": partial(placed_picture, composition)}, values, recipe)


def composition_recipe(composition: Composition) -> str:
    """Command, options and layers as JSON."""
    values = composition.report.to_dict()
    return json.dumps({key: values[key] for key in ("command", "options", "layers")})


def placed_picture(composition: Composition) -> Picture:
    """Where layers lie above the lowest, as a mask for a relief of them."""
    grey = grey_codes(composition.placed, 16)[..., None]
    return Picture(grey, ("Y",), {"kind": "mask", "version": __version__})


def jumps_picture(jumps: Float32) -> Picture:
    """Jumps of a depth picture: black is none, white the highest, which is in the metadata."""
    highest = float(jumps.max())
    grey = grey_codes(jumps / np.float32(highest or 1), 16)[..., None]
    facts = {"kind": "jumps", "version": __version__, "black": "0", "white": repr(highest), "unit": "px"}
    return Picture(grey, ("Y",), facts)
