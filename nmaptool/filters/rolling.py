"""Rolling guidance over any neighbourhood, and the split of a field of normals by its result."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.progress import Progress
from nmaptool.filters.mixture import fit_mixture
from nmaptool.types.mesh import Mesh
from nmaptool.types.mixture import Mixture
from nmaptool.types.shown import OneLine, counted

# a sum shorter than this share of its weight has no direction: the normals around a face cancel out
_AGREEMENT = 0.4
# least weight of a sum, in mean face areas: approximate sums of weights may be negative
_LEAST_WEIGHT = 1e-12
# normals are rounded to multiples of this, so that base + residual equals the original exactly
_STEP = 2.0**-40

# (guide or None) -> (M, 4): for every face, the weighted sum of the original normals around it, and the sum of weights
Gather = Callable[[Float64 | None], Float64]


class GatherMaker(Protocol):
    """Creates a `Gather` for one kind of neighbourhood."""

    def __call__(self, mesh: Mesh, sigma_s: float, sigma_r: float) -> Gather:
        """Return the function that sums the normals of the mesh.

        Parameters
        ----------
        mesh : Mesh
            Clean and welded.
        sigma_s : float
            Spatial sigma in units of the mesh.
        sigma_r : float
            Range sigma, of differences of unit normals.
        """


@dataclass(frozen=True, eq=False, repr=False)
class Decomposition(OneLine):
    """A field of unit normals N split into base and detail; N = base + residual holds exactly.

    Attributes
    ----------
    normals : (M, 3) float64
        The field that was split.
    filtered : (M, 3) float64
        The filtered field.
    base : (M, 3) float64
        N_B.
    residual : (M, 3) float64
        N_D = N - N_B; zero where the base is the original.
    is_detail : (M,) bool
        Where the filter changed the normal by more than the threshold.
    mixture : Mixture
        The lengths |N - filtered| and the threshold found in them.
    """

    normals: Float64
    filtered: Float64
    base: Float64
    residual: Float64
    is_detail: Mask
    mixture: Mixture

    def _line(self) -> str:
        normals = counted(len(self.normals), "normal")
        return f"of {normals}: {self.is_detail.mean():.0%} detail, theta {self.mixture.theta:.4g}"


def rolling_guidance(normals: Float64, gather: Gather, iterations: int, progress: Progress | None = None) -> Float64:
    """Filter normals by rolling guidance (paper, Eq. 1): average the original normals, guided by the previous average.

    Parameters
    ----------
    normals : (M, 3) float64
        Unit normals.
    gather : callable
        Returns the sums of the original normals around each face, weighted by area, distance and, with a guide, by the
        similarity of the guide's normals.
    iterations : int
        Passes, at least 1; the first has no guide.

    Returns
    -------
    (M, 3) float64
        Unit normals; the original ones where the normals around a face cancel out, as they do around parts thinner than
        the neighbourhood.
    """
    guide: Float64 | None = None
    for step in range(iterations):
        if progress is not None:
            progress("filtering", step / iterations)
        guide, _ = mean_normals(normals, gather(guide))
    assert guide is not None  # at least one pass
    return guide


def mean_normals(normals: Float64, sums: Float64) -> tuple[Float64, Float64]:
    """Return the (M, 3) float64 unit vectors of (M, 4) sums, and the (M,) agreement of the normals in each sum.

    The agreement is the length of the sum over its weight: 1 if all normals are equal, 0 if they cancel out. Where it
    is small, the original normal is kept.
    """
    length = np.sqrt(np.einsum("ij,ij->i", sums[:, :3], sums[:, :3]))
    lost = ~(length > _AGREEMENT * sums[:, 3])
    found = sums[:, :3] / np.where(lost, 1, length)[:, None]
    found[lost] = normals[lost]
    return found, (length / np.maximum(sums[:, 3], _LEAST_WEIGHT)).clip(0, 1)


def weighted_normals(normals: Float64, areas: Float64) -> Float64:
    """Return (M, 4) float64: what each face adds to the sums around it, its area times its normal, and its area."""
    relative = areas[:, None] / areas.mean()
    return np.hstack([normals * relative, relative])


def split_residuals(normals: Float64, filtered: Float64, weights: Float64, keep_small: bool = True) -> Decomposition:
    """Split normals by the length of their residuals.

    Parameters
    ----------
    normals, filtered : (M, 3) float64
        Unit normals before and after the filter.
    weights : (M,) float64
        Areas.
    keep_small : bool
        If True, the base is the original where the residual is not longer than the threshold (GRNF); if False, it is
        the filtered normals everywhere (RNF).
    """
    normals, filtered = (np.round(n / _STEP) * _STEP for n in (normals, filtered))
    residual = normals - filtered
    length = np.sqrt(np.einsum("ij,ij->i", residual, residual))
    mixture = fit_mixture(length, weights)
    is_detail = length > mixture.theta
    base = np.where(is_detail[:, None], filtered, normals) if keep_small else filtered
    return Decomposition(normals, filtered, base, normals - base, is_detail, mixture)
