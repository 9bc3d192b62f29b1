"""A contact sheet: all layers of all views in one picture, as maps and under a raking light."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32
from nmaptool.types.layer_set import LayerSet

_TILE_PX = 480
_GAP_PX = 8
_LABEL_PX = 26
_PAPER, _INK = 26, 225
_LIGHT = np.array([-0.55, 0.55, 0.63], np.float32)
Picture = NDArray[np.uint8]


def contact_sheet(layer_sets: Sequence[LayerSet], tile_px: int = _TILE_PX) -> Picture:
    """Draw layer sets: two rows per view, the colours of the maps above, shaded below.

    Parameters
    ----------
    layer_sets : sequence of LayerSet
    tile_px : int
        Longer side of each of the four pictures in a row.

    Returns
    -------
    (h, w, 3) uint8
        sRGB, for display.
    """
    return np.vstack([row for layers in layer_sets for row in _rows(layers, tile_px)])


def _rows(layers: LayerSet, tile_px: int) -> list[Picture]:
    view = f"{layers.report.view} " if layers.report.view else ""
    maps = {"original": layers.original, "base": layers.base, "detail": layers.detail}
    cover = layers.coverage
    colors = [(f"{view}{name}", map_colors(m.normals)) for name, m in maps.items()]
    shaded = [(f"{view}{name}, lit", _lit(m.normals, cover)) for name, m in maps.items()]
    colors.append((f"{view}coverage", _grey(cover)))
    if layers.depth_mm is not None:
        shaded.append((f"{view}depth", _depth(layers.depth_mm, cover)))
    else:
        shaded.append(("", np.full((*cover.shape, 3), _PAPER, np.uint8)))
    return [_row(colors, tile_px), _row(shaded, tile_px)]


def map_colors(normals: Float32) -> Picture:
    """Return (h, w, 3) normals as (h, w, 3) uint8 in the usual colours of normal maps."""
    return ((normals + 1) * 127.5 + 0.5).clip(0, 255).astype(np.uint8)


def _grey(values: Float32) -> Picture:
    return np.repeat((values.clip(0, 1) * 255 + 0.5).astype(np.uint8)[..., None], 3, axis=2)


def _lit(normals: Float32, coverage: Float32) -> Picture:
    light = 0.08 + 0.92 * (normals @ _LIGHT).clip(0, 1)
    return _grey(light * (0.25 + 0.75 * coverage))


def _depth(depth_mm: Float32, coverage: Float32) -> Picture:
    seen = coverage > 0
    low, high = float(depth_mm[seen].min()), float(depth_mm[seen].max())
    near = 1 - 0.85 * (depth_mm - low).clip(0) / max(high - low, 1e-30)
    return _grey(np.where(seen, near, 0.1).astype(np.float32))


def _row(tiles: list[tuple[str, Picture]], tile_px: int) -> Picture:
    import cv2

    rows, cols = tiles[0][1].shape[:2]
    factor = tile_px / max(rows, cols)
    size = (max(1, round(cols * factor)), max(1, round(rows * factor)))
    way = cv2.INTER_AREA if factor < 1 else cv2.INTER_NEAREST
    canvas = np.full((size[1] + _LABEL_PX + _GAP_PX, (size[0] + _GAP_PX) * len(tiles) + _GAP_PX, 3), _PAPER, np.uint8)
    labels = []
    for place, (label, picture) in enumerate(tiles):
        left = _GAP_PX + place * (size[0] + _GAP_PX)
        canvas[_LABEL_PX : _LABEL_PX + size[1], left : left + size[0]] = cv2.resize(picture, size, interpolation=way)
        labels.append((left, label))
    return _lettered(canvas, labels)


def _lettered(canvas: Picture, labels: list[tuple[int, str]]) -> Picture:
    from PIL import Image, ImageDraw, ImageFont

    image = Image.fromarray(canvas)
    draw = ImageDraw.Draw(image)
    font: Any = ImageFont.load_default(size=15)
    for left, label in labels:
        draw.text((left + 2, 5), label, fill=(_INK, _INK, _INK), font=font)
    return np.asarray(image)
