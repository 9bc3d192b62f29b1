"""Height fields as few triangles: right-angled ones of all sizes, within a strict error."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.errors import InputError
from nmaptool.core.grid import touching_vertices
from nmaptool.solids.split_errors import close, split_errors, surface, tile_side
from nmaptool.solids.thinned_mesh import Thinned

Steps = tuple[Float64, int]


class Thinner:
    """The triangles of height fields over a mask for any tolerance.

    Parameters
    ----------
    heights : sequence of (H+1, W+1) float64
        In mm. The same triangles serve for all.
    mask : (H, W) bool
    kept : (H+1, W+1) bool
        Vertices that stay.
    """

    def __init__(self, heights: Sequence[Float64], mask: Mask, kept: Mask) -> None:
        self.heights = heights
        self.mask = mask
        self.side = tile_side(*mask.shape)
        self._errors = split_errors(heights, mask, kept)

    def at(self, bound_mm: float) -> Thinned:
        """The triangles for a value of `steps`; infinite for the fewest.

        Their error is at most so large, except for the rounding of numbers.
        """
        return self._mesh(self._active(self._errors, bound_mm))

    def within(self, max_error_mm: float) -> Thinned:
        """The triangles whose error is at most so large."""
        errors = self._errors
        while True:
            active = self._active(errors, max_error_mm)
            off = self._deviations(active)
            too_far = off > max_error_mm
            if not too_far.any():
                return self._mesh(active, off)
            # by the rounding of numbers: these vertices come in
            errors = errors.copy()
            errors[: off.shape[0], : off.shape[1]][too_far] = np.inf
            close(errors, self.side)

    def _active(self, errors: Float64, bound_mm: float) -> Mask:
        active: Mask = errors > bound_mm if np.isfinite(bound_mm) else np.isinf(errors)
        return active

    def _mesh(self, active: Mask, off: Float64 | None = None) -> Thinned:
        off = self._deviations(active) if off is None else off
        return Thinned(self.mask, active, self.side, self.heights[0], float(off.max()))

    def _deviations(self, active: Mask) -> Float64:
        """(H+1, W+1) float64: vertical distances of the vertices of the mask from triangles."""
        known = touching_vertices(self.mask)
        out = np.zeros(known.shape)
        for z_mm in self.heights:
            z = np.where(known, z_mm, 0.0)
            off = surface(z, active, self.side)
            off -= z
            np.abs(off, out=off)
            np.maximum(out, off, out=out, where=known)
        return out

    def steps(self) -> tuple[Float64, Float64]:
        """Tolerances in mm at which vertices come in: those inside of the mask, and those on its outline."""
        rows, cols = self.mask.shape
        around = np.zeros((rows + 1, cols + 1), np.uint8)
        for down, right in ((0, 0), (0, 1), (1, 0), (1, 1)):
            around[down : down + rows, right : right + cols] += self.mask
        errors = self._errors[: rows + 1, : cols + 1]
        finite = np.isfinite(errors) & (errors > 0)
        return errors[finite & (around == 4)], errors[finite & (around == 2)]


def tolerance_for(limit: int, fewest: int, steps: Sequence[Steps], given: str | None = None) -> float:
    """The smallest error that needs at most so many triangles.

    Parameters
    ----------
    limit : int
        Triangles.
    fewest : int
        Triangles at any error.
    steps : sequence of (float64 array, int)
        Errors in mm below which vertices come in, and how many triangles each vertex adds.
    given : str, optional
        The limit in the words of whoever gave it.

    Raises
    ------
    InputError
        If the limit is below ``fewest``.
    """
    if fewest > limit:
        raise InputError(
            f"`triangles='{given or limit}'`: the outline alone needs {fewest:,} triangles; allow more, or give "
            "`max_error`, such as `max_error='0.01mm'`"
        )
    # positive numbers have the order of their bits; what lies above the upper bound is counted once
    left = [(errors, each) for errors, each in steps if len(errors)]
    low, high = -1, int(np.float64(np.inf).view(np.int64))
    count = fewest
    while high - low > 1:
        middle = (low + high) // 2
        bound = np.int64(middle).view(np.float64)
        added = sum(each * int(np.count_nonzero(errors > bound)) for errors, each in left)
        if count + added <= limit:
            high, count = middle, count + added
            left = [(errors[errors <= bound], each) for errors, each in left]
        else:
            low = middle
            left = [(errors[errors > bound], each) for errors, each in left]
    return float(np.int64(high).view(np.float64))


def thin(
    z_mm: Float64,
    mask: Mask,
    kept_vertices: Mask,
    *,
    max_error_mm: float | None = None,
    max_triangles: int | None = None,
) -> Thinned:
    """Cover the pixels of a mask with as few triangles as an error allows, or as exactly as a number allows.

    Parameters
    ----------
    z_mm : (H+1, W+1) float64
        Heights. Vertices that do not touch the mask are not looked at.
    mask : (H, W) bool
    kept_vertices : (H+1, W+1) bool
        Vertices that stay. Those that the outline needs stay anyway.
    max_error_mm : float, optional
        Largest vertical distance of a vertex from the triangles. Default: infinite.
    max_triangles : int, optional

    Returns
    -------
    Thinned

    Raises
    ------
    InputError
        If the outline needs more than ``max_triangles``.
    """
    thinner = Thinner([z_mm], mask, kept_vertices)
    if max_triangles is None:
        return thinner.within(np.inf if max_error_mm is None else max_error_mm)
    inside, outline = thinner.steps()
    return thinner.at(tolerance_for(max_triangles, thinner.at(np.inf).face_count, [(inside, 2), (outline, 1)]))
