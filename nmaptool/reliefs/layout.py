"""A domain and its statistics."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float32, Float64, Mask, read_only
from nmaptool.core.grid import touching_vertices
from nmaptool.reliefs.domain import Domain
from nmaptool.reliefs.standing import Standing


@dataclass(frozen=True)
class MotifFacts:
    """What a report says about the motif.

    Attributes
    ----------
    shape : (int, int)
        Rows and columns of the picture.
    share, flat_share, left_alone : float
        Share of the picture that is motif; share of the motif that is flat against the viewer; share of the picture
        that is motif without the height term.
    holds : bool
        Whether vertices are held.
    edge_height_mm : float or None
        Mean height of the motif's walls; None without walls.
    """

    shape: tuple[int, int]
    share: float
    flat_share: float
    left_alone: float
    holds: bool
    edge_height_mm: float | None = None


class Layout:
    """A domain and its statistics, computed once.

    Parameters
    ----------
    domain : Domain
    motif : (H, W) bool
    tolerance : float
        Tolerance to which the background was integrated, if it is a normal map.
    coverage : (H, W) float32
        Share of each pixel that is motif.
    standing : Standing, optional
        The motif, where it stands on its plate with walls.
    flat_share : float
        Share of the motif that is flat against the viewer.
    """

    def __init__(
        self,
        domain: Domain,
        motif: Mask,
        tolerance: float,
        coverage: Float32,
        standing: Standing | None = None,
        flat_share: float = 0.0,
    ) -> None:
        self.domain = domain
        self.coverage = read_only(coverage)
        self.standing = standing
        self.motif = read_only(motif)
        self.tolerance = tolerance
        # None: every vertex
        self._inside = None if domain.surface.all() else touching_vertices(domain.surface)
        self.holds = bool(domain.held.any())
        self.motif_share = float(motif.mean())
        self.flat_share = flat_share
        self.left_alone = float((motif & ~domain.foreground).mean())

    @functools.cached_property
    def _motif_vertices(self) -> Mask:
        return touching_vertices(self.motif)

    def facts(self, z_mm: Float64) -> MotifFacts:
        """Return what a report says, for finished heights."""
        edge_mm = None if self.standing is None else self.standing.mean_edge(z_mm)
        rows, cols = self.motif.shape
        return MotifFacts((rows, cols), self.motif_share, self.flat_share, self.left_alone, self.holds, edge_mm)

    def inside(self, z: Float64) -> Float64:
        """Return the heights of the surface's vertices as a 1-D array."""
        return z.ravel() if self._inside is None else z[self._inside]

    def range_of(self, z: Float64) -> tuple[float, float]:
        """Return the lowest and highest height of the surface."""
        values = self.inside(z)
        return float(values.min()), float(values.max())

    def share_below(self, above: Float64) -> float:
        """Return the share of the motif's vertices that are below the background."""
        return np.count_nonzero((above < 0) & self._motif_vertices) / np.count_nonzero(self._motif_vertices)
