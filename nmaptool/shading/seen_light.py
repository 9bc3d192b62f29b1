"""The light that each pixel of a piece, and of the table around it, sees."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.parallel import map_parallel
from nmaptool.options.preview import Light
from nmaptool.shading.field import Field, mean_of_corners
from nmaptool.shading.occlusion import sky_share
from nmaptool.shading.shadows import lit_share

_WHOLE = 0.999
# pixels by which values are continued beyond the edge
_BEYOND_PX = 8
# so near to the edge, the light on both sides is mixed
_MIXED_PX = 3


@dataclass(frozen=True, eq=False)
class SeenLight:
    """Shares of the sky and of each light.

    Attributes
    ----------
    sky : (h, w) float32
    lit : list of (h, w) float32
    """

    sky: Float32
    lit: list[Float32]


def seen_light(field: Field, lights: Sequence[Light]) -> tuple[SeenLight, SeenLight]:
    """Return the light on a piece, and that on the table.

    At the edge between them, each is continued from its own side, so that neither has a fringe of the other.
    """
    import cv2

    def sky() -> Float32:
        return sky_share(mean_of_corners(field.placed_mm), field.pitch_mm)

    def lamp(light: Light) -> Callable[[], Float32]:
        return lambda: mean_of_corners(lit_share(field.placed_mm, field.pitch_mm, light))

    jobs = [sky, *map(lamp, lights)]
    found = map_parallel(jobs, lambda job: job())
    if field.is_whole:
        both = SeenLight(found[0], found[1:])
        return both, both
    # pixels beside the edge have corners beyond it, and the sky is found on a coarser grid
    box = np.ones((2 * _MIXED_PX + 1,) * 2, np.uint8)
    sides = (cv2.erode(field.coverage, box) > _WHOLE, cv2.dilate(field.coverage, box) < 1 - _WHOLE)
    piece, table = ([_continued(each, side) for each in found] for side in sides)
    return SeenLight(piece[0], piece[1:]), SeenLight(table[0], table[1:])


def _continued(values: Float32, known: Mask) -> Float32:
    """Values where they are known, and around there means of those close by."""
    import cv2

    weight = known.astype(np.float32)
    kernel = (2 * _BEYOND_PX + 1, 2 * _BEYOND_PX + 1)
    total = cv2.blur(values * weight, kernel, borderType=cv2.BORDER_REPLICATE)
    count = cv2.blur(weight, kernel, borderType=cv2.BORDER_REPLICATE)
    near = count > np.float32(1e-3)
    return np.where(known | ~near, values, total / np.maximum(count, np.float32(1e-3)))
