"""Read a picture as its file stores it, whatever its format; or all layers of a file with their places."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from nmaptool.core.errors import LimitError
from nmaptool.io.pictures import exr_layers as layers
from nmaptool.io.pictures.formats import find_format
from nmaptool.io.pictures.layer_names import Holds
from nmaptool.io.pictures.request import Request
from nmaptool.types.picture import RasterImage


def read_image(
    path: Path, layer: str | None = None, max_megapixels: float = 270.0, holds: Holds = "normals"
) -> RasterImage:
    """Read a picture as its file stores it.

    Parameters
    ----------
    path : Path
        A file of a format in `nmaptool.io.pictures.formats.READ_FORMATS`, recognised by its bytes.
    layer : str, optional
        Layer or part of an EXR, array of an .npz, page of a TIFF.
    max_megapixels : float
        Refuse larger pictures, before anything is allocated.
    holds : str
        What the picture is read for, ``normals``, ``depth`` or ``grey``: chooses between layers if none is named.

    Raises
    ------
    InputError
        If it cannot be read, or does not have the layer.
    LimitError
        If its declared size is larger than ``max_megapixels``.
    """
    kind = find_format(path)
    image: RasterImage = kind.function(kind.reader)(path, Request(layer, max_megapixels, holds))
    return image


@dataclass(frozen=True, eq=False)
class PlacedImage:
    """A part of a file with its place on the canvas, in its own data window.

    Parameters
    ----------
    image : RasterImage
    left, top : int
        Position of its data window in the display window.
    cols, rows : int
        Size of the display window.
    """

    image: RasterImage
    left: int
    top: int
    cols: int
    rows: int


def read_pages(path: Path, max_megapixels: float = 270.0) -> list[PlacedImage]:
    """Read all layers, parts and pages of a file that OpenImageIO reads.

    Raises
    ------
    InputError, LimitError
        As `read_image`; the limit applies to all of them together.
    """
    from nmaptool.io.pictures.through_oiio import open_source, read_layer, refuse_deep

    request = Request(max_megapixels=max_megapixels)
    source = open_source(path, request)
    try:
        parts = source.parts()
        found = layers.find(parts)
        total = 0
        for layer in found:
            spec = parts[layer.part]
            refuse_deep(path, spec)
            request.check_size(path, spec.full_width, spec.full_height)
            total += spec.width * spec.height
        if total > max_megapixels * 1e6:
            raise LimitError(
                f"{path}: its layers hold {total / 1e6:.3g} megapixels together, more than the limit of "
                f"{max_megapixels:g}; crop them or raise `max_megapixels`"
            )
        pages: list[PlacedImage] = []
        for layer in found:
            spec, image = parts[layer.part], read_layer(source, replace(layer, name=layer.name or None), placed=True)
            left, top = spec.x - spec.full_x, spec.y - spec.full_y
            pages.append(PlacedImage(image, left, top, spec.full_width, spec.full_height))
        return pages
    finally:
        source.reader.close()
