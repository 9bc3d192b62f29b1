"""Integrate a normal map to heights."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError
from nmaptool.core.grid import touching_vertices
from nmaptool.options import ReliefOptions
from nmaptool.reliefs.domain import build_domain
from nmaptool.reliefs.targets import Weights, build_targets
from nmaptool.solver import QuadSystem, prepare
from nmaptool.types.inputs import MaskLike, NormalsLike, as_normal_map
from nmaptool.types.plain_arrays import as_mask, check_sizes


def integrate(
    normals: NormalsLike, mask: MaskLike | None = None, *, slope_cap: float = 3.0, tolerance: float = 1e-8
) -> Float64:
    """Return heights whose slopes fit the normals in the least-squares sense (paper, Eq. 8 without the height term).

    Parameters
    ----------
    normals : NormalMap or (H, W, 3) float of any type
        Normals in eye space: x right, y up, z towards the viewer, row 0 at the top.
    mask : (H, W) bool or float in [0, 1], optional
        The surface is where the mask, and the coverage of a NormalMap, are 0.5 or more. Where the mask is 0, the
        vectors of an array may be anything. Default: everything that is covered.
    slope_cap : float
        Steeper slopes are reduced to this value, above 0; normals that face away count as infinitely steep.
    tolerance : float
        Relative residual of the solve, 1e-14 to 1.

    Returns
    -------
    (H+1, W+1) float64
        Heights at the corners of the pixels, in px; positive is towards the viewer. The lowest is 0, and so are all
        heights outside the surface. Parts that do not touch each other have the same mean height.

    Raises
    ------
    InputError
        If there is no surface, sizes differ, or a normal inside the mask has no direction.
    UsageError
        If a value is neither a NormalMap nor an array, or an option is out of range.
    ConvergenceError
        If the solver does not reach the tolerance.

    Examples
    --------
    A plane that rises by half a pixel per pixel to the right:

    >>> normals = np.zeros((2, 4, 3))
    >>> normals[...] = -0.5, 0, 1
    >>> nm.integrate(normals).round(6)
    array([[0. , 0.5, 1. , 1.5, 2. ],
           [0. , 0.5, 1. , 1.5, 2. ],
           [0. , 0.5, 1. , 1.5, 2. ]])
    """
    chosen = None if mask is None else as_mask(mask)
    normal_map = as_normal_map(normals, "the normals", chosen)
    covered = normal_map.coverage >= 0.5
    if not covered.any():
        raise InputError(
            f"{normal_map.name}: every pixel is background ({normal_map.decoding.background}); if the whole map is a "
            "surface, use `background_color='none'`"
        )
    if chosen is not None:
        check_sizes(normal_map.name, covered.shape, {"the mask": chosen.shape})
        covered &= chosen >= 0.5
        if not covered.any():
            raise InputError("the mask selects no part of the surface: set it to 0.5 or more there")
    ReliefOptions(slope_cap=slope_cap, tolerance=tolerance)  # checks the values
    domain = build_domain("free", covered, covered)
    targets = build_targets(normal_map, None, domain, Weights(0, 0, 0), slope_cap, "eq6")
    solver = prepare(QuadSystem(targets.weight, targets.beta, domain.held))
    z: Float64 = solver.solve(targets.shape_load(None), tolerance=tolerance).z
    inside = touching_vertices(covered)
    return np.where(inside, z - z[inside].min(), 0)
