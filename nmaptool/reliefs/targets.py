"""Build the linear system from normals and weights, at any resolution: Eq. 4, 6 and 8 of Wei et al. 2018."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from nmaptool.core.arrays import Float32, Float64, Mask
from nmaptool.core.grid import height_slopes
from nmaptool.core.parallel import for_each_band
from nmaptool.core.vectors import slopes
from nmaptool.reliefs.domain import Domain
from nmaptool.types.normal_map import NormalMap

REFERENCE_SIDE_PX = 1000
_FACES_AT_ONCE = 1 << 16
_Array = TypeVar("_Array", Float32, Float64)


@dataclass(frozen=True, eq=False)
class Weights:
    """mu, beta and delta in pixels of this picture, each a scalar times an optional (H, W) map.

    Attributes
    ----------
    mu, beta, delta : float
    mu_map, beta_map, delta_map : (H, W) float32 or None
    """

    mu: float
    beta: float
    delta: float
    mu_map: Float32 | None = None
    beta_map: Float32 | None = None
    delta_map: Float32 | None = None

    def reach_px(self, energy: str) -> float:
        """Distance sqrt(k/beta) over which the height term acts, without weight maps; infinite for beta 0.

        k is the weight of the slopes: 1 + mu in "eq6", 1 in "eq4".
        """
        stiffness = 1 + self.mu if energy == "eq6" else 1.0
        return float(np.sqrt(stiffness / self.beta)) if self.beta > 0 else float("inf")


def to_pixels(beta: float, delta: float, longer_side: int, per_pixel: bool) -> tuple[float, float]:
    """Convert beta and delta, which are defined for 1000 px on the longer side, to this size; not if ``per_pixel``.

    >>> to_pixels(0.01, 10.0, 500, per_pixel=False)
    (0.04, 5.0)
    """
    if per_pixel:
        return beta, delta
    scale = longer_side / REFERENCE_SIDE_PX
    return beta / scale**2, delta * scale


@dataclass(frozen=True, eq=False)
class CappedSlopes:
    """Slopes of a map, reduced to a cap where they are steeper.

    Attributes
    ----------
    p, q : (H, W) float32
        Slopes dz/dx and dz/dy (y up).
    steep : (H, W) bool
        Where the map is steeper than the cap.
    """

    p: Float32
    q: Float32
    steep: Mask


def capped_slopes(normals: Float32, cap: float) -> CappedSlopes:
    """Return the capped slopes of (H, W, 3) float32 unit normals."""
    shape = normals.shape[:2]
    p, q, steep = np.empty(shape, np.float32), np.empty(shape, np.float32), np.empty(shape, bool)

    def fill(band: slice) -> None:
        part = normals[band]
        p[band], q[band] = slopes(part, cap)
        nx, ny, steepest = part[..., 0], part[..., 1], np.float32(cap) * part[..., 2]
        steep[band] = nx * nx + ny * ny > steepest * np.maximum(steepest, 0)
        steep[band] |= steepest < 0

    for_each_band(shape[0], _rows_at_once(shape), fill)
    return CappedSlopes(p, q, steep)


@dataclass(frozen=True, eq=False)
class Targets:
    """The terms of the right-hand side and the weights, in float32; sums over faces are float64.

    Attributes
    ----------
    weight : (H, W) float32
        Face weights k_f.
    p, q : (H, W) float32
        Target slopes, each times its weight.
    beta : (H+1, W+1) float32
        Height weight per vertex.
    pull : (H+1, W+1) float32
        beta delta for delta = 1; without a delta map, it is the same array as ``beta``.
    steep_share : float
        Share of the acting faces whose slope was capped.
    """

    weight: Float32
    p: Float32
    q: Float32
    beta: Float32
    pull: Float32
    steep_share: float

    def shape_load(self, base_px: Float64 | None) -> Float64:
        """Return the (H+1, W+1) float64 load for delta = 0: slopes, plus beta times the height of the background."""
        load = np.zeros(self.beta.shape)

        def fill(band: slice) -> None:
            above, upper, below, lower = _faces_at(band, load[band], len(self.p))
            rising, falling = _halves(self.p[above], self.q[above])
            upper[:, :-1] -= rising
            upper[:, 1:] += falling
            rising, falling = _halves(self.p[below], self.q[below])
            lower[:, :-1] -= falling
            lower[:, 1:] += rising
            if base_px is not None:
                load[band] += self.beta[band] * base_px[band]  # in float64, like the heights

        for_each_band(len(load), _rows_at_once(load.shape), fill)
        return load


def build_targets(
    original: NormalMap,
    detail: NormalMap | None,
    domain: Domain,
    weights: Weights,
    cap: float,
    energy: str,
    capped: tuple[CappedSlopes, CappedSlopes | None] | None = None,
) -> Targets:
    """Build the least-squares problem for one or two maps.

    Parameters
    ----------
    original : NormalMap
        O, or B for a structure-preserving relief.
    detail : NormalMap or None
        D; without it mu has no effect (Eq. 8).
    domain : Domain
    weights : Weights
    cap : float
        Slope cap.
    energy : {"eq6", "eq4"}
        "eq6": target slope (g_O + mu g_D)/(1 + mu) with weight 1 + mu; "eq4": g_O + mu g_D with weight 1. Both are
        relative to the slopes of a held background, and scaled by the share of each face that is motif.
    capped : pair of CappedSlopes, optional
        Capped slopes of both maps, if already computed.
    """
    shape = original.frame.shape
    if capped is None:
        capped = capped_slopes(original.normals, cap), None if detail is None else capped_slopes(detail.normals, cap)
    first, second = capped
    weight, p, q, beta = (np.empty(shape, np.float32) for _ in range(4))
    steep: list[tuple[int, int]] = []

    def fill(band: slice) -> None:
        acting = domain.acting[band]
        share = acting if domain.share is None else domain.share[band] * acting
        weight[band] = acting
        np.multiply(first.p[band], share, out=p[band])
        np.multiply(first.q[band], share, out=q[band])
        if detail is not None and second is not None:
            mu = _mapped(weights.mu, weights.mu_map, band) * acting
            if energy == "eq6":
                weight[band] += mu
            mu = mu * share * detail.coverage[band]
            p[band] += mu * second.p[band]
            q[band] += mu * second.q[band]
        if domain.base_px is not None:
            # add the slopes of the held background to those of the motif
            p_base, q_base = height_slopes(domain.base_px[band.start : band.stop + 1])
            p[band] += (weight[band] - share) * p_base
            q[band] += (weight[band] - share) * q_base
        beta[band] = _mapped(weights.beta, weights.beta_map, band) * domain.foreground[band]
        if domain.share is not None:
            beta[band] *= domain.share[band]
        steep.append((int(np.count_nonzero(first.steep[band] & acting)), int(np.count_nonzero(acting))))

    for_each_band(shape[0], _rows_at_once(shape), fill)
    pull = at_vertices = _at_vertices(beta)
    if weights.delta_map is not None:
        pull = _at_vertices(beta, weights.delta_map)
    capped, acting = (sum(counts) for counts in zip(*steep, strict=True))
    return Targets(weight, p, q, at_vertices, pull, capped / acting if acting else 0.0)


def _mapped(value: float, by: Float32 | None, band: slice) -> Any:
    return np.float32(value) if by is None else np.float32(value) * by[band]


def _at_vertices(faces: Float32, by: Float32 | None = None) -> Float32:
    """Return (H+1, W+1): a quarter of the sum of ``faces`` times ``by`` over the faces at each vertex."""
    rows, cols = faces.shape
    out = np.zeros((rows + 1, cols + 1), np.float32)

    def fill(band: slice) -> None:
        part = out[band]
        above, upper, below, lower = _faces_at(band, part, rows)
        for warm_start, at in ((above, upper), (below, lower)):
            values = faces[warm_start] if by is None else faces[warm_start] * by[warm_start]
            at[:, :-1] += values
            at[:, 1:] += values
        part *= np.float32(0.25)

    for_each_band(rows + 1, _rows_at_once(out.shape), fill)
    return out


def _halves(p: Float32, q: Float32) -> tuple[Float64, Float64]:
    """Return half the sum and half the difference of slopes, in float64."""
    wide = p.astype(np.float64)
    return (wide + q) / 2, (wide - q) / 2


def _faces_at(band: slice, vertices: _Array, rows: int) -> tuple[slice, _Array, slice, _Array]:
    """Return the rows of faces above a band of vertices and the vertices that have such a face; the same for below."""
    above = slice(max(band.start - 1, 0), band.stop - 1)
    below = slice(band.start, min(band.stop, rows))
    return above, vertices[len(vertices) - (above.stop - above.start) :], below, vertices[: below.stop - below.start]


def _rows_at_once(shape: tuple[int, ...]) -> int:
    return max(1, _FACES_AT_ONCE // shape[1])
