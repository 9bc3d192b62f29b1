"""The coverage of a map's motif."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float32
from nmaptool.types.normal_map import NormalMap


def motif_coverage(normal_map: NormalMap) -> Float32:
    """(H, W) float32 coverage of the motif alone: 0 on a background that is a defined part of the map."""
    background = (normal_map.coverage == 1) & ~normal_map.foreground
    return np.where(background, np.float32(0), normal_map.coverage)
