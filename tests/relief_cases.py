"""Small normal maps of analytic surfaces, and a relief in one call."""

import numpy as np

import nmaptool as nm
from nmaptool.core.grid import height_slopes, touching_vertices
from nmaptool.core.vectors import unit


def normal_map(p, q, foreground=None, name="map"):
    normals = unit(np.stack([-p, -q, np.ones_like(p)], axis=-1))
    coverage = np.ones(p.shape, np.float32) if foreground is None else foreground.astype(np.float32)
    normals[coverage == 0] = (0, 0, 1)
    return nm.NormalMap(normals, coverage, nm.Frame(*p.shape), name=name)


def dome(side=96, bumps=0.0, base=1.0, kind="masked"):
    """A dome with bumps: (original, base, detail) maps; its disc is the foreground."""
    y, x = (side - np.mgrid[0 : side + 1, 0 : side + 1][0], np.mgrid[0 : side + 1, 0 : side + 1][1])
    u, v = (x - side / 2) / (0.42 * side), (y - side / 2) / (0.42 * side)
    smooth = base * 0.35 * side * np.exp(-1.5 * (u**2 + v**2))
    fine = bumps * np.cos(2 * np.pi * x * 12 / side) * np.cos(2 * np.pi * y * 12 / side) * side / 100
    centre = (np.arange(side) + 0.5 - side / 2) / (0.42 * side)
    disc = np.hypot(centre[:, None], centre) < 1 if kind == "masked" else None
    maps = [normal_map(*height_slopes(z), disc) for z in (smooth + fine, smooth)]
    return maps[0], maps[1], normal_map(*height_slopes(fine), disc)


def solve(original, detail=None, **changes):
    given = {k: changes.pop(k) for k in list(changes) if k.endswith("_map") or k in ("mask", "surface")}
    return nm.relief(original, detail, options=nm.ReliefOptions(**changes), **given)


def foreground_heights(relief):
    return relief.z_mm[touching_vertices(relief.foreground) & ~touching_vertices(~relief.foreground)]


def rolling(side=96):
    """Vertex heights of a background that undulates along x."""
    _, x = np.mgrid[0 : side + 1, 0 : side + 1]
    return 6 * np.sin(x / 20.0)
