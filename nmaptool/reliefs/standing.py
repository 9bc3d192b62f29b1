"""A motif that stands on its plate with vertical walls: its pixels, its islands, its heights."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from nmaptool.core.arrays import Float32, Float64, Mask
from nmaptool.core.errors import InputError, UsageError
from nmaptool.core.grid import places, touching_corners, touching_vertices
from nmaptool.options import ReliefOptions
from nmaptool.types.relief import MOSTLY_FLAT

# normals within ten degrees of the viewer are flat
_FLAT_NZ = float(np.cos(np.radians(10)))
# least height of a wall whose height is not given, as a share of the range of its motif
_LEAST_WALL = 0.05
_ROUNDING = 1e-9


def flat_share(normals: Float32, motif: Mask) -> float:
    """Share of a motif whose normals lie within ten degrees of the viewer."""
    return float((normals[..., 2][motif] > _FLAT_NZ).mean())


def stands(options: ReliefOptions, normals: Float32, motif: Mask, has_wall_mask: bool) -> bool:
    """Whether the outline of a motif is a wall: as the options say, or because much of the motif is flat.

    Raises
    ------
    UsageError
        If a mask says where it is a wall, and the options say that there is none.
    """
    if has_wall_mask:
        if options.edge == "blend":
            raise UsageError("`wall_mask`: needs `edge='wall'`")
        return True
    if options.edge != "auto":
        return options.edge == "wall"
    return options.background == "plane" and not motif.all() and flat_share(normals, motif) > MOSTLY_FLAT


def bridged(motif: Mask, coverage: Float32) -> Mask:
    """A motif without pixels that touch only at a corner, where four walls would meet in one line.

    Of the two pixels of the plate at such a corner, the one with more coverage joins the motif.
    """
    out = motif.copy()
    while True:
        falling, rising = touching_corners(out)
        row, col = places(falling | rising)
        if not len(row):
            return out
        falls = falling[row, col]
        first = (row, np.where(falls, col + 1, col))
        second = (row + 1, np.where(falls, col, col + 1))
        takes_first = coverage[first] >= coverage[second]
        out[np.where(takes_first, first[0], second[0]), np.where(takes_first, first[1], second[1])] = True


@dataclass(frozen=True, eq=False)
class Standing:
    """A motif that stands on its plate.

    Attributes
    ----------
    motif : (H, W) bool
        Without pixels that touch only at a corner.
    """

    motif: Mask

    @cached_property
    def _islands(self) -> tuple[Float64, Mask, int]:
        """(H+1, W+1) number of the island of each vertex, 0 on the plate; vertices on the outline; the count."""
        from scipy import ndimage  # takes long to load

        labels, count = ndimage.label(self.motif)
        rows, cols = self.motif.shape
        of_vertices = np.zeros((rows + 1, cols + 1), labels.dtype)
        for down in (0, 1):
            for right in (0, 1):
                part = of_vertices[down : rows + down, right : cols + right]
                np.maximum(part, labels, out=part)
        inside = np.pad(self.motif, 1)
        outline = (of_vertices > 0) & touching_vertices(~inside)[1:-1, 1:-1]
        return of_vertices, outline, count

    def heights(
        self, above: Float64, options: ReliefOptions, edge_px: float | None, wanted_px: float | None
    ) -> Float64:
        """Heights of a motif that was solved free of its plate.

        Parameters
        ----------
        above : (H+1, W+1) float64
            Solved heights in px.
        options : ReliefOptions
        edge_px : float or None
            Mean height of the outline of each island. Default: as solved, but no part of an outline at or below the
            plate.
        wanted_px : float or None
            Exact height from the plate to the highest point.

        Returns
        -------
        (H+1, W+1) float64
            0 on the plate.

        Raises
        ------
        InputError
            If the heights asked for contradict each other, or an outline would reach the plate.
        """
        from scipy import ndimage  # takes long to load

        islands, outline, count = self._islands
        side = -1.0 if options.delta < 0 else 1.0  # an engraving goes down from its plate
        numbers = np.arange(count + 1)
        z = side * above
        means = np.append(0.0, ndimage.mean(z, np.where(outline, islands, -1), numbers[1:]))
        free: Float64 = z - means[islands]
        if edge_px is None:
            low = np.append(0.0, ndimage.minimum(free, np.where(outline, islands, -1), numbers[1:]))
            wall = np.maximum(means, _LEAST_WALL * max(float(np.ptp(free[islands > 0])), _ROUNDING) - low)
            wall[0] = 0.0
            free += wall[islands]
            free *= side if wanted_px is None else side * wanted_px / float(free.max())
            return free
        rest = float(free[islands == 0].max(initial=0.0))  # of a motif that runs down beside it
        factor = _factor(options, float(free[islands > 0].max()), rest, edge_px, wanted_px)
        lowest = -factor * float(free[outline].min())
        if lowest >= edge_px:
            raise InputError(
                f"`edge_height='{options.edge_height}'`: the outline would cut into the plate, because it varies by "
                f"{lowest / edge_px:.3g} times that height; use a larger `edge_height`"
            )
        free *= factor
        free[islands > 0] += edge_px
        free *= side
        return free

    def mean_edge(self, z: Float64) -> float:
        """The mean height of the outline, in the unit of the heights."""
        return float(z[self._islands[1]].mean())


def _factor(options: ReliefOptions, rise_px: float, rest_px: float, edge_px: float, wanted_px: float | None) -> float:
    """What the surface behind the wall is multiplied by to reach the exact height."""
    if wanted_px is None:
        return 1.0
    if wanted_px <= edge_px:
        raise InputError(
            f"`edge_height='{options.edge_height}'`: must be less than `height='{options.height}'`, "
            "which is measured from the plate"
        )
    if rise_px <= _ROUNDING * edge_px and rest_px > 0:
        return wanted_px / rest_px
    if rise_px <= _ROUNDING * edge_px:
        raise InputError(
            f"`height='{options.height}'`: the motif is flat, so its wall is as high as the relief; "
            "leave out `edge_height`"
        )
    factor = (wanted_px - edge_px) / rise_px
    return factor if rest_px <= 0 else min(factor, wanted_px / rest_px)
