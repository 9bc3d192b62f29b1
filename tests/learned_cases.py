"""Training examples that take only seconds."""

import functools

import numpy as np
from mesh_cases import sheet

import nmaptool as nm
from nmaptool.filters.learned.network import Network

DESCRIPTOR = nm.DescriptorOptions(sigma_s=(1.5, 3.0), sigma_r=(0.3, 0.8), passes=2)
OPTIONS = nm.TrainOptions(stages=2, clusters=2, hidden=4, steps=15, samples=1200)


def hilly(seed):
    """A roof with a soft ridge and bumps two edges wide."""
    rng = np.random.default_rng(seed)
    slope, phase = rng.uniform(0.2, 0.8), rng.uniform(0, 6, 2)

    def height(x, y):
        return -slope * np.hypot(x, 1) + 0.3 * np.sin(1.7 * x + phase[0]) * np.sin(1.9 * y + phase[1])

    mesh = sheet(height, 24, 24)
    return nm.Mesh(mesh.vertices, mesh.faces, name=f"roof {seed}")


@functools.cache
def examples(count=2):
    """Roofs with their GRNF bases."""
    return tuple(nm.training_example(hilly(seed), nm.FilterOptions(filter="grnf")) for seed in range(count))


@functools.cache
def small_filter():
    """A filter trained on those roofs."""
    return nm.train(examples(), OPTIONS, descriptor=DESCRIPTOR)


def same(one, other):
    """Whether two filters are identical, bit for bit."""
    return one.digest == other.digest


def network(hidden=3, mixed=5, seed=0, more=4):
    """A network with random weights."""
    rng = np.random.default_rng(seed)
    shapes = (hidden, 3 * mixed + more), (hidden,), (mixed, hidden), (mixed,)
    return Network(*(rng.normal(size=shape).astype(np.float32) for shape in shapes))
