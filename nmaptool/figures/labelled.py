"""A contact sheet: pictures in rows, each with its name."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from nmaptool.core.arrays import Srgb

_GAP_PX, _LABEL_PX = 14, 30
_PAPER, _INK = 26, 225


def labelled_sheet(pictures: Mapping[str, Srgb]) -> Srgb:
    """Put pictures in rows, about as many as columns, with the name of each below it.

    Parameters
    ----------
    pictures : mapping of str to (h, w, 3) uint8
        At least one.

    Returns
    -------
    (h, w, 3) uint8
    """
    from PIL import Image, ImageDraw, ImageFont

    count = len(pictures)
    across = math.ceil(math.sqrt(count))
    down = math.ceil(count / across)
    rows, cols = (max(picture.shape[axis] for picture in pictures.values()) for axis in (0, 1))
    cell = rows + _LABEL_PX + _GAP_PX, cols + _GAP_PX
    canvas = np.full((down * cell[0] + _GAP_PX, across * cell[1] + _GAP_PX, 3), _PAPER, np.uint8)
    corners = []
    for place, picture in enumerate(pictures.values()):
        top, left = _GAP_PX + place // across * cell[0], _GAP_PX + place % across * cell[1]
        # smaller pictures stand in the middle of their cell
        y, x = top + (rows - picture.shape[0]) // 2, left + (cols - picture.shape[1]) // 2
        canvas[y : y + picture.shape[0], x : x + picture.shape[1]] = picture
        corners.append((top + rows + 6, left))
    image = Image.fromarray(canvas)
    draw = ImageDraw.Draw(image)
    font: Any = ImageFont.load_default(size=16)
    for (top, left), name in zip(corners, pictures, strict=True):
        draw.text((left + 2, top), _fitted(name, draw, font, cols), fill=(_INK, _INK, _INK), font=font)
    return np.asarray(image)


def _fitted(name: str, draw: Any, font: Any, width: int) -> str:
    """The end of a name that is too long for its picture."""
    name = " ".join(name.split())
    short = name
    while len(short) > 1 and draw.textlength(short, font=font) > width:
        short = "…" + short.lstrip("…")[1:]
    return short
