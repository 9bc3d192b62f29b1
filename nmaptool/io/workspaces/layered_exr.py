"""Workspaces as multi-part EXR: one part per layer, signed normals, its data window at its place on the canvas."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from nmaptool.io.pictures.reader import read_pages
from nmaptool.io.pictures.writer import Picture, write_pictures
from nmaptool.io.workspaces import metadata as metadata
from nmaptool.io.workspaces.pages import Page, layers_of, page_attributes, page_metadata
from nmaptool.types.picture import Frame
from nmaptool.types.workspace import MASK_SUFFIX, Workspace

_CHANNELS = ("R", "G", "B", "A")


def write_layered_exr(workspace: Workspace, path: Path) -> None:
    """Write one part per layer, bottom to top; a mask is a part ``NAME [mask]`` with the single channel Y.

    Raises
    ------
    OutputError
        If writing fails.
    """
    window = (workspace.frame.cols, workspace.frame.rows)
    pictures: list[Picture] = []
    for number, layer in enumerate(workspace.layers):
        said = page_attributes(workspace, number)
        place = (layer.left, layer.top, *window)
        pictures.append(Picture(layer.pixels, _CHANNELS, said, layer.name, workspace.half, place))
        if layer.mask is not None:
            said = page_attributes(workspace, number, mask=True)
            place, grey = (layer.mask.left, layer.mask.top, *window), layer.mask.values[..., None]
            pictures.append(Picture(grey, ("Y",), said, layer.name + MASK_SUFFIX, workspace.half, place))
    write_pictures(pictures, path)


def read_layered_exr(path: Path, max_megapixels: float) -> Workspace:
    """Read every part, or every layer of a part, as a layer.

    Raises
    ------
    InputError, LimitError
        As `nmaptool.io.pictures.reader.read_pages`.
    """
    placed = read_pages(path, max_megapixels)
    pages = [
        Page(
            page.image.layer or page.image.attributes.get("layer") or f"layer {i + 1}",
            page.image,
            page.left,
            page.top,
        )
        for i, page in enumerate(placed)
    ]
    layers, own, orphans = layers_of(pages)
    first: dict[str, Any] | None = next((said for said in (page_metadata(p.image) for p in placed) if said), None)
    frame = Frame(max(p.rows for p in placed), max(p.cols for p in placed), metadata.pitch_in(first))
    bits = max(page.image.bits for page in pages) if pages else 32
    half = bool(pages) and all(page.image.bits == 16 and page.image.pixels.dtype == np.float32 for page in pages)
    return Workspace(frame, layers, 32 if half else bits, half, str(path), own, None, tuple(orphans))
