"""A normal map that is a surface all over, to its heights."""

from __future__ import annotations

import numpy as np

from nmaptool.arrays import Float64
from nmaptool.errors import InputError
from nmaptool.formulation.domain import lay_out
from nmaptool.formulation.targets import Weights, aim
from nmaptool.model import NormalMap
from nmaptool.solver import QuadSystem, prepare, slope_load


def integrate(normal_map: NormalMap, slope_cap: float = 3.0, tolerance: float = 1e-8) -> Float64:
    """Heights in px whose slopes are the map's in the least-squares sense, the lowest point at 0.

    Parameters
    ----------
    normal_map : NormalMap
        Covered everywhere.
    slope_cap, tolerance : float
        As in `nmaptool.ReliefOptions`.

    Returns
    -------
    (H+1, W+1) float64

    Raises
    ------
    InputError
        If part of the map is not covered.
    ConvergenceError
        If the solver does not reach the tolerance.
    """
    if not (normal_map.coverage >= 0.5).all():
        raise InputError(
            f"{normal_map.name}: a curved background must be defined everywhere, but {normal_map.decoding.background} "
            "was taken for its background; if it is a surface, say --background-color none"
        )
    everywhere = np.ones(normal_map.frame.shape, bool)
    domain = lay_out("free", everywhere, everywhere)
    targets = aim(normal_map, None, domain, Weights(0, 0, 0), slope_cap, "eq6")
    solver = prepare(QuadSystem(targets.weight, targets.beta, domain.held))
    z: Float64 = solver.solve(slope_load(targets.p, targets.q), tolerance=tolerance).z
    lowest: float = z.min()
    return z - lowest
