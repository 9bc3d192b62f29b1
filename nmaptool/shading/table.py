"""The table on which a piece lies: matt, level, and darker far away."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nmaptool.core.arrays import Float32
from nmaptool.options.preview import Light
from nmaptool.shading.surface import Facets, irradiance

# where it begins to darken, as a share of the distance where it is darkest, and what is left there
_BEGINS, _DARKEST = 0.35, 0.45


def table_light(
    at: Float32, lit: Sequence[Float32], sky: Float32, lights: Sequence[Light], backdrop: Float32, far_mm: float
) -> Float32:
    """(n, 3) light of points of the table.

    Parameters
    ----------
    at : (n, 2) or (n, 3) float32
        Points in mm from below the middle of the piece.
    lit : sequence of (n,) float32
    sky : (n,) float32
    lights : sequence of Light
    backdrop : (3,) float32
        The table's colour.
    far_mm : float
        Where it is darkest.
    """
    up = np.float32(0), np.float32(0), np.float32(1)
    level = Facets(up, up, up, lit, sky, sky, backdrop)
    fade = np.clip(np.hypot(at[:, 0], at[:, 1]) / np.float32(far_mm) - np.float32(_BEGINS), 0, 1)
    fade = 1 - np.float32(1 - _DARKEST) * fade * fade * (3 - 2 * fade)
    return np.asarray(irradiance(level, lights, backdrop) * backdrop * fade[:, None], np.float32)
