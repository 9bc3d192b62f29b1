"""Systems that several tests of the solver work on."""

import numpy as np

from nmaptool.grid import corner_sum
from nmaptool.solver import QuadSystem


def free_system(weight, beta=0.0):
    return QuadSystem(weight, corner_sum(weight) / 4 * beta, np.zeros(np.add(weight.shape, 1), bool))


def blobs(side):
    """A mask with holes, bays and two islands, the same at every size."""
    x, y = (np.mgrid[0:side, 0:side] + 0.5) / side
    solid = (np.hypot(x - 0.4, y - 0.45) < 0.33) | (np.abs(x - 0.8) + np.abs(y - 0.8) < 0.15)
    return (solid & ~(np.hypot(x - 0.35, y - 0.5) < 0.07) & ~((np.abs(y - 0.3) < 0.02) & (x > 0.4))).astype(float)
