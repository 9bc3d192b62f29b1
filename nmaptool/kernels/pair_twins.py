"""Sums of the surface filter over pairs of nodes and at faces, in NumPy: the twins of ``pairs.h``."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Float64

_WEIGHTS_AT_ONCE = 100_000
# maps the squares of eight columns to -|place|^2 / 2 and -|guide|^2 / 2
_HALVES = np.repeat(np.eye(3, 2, dtype=np.float32), (3, 3, 2), axis=0) * np.float32(-0.5)

Whole = NDArray[np.int64]


def pair_sums(
    places: Float32,
    sums: Float32,
    start: Whole,
    indptr: Whole,
    near: Whole,
    first: int,
    last: int,
    radius2: float,
    out: Float32,
) -> None:
    """Write the weighted sums at each node, and their first moments in place and guide, to ``out``.

    Parameters
    ----------
    places : (K, 6) float32
        Mean position over sigma_s and mean guide over sigma_r of each node; nodes are ordered by large patch.
    sums : (K, 4) float32
        Sum of area times normal, and of area.
    start : (P + 1,) int64
        The first node of each large patch.
    indptr, near : (P + 1,) and (N,) int64
        The large patches that each large patch reaches, in compressed rows.
    first, last : int
        The large patches whose nodes are summed.
    radius2 : float
        Squared distance of places beyond which the weight is 0.
    out : (K, 28) float32
        4 sums, and 24 sums of their products with places.
    """
    own = np.diff(start)
    reached = np.add.reduceat(np.append(own[near], 0), indptr[:-1]) * (np.diff(indptr) > 0)
    count = len(places)
    moments = np.empty((count + 1, 28), np.float32)
    moments[:count, :4] = sums
    moments[:count, 4:] = (sums[:, :, None] * places[:, None, :]).reshape(count, 24)
    moments[count] = 0  # an empty node that pads shorter lists of sources
    wide = np.zeros((count + 1, 8), np.float32)
    wide[:count, :6] = places
    for batch in _batches(own[first:last], reached[first:last]):
        large = batch + first
        # the nodes of one large patch have the same sources, so their weights form a dense block
        mine = start[large][:, None] + np.arange(own[large[0]])
        others = _sources(start, indptr, near, large, reached[large], count)
        sources = wide.take(others, axis=0)
        sources -= wide.take(mine[:, :1], axis=0)
        weights = _weights(wide.take(mine, axis=0) - wide.take(mine[:, :1], axis=0), sources, radius2)
        out[mine] = weights @ moments.take(others, axis=0)


def at_faces(sums: Float32, places: Float32, node: Whole, where: Float64, lead: Float64, out: Float64) -> None:
    """Write the sums at faces, extrapolated from those at nodes by their first derivatives, to ``out``.

    For small steps u, the weights change by exp(u . (source - node)). The factor exp(-|u|^2 / 2) is omitted: it is the
    same for all sources of a face, and only directions matter.

    Parameters
    ----------
    sums : (K, 28) float32
        As `pair_sums` writes them.
    places : (K, 6) float32
    node : (M,) int64
        The node of each face.
    where, lead : (M, 3) float64
        Position over sigma_s and guide over sigma_r of each face.
    out : (M, 4) float64
    """
    value = sums[:, :4].astype(np.float64)
    slope = sums[:, 4:].reshape(-1, 4, 6) - value[:, :, None] * places[:, None, :]
    step = np.hstack([where, lead]) - places.take(node, axis=0)
    np.add(value.take(node, axis=0), np.einsum("ijk,ik->ij", slope.take(node, axis=0), step), out=out)


def _batches(own: Whole, reached: Whole) -> Iterator[Whole]:
    """Yield batches of large patches with equally many nodes and about as many sources; a batch fits the cache."""
    order = np.lexsort([reached, own])
    mine, others = own[order], reached[order]
    first = 0
    while first < len(order):
        last = first + max(1, _WEIGHTS_AT_ONCE // max(1, int(mine[first] * others[first])))
        last = min(last, int(np.searchsorted(mine, mine[first], side="right")))
        last = first + int(np.searchsorted(others[first:last], 1.1 * others[first] + 4, side="right"))
        yield order[first:last]
        first = last


def _sources(start: Whole, indptr: Whole, near: Whole, large: Whole, reached: Whole, filler: int) -> Whole:
    """Return (B, S) int64: the nodes that each large patch of a batch reaches; shorter lists are padded."""
    begin, end = indptr[large], indptr[large + 1]
    found = near.take(_ranges(begin, end - begin))
    out = np.full((len(large), int(reached.max())), filler)
    out[np.arange(out.shape[1]) < reached[:, None]] = _ranges(start[found], start[found + 1] - start[found])
    return out


def _ranges(begin: Whole, size: Whole) -> Whole:
    """Return begin[0], begin[0] + 1, ... begin[0] + size[0] - 1, begin[1], ..."""
    ends = np.cumsum(size)
    return np.asarray(np.arange(ends[-1]) + np.repeat(begin - (ends - size), size), np.int64)


def _weights(targets: Float32, sources: Float32, radius2: float) -> NDArray[Any]:
    """Return (B, T, S) float32: the product of both Gaussians, 0 beyond the radius.

    Places and guides are in the first six of eight columns; the other two of ``sources`` are overwritten.
    """
    # -|t - s|^2 / 2 = t . s - |s|^2 / 2 - |t|^2 / 2; one matrix product gives the first two terms
    count = targets.shape[1]
    left = np.zeros((len(targets), 2 * count, 8), np.float32)
    left[:, :count, :3], left[:, :count, 6] = targets[..., :3], 1
    left[:, count:, :6], left[:, count:, 6:] = targets[..., :6], 1
    sources[..., 6:] = np.square(sources) @ _HALVES
    product = left @ sources.swapaxes(-1, -2)
    own = np.square(targets) @ _HALVES
    product[:, count:] += own.sum(axis=-1, keepdims=True)
    weights = np.exp(product[:, count:])
    weights *= product[:, :count] >= -(own[..., :1] + np.float32(0.5 * radius2))
    return weights
