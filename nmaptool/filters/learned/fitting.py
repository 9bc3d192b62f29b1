"""Fit networks to examples: cluster the neighbourhoods, and fit one network per cluster."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from nmaptool.core.arrays import Float32, Float64
from nmaptool.filters.learned.network import Network, Shape, TrainingLoss, split_parameters

_CLUSTER_STEPS = 40
# inputs that vary less are treated as constant
_LEAST_SPREAD = 1e-3


def find_clusters(inputs: Float32, count: int, rng: np.random.Generator) -> Float32:
    """Return the centres of clusters of neighbourhoods, by k-means.

    Parameters
    ----------
    inputs : (N, D) float32
    count : int
    rng : numpy.random.Generator

    Returns
    -------
    (count, D) float32
    """
    from scipy.cluster.vq import kmeans2

    centers, _ = kmeans2(inputs, count, iter=_CLUSTER_STEPS, minit="++", rng=rng, missing="warn")
    return np.asarray(centers, np.float32)


def nearest_cluster(inputs: Float32, centers: Float32) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """Return the (M,) indices of the nearest centres, comparing only as many inputs as the centres have components."""
    inputs = inputs[:, : centers.shape[1]]
    far = np.einsum("kd,kd->k", centers, centers) - 2 * (inputs @ centers.T)
    return np.asarray(far.argmin(axis=1))


def fit_network(
    inputs: Float32,
    targets: Float32,
    *,
    mixed: int,
    hidden: int,
    steps: int,
    weight_decay: float,
    rng: np.random.Generator,
    step_done: Callable[[float], None] | None = None,
) -> tuple[Network, float]:
    """Fit one network by L-BFGS.

    Parameters
    ----------
    inputs : (N, D) float32
    targets : (N, 3) float32
        Unit normals in the frames of the inputs.
    mixed : int
        Number of normals at the beginning of the inputs.
    hidden, steps : int
    weight_decay : float
    rng : numpy.random.Generator
        Generator of the initial weights.
    step_done : callable, optional
        Called with the share of the steps done.

    Returns
    -------
    network : Network
    loss : float
        Mean squared distance of unit vectors, plus the weight decay.
    """
    from scipy.optimize import minimize

    mean = inputs.mean(axis=0, dtype=np.float64)
    spread = np.maximum(inputs.std(axis=0, dtype=np.float64), _LEAST_SPREAD)
    lesson = TrainingLoss(inputs, targets, mean, spread)
    shape = Shape(inputs.shape[1], hidden, mixed)
    start = np.zeros(shape.weights)
    w1, _, w2, _ = split_parameters(start, shape)
    w1[:] = rng.normal(0, 1 / np.sqrt(shape.inputs), w1.shape)
    w2[:] = rng.normal(0, 0.1 / np.sqrt(hidden), w2.shape)
    count = 0

    def notify(_: Float64) -> None:
        nonlocal count
        count += 1
        if step_done is not None:
            step_done(count / steps)

    found = minimize(
        lesson.loss,
        start,
        args=(shape, weight_decay),
        jac=True,
        method="L-BFGS-B",
        callback=notify,
        options={"maxiter": steps, "maxcor": 20, "ftol": 1e-9, "gtol": 1e-7},
    )
    w1, b1, w2, b2 = split_parameters(found.x, shape)
    inner = w1 / spread  # the weights absorb the scaling of the inputs
    parts = (inner, b1 - inner @ mean, w2, b2)
    return Network(*(np.ascontiguousarray(part, np.float32) for part in parts)), float(found.fun)
