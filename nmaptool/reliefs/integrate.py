"""A normal map that is a surface all over, to its heights."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError
from nmaptool.core.grid import touching_vertices
from nmaptool.reliefs.domain import build_domain
from nmaptool.reliefs.targets import Weights, build_targets
from nmaptool.solver import QuadSystem, prepare
from nmaptool.types.normal_map import NormalMap


def integrate(normal_map: NormalMap, slope_cap: float = 3.0, tolerance: float = 1e-8) -> Float64:
    """Heights in px whose slopes are the map's in the least-squares sense, the lowest point at 0.

    Parameters
    ----------
    normal_map : NormalMap
        Only where it is covered (by half or more) has it a height; separate parts count each from their own mean.
    slope_cap, tolerance : float
        As in `nmaptool.ReliefOptions`.

    Returns
    -------
    (H+1, W+1) float64
        0 where nothing is covered.

    Raises
    ------
    InputError
        If nothing is covered.
    ConvergenceError
        If the solver does not reach the tolerance.
    """
    covered = normal_map.coverage >= 0.5
    if not covered.any():
        raise InputError(
            f"{normal_map.name}: all of it is background ({normal_map.decoding.background}); if it is a surface, say "
            "--background-color none"
        )
    domain = build_domain("free", covered, covered)
    targets = build_targets(normal_map, None, domain, Weights(0, 0, 0), slope_cap, "eq6")
    solver = prepare(QuadSystem(targets.weight, targets.beta, domain.held))
    z: Float64 = solver.solve(targets.shape_load(None), tolerance=tolerance).z
    inside = touching_vertices(covered)
    return np.where(inside, z - z[inside].min(), 0)
