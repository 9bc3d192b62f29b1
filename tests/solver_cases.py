"""Linear systems that several solver tests share."""

import numpy as np

from bench import masks
from nmaptool.core.grid import corner_sum
from nmaptool.solver import QuadSystem


def free_system(weight, beta=0.0):
    return QuadSystem(weight, corner_sum(weight) / 4 * beta, np.zeros(np.add(weight.shape, 1), bool))


def random_system(rng, rows=6, cols=7, dtype=np.float64):
    """A system with random weights and height weights, some of them 0, and some held vertices."""
    weight = rng.random((rows, cols)) * (rng.random((rows, cols)) > 0.3)
    weight[0, 0] = 1.0
    beta = corner_sum(weight) * 0.05 * rng.random((rows + 1, cols + 1))
    return QuadSystem(weight.astype(dtype), beta.astype(dtype), rng.random(beta.shape) > 0.85)


def dense(system):
    """The operator as a dense matrix over all vertices."""
    columns = [system.apply(unit.reshape(system.beta.shape)).ravel() for unit in np.eye(system.beta.size)]
    return np.array(columns).T


def dense_answer(system, load, held_z=None):
    """Heights by a dense solve; the least-norm solution where a constant is free."""
    unknown = system.unknown.ravel()
    z = np.where(system.held, 0 if held_z is None else held_z, 0.0).ravel()
    matrix = dense(system)
    z[unknown] = np.linalg.lstsq(matrix[np.ix_(unknown, unknown)], (load.ravel() - matrix @ z)[unknown], rcond=1e-13)[0]
    return z.reshape(system.beta.shape)


def blobs(side):
    """A mask with holes, bays and two islands, the same shape at every size."""
    x, y = (np.mgrid[0:side, 0:side] + 0.5) / side
    solid = (np.hypot(x - 0.4, y - 0.45) < 0.33) | (np.abs(x - 0.8) + np.abs(y - 0.8) < 0.15)
    return (solid & ~(np.hypot(x - 0.35, y - 0.5) < 0.07) & ~((np.abs(y - 0.3) < 0.02) & (x > 0.4))).astype(float)


def mask_of(family, side):
    """A mask from `bench.masks`."""
    return masks.statue(side, side) if family == "statue" else getattr(masks, family)(side)
