"""Synthetic inputs of any size: a statue of overlapping domes with holes, in front of rolling ground.

Positions are fractions of the longer side, so the image is the same at every resolution.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

import nmaptool as nm
from nmaptool.core.arrays import Float32, Float64, Mask
from nmaptool.core.vectors import FLAT, unit

_MOTIF_SEED = 11
_DOMES, _HOLES = 30, 12


class Disc(NamedTuple):
    """A dome or a hole, in fractions of the longer side, y up."""

    x: float
    y: float
    radius: float
    lift: float = 0.0


def outline(size: tuple[float, float]) -> tuple[list[Disc], list[Disc]]:
    """The domes of the motif and its holes, for an image of this size in fractions of its longer side."""
    random = np.random.default_rng(_MOTIF_SEED)

    def place(low: float, high: float) -> tuple[float, float]:
        across, up = random.uniform(low, high, 2) * size
        return float(across), float(up)

    domes = [Disc(*place(0.15, 0.85), random.uniform(0.05, 0.17), random.uniform(0, 0.15)) for _ in range(_DOMES)]
    return domes, [Disc(*place(0.2, 0.8), random.uniform(0.008, 0.045)) for _ in range(_HOLES)]


@dataclass(frozen=True, eq=False)
class Scene:
    """The normals of an image and its motif.

    Attributes
    ----------
    normals : (H, W, 3) float32
        Motif and ground.
    motif : (H, W) bool
    """

    normals: Float32
    motif: Mask

    def over_ground(self) -> nm.NormalMap:
        """Defined everywhere, so that every background mode applies; the motif is the foreground."""
        frame = nm.Frame(*self.motif.shape)
        return nm.NormalMap(self.normals, np.ones(frame.shape, np.float32), frame, self.motif)

    def cut_out(self) -> nm.NormalMap:
        """Defined on the motif only, like files with alpha."""
        normals = np.where(self.motif[..., None], self.normals, np.array(FLAT, np.float32))
        return nm.NormalMap(normals, self.motif.astype(np.float32), nm.Frame(*self.motif.shape))

    def all_surface(self) -> nm.NormalMap:
        """Motif and ground are both surface."""
        frame = nm.Frame(*self.motif.shape)
        return nm.NormalMap(self.normals, np.ones(frame.shape, np.float32), frame)


def scene(rows: int, cols: int, ripple_turn: float = 0.0) -> Scene:
    """The statue at a size.

    Parameters
    ----------
    rows, cols : int
    ripple_turn : float
        Direction of the fine ripples in radians; each value gives different normals on the same motif.
    """
    p, q, motif = surface(rows, cols, ripple_turn)
    return Scene(unit(np.dstack([-p, -q, np.ones_like(p)])), motif)


def surface(rows: int, cols: int, ripple_turn: float = 0.0, band: slice = slice(None)) -> tuple[Float64, Float64, Mask]:
    """Slopes p and q of motif and ground, and the motif's mask, for a band of rows of the image."""
    longer = max(rows, cols)
    x = (np.arange(cols) + 0.5) / longer
    y = (rows - np.arange(rows)[band, None] - 0.5) / longer  # up
    p, q = np.broadcast_arrays(0.3 * np.cos(9 * x + 2 * y), 0.3 * np.sin(7 * y - 3 * x))
    p, q = p.copy(), q.copy()
    top = np.full(p.shape, -np.inf)
    domes, holes = outline((cols / longer, rows / longer))
    for dome in domes:
        _raise_dome(top, p, q, x, y, dome)
    motif = np.isfinite(top)
    for hole in holes:
        box = _around(hole, x, y)
        motif[box] &= np.hypot(x[box[1]] - hole.x, y[box[0]] - hole.y) > hole.radius
    across, up = np.cos(ripple_turn), np.sin(ripple_turn)
    ripple = 0.35 * np.cos(260 * (across * x + up * y)) * np.cos(90 * (up * x - across * y))
    p += across * ripple
    q += up * ripple
    return p, q, motif


def _around(disc: Disc, x: Float64, y: Float64) -> tuple[slice, slice]:
    """The rows and columns that a disc can reach; x rises, y falls."""
    left, right = np.searchsorted(x, (disc.x - disc.radius, disc.x + disc.radius))
    top, bottom = np.searchsorted(-y[:, 0], (-disc.y - disc.radius, -disc.y + disc.radius))
    return slice(max(int(top) - 1, 0), int(bottom) + 1), slice(max(int(left) - 1, 0), int(right) + 1)


def _raise_dome(top: Float64, p: Float64, q: Float64, x: Float64, y: Float64, dome: Disc) -> None:
    """Add one half sphere; its slopes are visible where it is in front."""
    box = _around(dome, x, y)
    top, p, q, x, y = top[box], p[box], q[box], x[box[1]], y[box[0]]
    below = dome.radius**2 - (x - dome.x) ** 2 - (y - dome.y) ** 2
    height = np.sqrt(np.maximum(below, 1e-9))
    # domes have different heights: the jumps between them give non-integrable normals, as in real maps
    seen = (below > 0) & (dome.lift + height > top)
    top[seen] = (dome.lift + height)[seen]
    p[seen] = (-(x - dome.x) / height)[seen]
    q[seen] = (-(y - dome.y) / height)[seen]
