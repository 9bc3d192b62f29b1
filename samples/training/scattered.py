"""Patterns at points scattered over a surface: bosses, pores, cells, scales and combed fur."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from ornament import Ornament, Rng
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree
from surface import Array, Surface, smooth_step


def spread(points: Array, gap: float, rng: Rng) -> NDArray[np.int64]:
    """Indices of a maximal set of points with distances of at least ``gap``."""
    free, chosen = np.ones(len(points), bool), []
    near = cKDTree(points).query_ball_point(points, gap, return_sorted=True)
    for place in rng.permutation(len(points)):
        if free[place]:
            chosen.append(place)
            free[near[place]] = False
    return np.array(chosen)


def distances(s: Surface, wave: float, rng: Rng, count: int) -> tuple[Array, NDArray[np.int64], NDArray[np.int64]]:
    """Distances to the nearest points in waves, indices of those points, and the points' vertices."""
    places = spread(s.vertices, 0.8 * wave * s.edge, rng)
    away, which = cKDTree(s.vertices[places]).query(s.vertices, k=count)
    return away / (wave * s.edge), which, places


def bosses(wave: float, size: float = 0.45) -> Ornament:
    """Round bosses separated by bare surface."""

    def heights(s: Surface, rng: Rng) -> Array:
        away = distances(s, wave, rng, 1)[0]
        return np.sqrt((1 - (away / size) ** 2).clip(0, None))

    return heights


def pores(wave: float, size: float = 0.4) -> Ornament:
    """Dimples."""

    def heights(s: Surface, rng: Rng) -> Array:
        return -(1 - smooth_step(distances(s, wave, rng, 1)[0], 0, size))

    return heights


def cells(wave: float, joint: float = 0.3) -> Ornament:
    """Cushions with joints between them, like pebbles or crackle."""

    def heights(s: Surface, rng: Rng) -> Array:
        away = distances(s, wave, rng, 2)[0]
        return smooth_step(away[:, 1] - away[:, 0], 0, 2 * joint)

    return heights


def tangents(s: Surface, way: tuple[float, float, float]) -> Array:
    """A direction laid along the surface at each vertex."""
    w = np.asarray(way, dtype=float)
    flat = w - s.normals * (s.normals @ w)[:, None]
    return flat / np.linalg.norm(flat, axis=1, keepdims=True).clip(0.05, None)


def scales(wave: float, way: tuple[float, float, float] = (0, -1, 0)) -> Ornament:
    """Overlapping scales that rise along a direction."""

    def heights(s: Surface, rng: Rng) -> Array:
        _, which, places = distances(s, wave, rng, 9)
        down = tangents(s, way)[places]
        rest = (s.vertices[:, None] - s.vertices[places][which]) / (wave * s.edge)
        along = (rest * down[which]).sum(axis=2)
        off = np.sqrt((rest**2).sum(axis=2))
        return (smooth_step(0.82 - off, 0, 0.22) * (0.8 + 0.25 * along)).max(axis=1)

    return heights


def fur(width: float, length: float = 5.0, way: tuple[float, float, float] = (0, -1, 0)) -> Ornament:
    """Random strands combed along a direction, ``width`` edges wide and ``length`` times that long."""

    def heights(s: Surface, rng: Rng) -> Array:
        reach = max(2.2, width) * s.edge
        one, two = cKDTree(s.vertices).query_pairs(reach, output_type="ndarray").T
        one, two = np.concatenate([one, two]), np.concatenate([two, one])
        rest = s.vertices[two] - s.vertices[one]
        along = (rest * tangents(s, way)[one]).sum(axis=1)
        across = np.sqrt(((rest**2).sum(axis=1) - along**2).clip(0, None))
        weight = np.exp(-((across / (0.22 * width * s.edge)) ** 2) - (along / (reach / 1.5)) ** 2)
        step = csr_matrix((weight, (one, two)), (len(s.vertices),) * 2)
        share = 0.4 + np.asarray(step.sum(axis=1)).ravel()
        around = csr_matrix((np.exp(-2 * ((across**2 + along**2) / reach**2)), (one, two)), step.shape)
        value = rng.normal(size=len(s.vertices))
        for _ in range(round(length)):
            value = (0.4 * value + step @ value) / share
        value = value - (value + around @ value) / (
            1 + np.asarray(around.sum(axis=1)).ravel()
        )  # no wider than a strand
        return np.tanh(1.2 * value / value.std())

    return heights
