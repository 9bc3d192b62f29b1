"""Read the outline of a plate from an SVG file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError
from nmaptool.io.vector.crossings import cross_each_other, cross_themselves, crossing_point, holds, rounding
from nmaptool.io.vector.svg import Stretch, read_stretches
from nmaptool.lettering.rings import united
from nmaptool.types.contours import Contours, ring_area

_MOST_RINGS = 1000
_SMALLEST = 1e-9


def read_svg_outline(path: str | Path, *, tolerance_mm: float = 0.002) -> Contours:
    """Read an outline from an SVG file: one closed path or shape, and any number of holes inside it.

    Paths, rectangles, circles, ellipses and polygons count, whatever their stroke and fill. A closed path inside the
    outer one is a hole. The size is that of the drawing: units and the view box are applied, and pixels are 1/96 inch.

    Parameters
    ----------
    path : str or Path
        A plain SVG file without texts.
    tolerance_mm : float
        The greatest distance between the polygons and the curves of the drawing.

    Returns
    -------
    Contours
        In mm, y up, with the lower left corner of its bounds at (0, 0).

    Raises
    ------
    InputError
        If the file is not a readable SVG file, a path is open or crosses itself or another, or there is more than one
        outer path.
    LimitError
        If the file is too large.
    UsageError
        If the tolerance is not a positive number.

    Examples
    --------
    >>> Path("plate.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg"><path d="M0,0 H96 V48 H0 Z"/></svg>')
    75
    >>> f"{nm.read_svg_outline('plate.svg').area_mm2:.4f}"
    '322.5800'
    """
    name = Path(path)
    parts = read_stretches(name, tolerance_mm)
    _check_closed(name, parts)
    if len(parts) > _MOST_RINGS:
        raise InputError(f"{name}: has {len(parts)} closed paths, more than {_MOST_RINGS}; simplify the drawing")
    rings = [part.points for part in parts]
    _check_simple(name, rings)
    if any(abs(ring_area(ring)) < _SMALLEST for ring in rings):
        raise _without_area(name)
    order = sorted(rings, key=lambda ring: -abs(ring_area(ring)))
    outer, holes = order[0], order[1:]
    outside = [hole for hole in holes if not holds(outer, hole)]
    if outside:
        raise InputError(f"{name}: has {1 + len(outside)} outer paths; expected one closed path with holes inside it")
    for number, hole in enumerate(holes):
        if any(holds(other, hole) for other in holes[:number]):
            raise InputError(f"{name}: has a path inside a hole; expected one closed path with holes inside it")
    corner = outer.min(axis=0)
    turned = [_turned(outer, False), *(_turned(hole, True) for hole in holes)]
    # loops as small as rounding were let pass
    clean = united((ring - corner for ring in turned), tolerance_mm).rings
    kept = [ring for ring in clean if abs(ring_area(ring)) > rounding(rings)]
    return Contours(tuple(sorted(kept, key=lambda ring: -ring_area(ring))), tolerance_mm)


def _turned(ring: Float64, is_hole: bool) -> Float64:
    """A ring that runs the right way round."""
    return ring if (ring_area(ring) < 0) == is_hole else np.ascontiguousarray(ring[::-1])


def _check_closed(path: Path, parts: list[Stretch]) -> None:
    """Refuse open paths, and closed ones of two points."""
    opened = [part.gap_mm for part in parts if part.gap_mm > 0]
    if opened:
        which = "the path is" if len(parts) == 1 else f"{len(opened)} of {len(parts)} paths are"
        raise InputError(f"{path}: {which} not closed, the ends are {max(opened):.3g} mm apart; close it")
    if any(len(part.points) < 3 for part in parts):
        raise _without_area(path)


def _without_area(path: Path) -> InputError:
    return InputError(f"{path}: has a closed path without an area; delete it")


def _check_simple(path: Path, rings: list[Float64]) -> None:
    """Refuse paths that cross themselves or each other."""
    if cross_themselves(rings):
        what = "a path crosses itself"
    elif cross_each_other(rings):
        what = "two paths cross or overlap"
    else:
        return
    point = crossing_point(rings)
    where = ""
    if point is not None:
        low = np.concatenate(rings).min(axis=0)
        where = f" at {point[0] - low[0]:.2f},{point[1] - low[1]:.2f} mm from the lower left corner"
    raise InputError(f"{path}: {what}{where}; unite the paths")
