"""The size of detail on a mesh: sigma_s in units of the mesh."""

from __future__ import annotations

import numpy as np

from nmaptool.core.units import Length
from nmaptool.options import FilterOptions
from nmaptool.types.mesh import Mesh

# in mean edge lengths: with a smaller sigma_s, no two faces would be averaged
_LEAST_EDGES = 0.01
# share of the mesh size above which sigma_s removes forms as detail
_LARGEST_DETAIL = 0.06


def sigma_s_of(mesh: Mesh, options: FilterOptions) -> float:
    """Return sigma_s in units of a clean mesh; at least 0.01 edges, so positions divided by it stay in range."""
    if not isinstance(options.sigma_s, Length):
        return options.sigma_s * mesh.mean_edge
    if options.sigma_s.is_absolute:
        size = options.sigma_s.to_mm(1.0, 1) / mesh.mm_per_unit
    else:
        size = options.sigma_s.value / 100 * float(np.ptp(mesh.vertices, axis=0).max())
    return max(size, _LEAST_EDGES * mesh.mean_edge)


def long_edges(mesh: Mesh, options: FilterOptions) -> list[str]:
    """Return a warning if sigma_s, given in edge lengths, is large compared to a clean mesh; otherwise none."""
    if options.filter == "learned":
        return []
    share = sigma_s_of(mesh, options) / float(np.ptp(mesh.vertices, axis=0).max())
    if isinstance(options.sigma_s, Length) or share <= _LARGEST_DETAIL:
        return []
    words = f"the edges are long: `sigma_s` is {share:.0%} of the mesh size, so forms of that size count as detail"
    return [f"{words}; use `sigma_s='2%'`"]
