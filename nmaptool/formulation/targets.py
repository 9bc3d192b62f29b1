"""Normals and weights to the linear system: Eq. 6 and Eq. 8 of Wei et al. 2018 (and Eq. 4), resolution apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nmaptool.arrays import Float32, Float64
from nmaptool.formulation.domain import Domain
from nmaptool.grid import corner_sum, height_slopes
from nmaptool.model import NormalMap
from nmaptool.vectors import slopes

REFERENCE_SIDE_PX = 1000


@dataclass(frozen=True, eq=False)
class Weights:
    """mu, beta and delta in pixels of this very picture, each a scalar times an optional (H, W) map.

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
    """Beta and delta as they are meant at 1000 px on the longer side, for this size; or literally.

    >>> to_pixels(0.01, 10.0, 500, per_pixel=False)
    (0.04, 5.0)
    """
    if per_pixel:
        return beta, delta
    scale = longer_side / REFERENCE_SIDE_PX
    return beta / scale**2, delta * scale


@dataclass(frozen=True, eq=False)
class Targets:
    """The pieces of the right-hand side and the weights.

    Attributes
    ----------
    weight : (H, W) float64
        Face weights k_f.
    p, q : (H, W) float64
        Target slopes, each times its weight.
    beta : (H+1, W+1) float64
        Height weight per vertex.
    pull : (H+1, W+1) float64
        beta delta for delta = 1.
    steep_share : float
        Share of the acting faces whose slope was capped.
    """

    weight: Float64
    p: Float64
    q: Float64
    beta: Float64
    pull: Float64
    steep_share: float


def _mapped(value: float, by: Float32 | None, shape: tuple[int, int]) -> Float64:
    return np.full(shape, value) if by is None else value * by.astype(np.float64)


def _steep_share(normals: Float32, acting: np.ndarray, cap: float) -> float:
    across = np.hypot(normals[..., 0], normals[..., 1])
    return float((across > cap * normals[..., 2])[acting].mean())


def aim(
    original: NormalMap, detail: NormalMap | None, domain: Domain, weights: Weights, cap: float, energy: str
) -> Targets:
    """State the least-squares problem for one or two maps.

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
        "eq6": target slope (g_O + mu g_D)/(1 + mu) with weight 1 + mu; "eq4": g_O + mu g_D with weight 1. Both count
        from the slopes of a held background, and fade with the share of each face that is motif.
    """
    shape = original.frame.shape
    acting = domain.acting.astype(np.float64)
    p, q = (slope * acting for slope in slopes(original.normals, cap))
    share = acting if domain.share is None else domain.share * acting
    p_base, q_base = height_slopes(domain.base_px)
    # what stands out of the held background; where nothing is held, that is everything
    p, q = share * (p - acting * p_base), share * (q - acting * q_base)
    weight = acting
    if detail is not None:
        mu = _mapped(weights.mu, weights.mu_map, shape) * acting
        p_detail, q_detail = slopes(detail.normals, cap)
        p += mu * share * detail.coverage * p_detail
        q += mu * share * detail.coverage * q_detail
        if energy == "eq6":
            weight = weight + mu
    p += weight * p_base
    q += weight * q_base
    beta = _mapped(weights.beta, weights.beta_map, shape) * domain.foreground
    if domain.share is not None:
        beta = beta * domain.share
    pull = beta if weights.delta_map is None else beta * weights.delta_map
    steep = _steep_share(original.normals, domain.acting, cap)
    return Targets(weight, p, q, corner_sum(beta) / 4, corner_sum(pull) / 4, steep)
