"""Overviews of pictures larger than memory."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.errors import UsageError
from nmaptool.core.progress import Progress
from nmaptool.io.stores.opening import open_picture
from nmaptool.io.stores.reducing import Reducer
from nmaptool.io.stores.windows import grid_windows
from nmaptool.io.stores.zarr_output import level_attributes
from nmaptool.types.picture import RasterImage

_AT_ONCE_PX = 2048


def overview(
    source: str, longest_px: int = 2000, *, layer: str | None = None, progress: Progress | None = None
) -> RasterImage:
    """Return a smaller version of a picture by area averaging, in memory that does not depend on its size.

    Parameters
    ----------
    source : str
        A Zarr store, a folder of tiles, a TIFF or another picture file.
    longest_px : int
        Largest length of the longer side. The picture is reduced by a whole number; a smaller one is returned as it
        is.
    layer : str, optional
        Layer of a file, or array of a group.
    progress : callable, optional
        Called with "averaging" and the share done.

    Returns
    -------
    RasterImage
        Of the same type; its pitch is that of the larger pixels. Colours are weighted by alpha; the vectors of normal
        maps that nmaptool wrote are averaged and scaled to unit length; NaN in heights does not count.

    Raises
    ------
    UsageError
        If ``longest_px`` is less than 1.
    InputError
        If the picture cannot be read.

    Examples
    --------
    >>> nm.tiled.overview("samples/medal_original.png", 64)
    <RasterImage samples/medal_original.png: 62 x 62 px, pitch unknown, channels R, G, B, A, 16-bit codes>
    """
    if longest_px < 1:
        raise UsageError(f"`longest_px={longest_px}`: must be at least 1")
    picture = open_picture(source, layer)
    factor = -(-max(picture.rows, picture.cols) // longest_px)
    corner = picture.read(slice(0, 1), slice(0, 1))
    reducer = Reducer(picture, factor)
    rows, cols = reducer.shape
    pixels: NDArray[Any] = np.empty((rows, cols, len(picture.channels)), corner.pixels.dtype)
    side = max(1, _AT_ONCE_PX // factor)
    for down, across in grid_windows((rows, cols), (side, side)):
        pixels[down, across] = reducer.window(down, across)
        if progress is not None:
            progress("averaging", down.stop / rows)
    attributes = level_attributes(picture.attributes, picture.pitch_mm, factor)
    return replace(corner, pixels=pixels, attributes=attributes)
