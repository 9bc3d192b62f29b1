"""The small pictures that notebooks show for values, by type."""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Srgb
from nmaptool.core.errors import UsageError
from nmaptool.figures.contact_sheet import contact_sheet, map_colors
from nmaptool.figures.lambert import in_colors, lambert
from nmaptool.types.composition import Composition
from nmaptool.types.depth import DepthResult
from nmaptool.types.height import Height
from nmaptool.types.layer_set import LayerSet
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.picture import Frame
from nmaptool.types.relief import Relief

_LONGER_SIDE_PX = 512
# a contact sheet has four pictures in a row, with a gap around each
_TILE_PX = 118
# larger heights are subsampled to this before shading
_SHADED_PX = 4 * _LONGER_SIDE_PX


def picture_of(value: object) -> Srgb:
    """Return a picture of a value; its longer side has at most 512 px.

    Parameters
    ----------
    value : NormalMap, Height, Relief, LayerSet, Composition or DepthResult
    """
    for kind, draw in _PICTURES.items():
        if isinstance(value, kind):
            return draw(value)
    raise UsageError(f"{type(value).__name__} has no picture")


def png_of(value: object) -> bytes:
    """Return the result of `picture_of` as the bytes of a PNG file."""
    from PIL import Image

    stream = io.BytesIO()
    Image.fromarray(picture_of(value)).save(stream, format="png")
    return stream.getvalue()


def _map_picture(normal_map: NormalMap) -> Srgb:
    return map_colors(_fitted(normal_map.normals, smooth=False))


def _height_picture(height: Height) -> Srgb:
    return in_colors(_fitted(lambert(_thinned(height)).astype(np.float32), smooth=True))


def _thinned(height: Height) -> Height:
    """Subsample the vertices of a large height field, because shading is slow."""
    step = -(-height.frame.longer_side // _SHADED_PX)
    rows, cols = (side // step for side in height.frame.shape)
    if step == 1 or not min(rows, cols):
        return height
    domain = height.domain[step // 2 :: step, step // 2 :: step][:rows, :cols]
    z_mm = height.z_mm[: rows * step + 1 : step, : cols * step + 1 : step]
    return Height(z_mm, domain, Frame(rows, cols, height.pitch_mm * step)) if domain.any() else height


def _fitted(picture: NDArray[np.float32], *, smooth: bool) -> NDArray[np.float32]:
    """Average a larger picture down to 512 px, or enlarge a smaller one by an integer factor."""
    import cv2

    rows, cols = picture.shape[:2]
    factor = _LONGER_SIDE_PX / max(rows, cols)
    factor = float(int(factor)) if factor > 1 else factor
    way = cv2.INTER_AREA if factor < 1 else cv2.INTER_CUBIC if smooth else cv2.INTER_NEAREST
    size = (max(1, round(cols * factor)), max(1, round(rows * factor)))
    return np.asarray(cv2.resize(np.ascontiguousarray(picture), size, interpolation=way), np.float32)


_PICTURES: dict[type, Callable[[Any], Srgb]] = {
    NormalMap: _map_picture,
    Height: _height_picture,
    Relief: lambda relief: _height_picture(relief.height),
    LayerSet: lambda layers: contact_sheet([layers], _TILE_PX),
    Composition: lambda composition: _map_picture(composition.normal_map),
    DepthResult: lambda result: _map_picture(result.normal_map),
}
