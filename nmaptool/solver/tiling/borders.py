"""The residual along the borders between tiles, from the outermost lines of both."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float32, Float64, Mask
from nmaptool.solver.system import QuadSystem


@dataclass(frozen=True, eq=False)
class Strip:
    """Four rows of vertices: two on either side of a border between rows of tiles. Borders of columns are transposed.

    Attributes
    ----------
    z : (4, n+1) float64
    weight : (3, n) float32
    beta : (2, n+1) float32
        Of the two rows in the middle, like the others below.
    unknown : (2, n+1) bool
    load : (2, n+1) float64
    """

    z: Float64
    weight: Float32
    beta: Float32
    unknown: Mask
    load: Float64


def strip_residual(strip: Strip) -> Float64:
    """(2, n+1) float64: the residual of the two rows in the middle; 0 at vertices that are not unknown."""
    out = np.zeros(strip.load.shape)
    if not strip.weight.any():
        return out
    beta = np.zeros(strip.z.shape, np.float32)
    beta[1:3] = strip.beta
    system = QuadSystem(strip.weight, beta, np.zeros(strip.z.shape, bool))
    np.subtract(strip.load, system.apply(strip.z)[1:3], out=out)
    out[~strip.unknown] = 0
    return out
