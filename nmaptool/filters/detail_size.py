"""The size of what counts as detail on a mesh: sigma_s in units of the mesh."""

from __future__ import annotations

import numpy as np

from nmaptool.core.units import Length
from nmaptool.options import FilterOptions
from nmaptool.types.mesh import Mesh

# mean edge lengths: sigma_s below it averages no two faces
_LEAST_EDGES = 0.01
# share of the mesh beyond which sigma_s takes forms for detail
_LARGEST_DETAIL = 0.06


def sigma_s_of(mesh: Mesh, options: FilterOptions) -> float:
    """sigma_s in units of a clean mesh; never so far below an edge that places cannot be counted in it."""
    if not isinstance(options.sigma_s, Length):
        return options.sigma_s * mesh.mean_edge
    if options.sigma_s.is_absolute:
        size = options.sigma_s.to_mm(1.0, 1) / mesh.mm_per_unit
    else:
        size = options.sigma_s.value / 100 * float(np.ptp(mesh.vertices, axis=0).max())
    return max(size, _LEAST_EDGES * mesh.mean_edge)


def long_edges(mesh: Mesh, options: FilterOptions) -> list[str]:
    """A warning where sigma_s, counted in edges, is large beside a clean mesh; else none."""
    if options.filter == "learned":
        return []
    share = sigma_s_of(mesh, options) / float(np.ptp(mesh.vertices, axis=0).max())
    if isinstance(options.sigma_s, Length) or share <= _LARGEST_DETAIL:
        return []
    words = f"its edges are long: sigma_s comes to {share:.0%} of it, and forms of that size go into the detail"
    return [f"{words}; say `sigma_s='2%'`"]
