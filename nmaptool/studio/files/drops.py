"""Files that the user dropped on the window: what each holds and what it becomes."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Literal, TypeAlias

import numpy as np

from nmaptool.core.errors import InputError
from nmaptool.core.progress import Progress
from nmaptool.depth.normals import depth_to_normals
from nmaptool.io.meshes.headers import NAMES
from nmaptool.io.output.normal_map import write_normal_map
from nmaptool.io.pictures.normal_maps import read_raster, split_layer
from nmaptool.io.recipes.reader import read_recipe
from nmaptool.options import DepthOptions
from nmaptool.options.formats import is_recipe
from nmaptool.studio.document import Document, relative
from nmaptool.studio.files.store import Store
from nmaptool.types.depth import DepthResult

Kind: TypeAlias = Literal["recipe", "mesh", "map", "grey", "part"]
_MESHES = {*NAMES, "usda", "usdc", "usdz"}
# buffers of a glTF
_PARTS = (".bin",)
# grey codes of colour pictures may differ by rounding
_GREY = 2 / 255


def kind_of(path: Path) -> Kind:
    """Return what a dropped file holds: a normal map, or a grey picture such as depths, heights or a mask.

    Raises
    ------
    InputError, LimitError
        If it is a picture that cannot be read.
    """
    if is_recipe(path.name):
        return "recipe"
    if is_mesh(path.name):
        return "mesh"
    if path.suffix.lower() in _PARTS:
        return "part"
    try:
        pixels = read_raster(path).pixels
    except InputError:
        read_raster(path, holds="depth")  # a file of depths alone
        return "grey"
    colours = pixels[..., :3].astype(np.float32) if pixels.ndim == 3 and pixels.shape[2] >= 3 else None
    if colours is None:
        return "grey"
    top = np.iinfo(pixels.dtype).max if pixels.dtype.kind == "u" else max(float(np.nanmax(np.abs(colours))), 1e-9)
    apart = np.abs(colours - colours[..., :1]).max(axis=-1)
    return "grey" if float(np.nanpercentile(apart, 99)) <= _GREY * top else "map"


def is_mesh(name: str) -> bool:
    """Whether a file name is that of a mesh."""
    return Path(name).suffix.lower()[1:] in _MESHES


def has_detail(path: Path) -> bool:
    """Whether a file holds an original map and its detail, as `nmap bake -o maps.exr` writes them."""
    if path.suffix.lower() != ".exr":
        return False
    try:
        return read_raster(path).layer == "original" and read_raster(f"{path}:detail").layer == "detail"
    except InputError:  # it has no such layer
        return False


def converted(source: Path, options: DepthOptions, target: Path, progress: Progress | None = None) -> DepthResult:
    """Write the normals of a depth picture.

    Raises
    ------
    InputError, LimitError, UsageError
        If the picture cannot be read or the options do not fit it.
    OutputError
        If the file cannot be written.
    """
    result = depth_to_normals(read_raster(source, holds="depth"), options, progress=progress)
    write_normal_map(result.normal_map, target)
    return result


def opened_recipe(path: Path, document: Document, store: Store) -> Document:
    """Return the document of a dropped recipe; its files are looked for among those that were dropped, and beside.

    Parameters
    ----------
    path : Path
        In the folder of the store.
    document : Document
        The one that is open; its folder is where other files are looked for.
    store : Store

    Raises
    ------
    InputError
        If the recipe cannot be read, or files that it names are missing.
    """
    read = Document.of(read_recipe(path, name=path.name))
    missing: dict[str, None] = {}

    def found(name: str) -> str:
        file, layer = split_layer(name)
        ending = "" if layer is None else f":{layer}"
        dropped = store.folder / file.name
        if dropped.is_file():
            return f"{dropped}{ending}"
        beside = (document.folder / file).resolve()
        if beside.is_relative_to(document.folder.resolve()) and beside.is_file():
            return relative(beside, document.folder.resolve()) + ending
        missing[name] = None
        return name

    named = read.renamed(found)
    if missing:
        raise InputError(f"{path.name}: needs {', '.join(missing)}; drop the recipe together with these files")
    return dataclasses.replace(named, folder=document.folder)
