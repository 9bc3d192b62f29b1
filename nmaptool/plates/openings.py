"""Holes in a plate with their rims, and the loop of a pendant."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError
from nmaptool.lettering.rings import contours_of, cross_section
from nmaptool.plates.board import Board
from nmaptool.plates.distance import Curves, inside_points
from nmaptool.plates.layout import Layout
from nmaptool.plates.polygons import circle, circle_tolerance, offset, without_short_edges
from nmaptool.plates.profiles import averaged, half_round, slope
from nmaptool.types.contours import Contours
from nmaptool.types.plate import PlateDesign

# least material between a hole and the edge
_WALL_MM = 0.2
_RIM = 0.2
# thickness of a loop by the diameter of its eye, its least thickness, and how far the eye lies above the plate by it
_LOOP = 0.4
_THINNEST_MM = 0.6
_LIFT = 0.35
# edges shorter than this share of a pixel would make needles of triangles
_SHORTEST = 1e-3


@dataclass(frozen=True)
class Opening:
    """A round hole with a rim.

    Attributes
    ----------
    x_mm, y_mm : float
        Its middle, from the lower left corner of the picture.
    radius_mm : float
    rim_mm : float
        Width of the raised rim around it; 0 for none.
    is_loop : bool
        Whether the rim stands free, as a loop above the plate.
    """

    x_mm: float
    y_mm: float
    radius_mm: float
    rim_mm: float
    is_loop: bool = False

    def on(self, board: Board) -> Opening:
        """The same from the lower left corner of a board's grid."""
        x, y = board.left * board.pitch_mm, board.bottom * board.pitch_mm
        return dataclasses.replace(self, x_mm=self.x_mm + x, y_mm=self.y_mm + y)


def openings_of(layout: Layout, outline: Contours, design: PlateDesign) -> tuple[Opening, ...]:
    """The holes of a plate.

    Raises
    ------
    InputError
        If a hole does not lie within the plate, or two overlap.
    """
    found: list[Opening] = []
    left, top = layout.middle_mm + np.array([-layout.width_mm, layout.height_mm]) / 2
    curves = Curves(outline, layout.pitch_mm)
    for hole in design.plate.holes:
        across = layout.sizes.along_mm(hole.across, layout.width_mm)
        down = layout.sizes.along_mm(hole.down, layout.height_mm)
        radius = layout.sizes.mm(hole.diameter) / 2
        x, y = left + across, top - down
        place = np.array([[x, y]])
        distance = float(curves.nearest(place).distance_mm[0])
        if not inside_points(outline, place)[0]:
            distance = -distance
        if distance < radius + _WALL_MM:
            where = f"{distance:.4g} mm from the edge of" if distance > 0 else f"{-distance:.4g} mm outside"
            raise InputError(
                f"`hole={design.plate.hole!r}`: the hole of {2 * radius:.4g} mm has its middle {where} the "
                f"plate of {layout.width_mm:.4g} x {layout.height_mm:.4g} mm; it must lie {radius + _WALL_MM:.4g} mm "
                "inside, so move it inwards or make it smaller"
            )
        for other in found:
            apart = float(np.hypot(other.x_mm - x, other.y_mm - y))
            if apart < radius + other.radius_mm + _WALL_MM:
                raise InputError(
                    f"`hole={design.plate.hole!r}`: two holes are {apart:.4g} mm apart, and need "
                    f"{radius + other.radius_mm + _WALL_MM:.4g} mm; move them apart"
                )
        found.append(Opening(x, y, radius, _rim_mm(layout, design, radius)))
    return tuple(found)


def _rim_mm(layout: Layout, design: PlateDesign, radius_mm: float) -> float:
    """Width of the rim around a hole."""
    rim = design.plate.hole_rim
    return 2 * radius_mm * _RIM if rim is None else layout.sizes.along_mm(rim, 2 * radius_mm)


def _thickness_mm(radius_mm: float) -> float:
    """Thickness of the loop around an eye."""
    return max(2 * radius_mm * _LOOP, _THINNEST_MM)


def rims_mm(layout: Layout, design: PlateDesign) -> list[float]:
    """Widths of the rims around holes and of the loop, without those that are 0."""
    sizes, plate = layout.sizes, design.plate
    found = [_rim_mm(layout, design, sizes.mm(hole.diameter) / 2) for hole in plate.holes]
    if plate.loop is not None:
        found.append(_thickness_mm(sizes.mm(plate.loop) / 2))
    return [each for each in found if each > 0]


def loop_of(layout: Layout, outline: Contours, design: PlateDesign) -> Opening | None:
    """The loop above the highest point of the plate over its middle."""
    if design.plate.loop is None:
        return None
    radius = layout.sizes.mm(design.plate.loop) / 2
    thick = _thickness_mm(radius)
    x = float(layout.middle_mm[0])
    start, end = outline.rings[0], np.roll(outline.rings[0], -1, axis=0)
    over = (np.minimum(start[:, 0], end[:, 0]) <= x) & (np.maximum(start[:, 0], end[:, 0]) > x)
    way = (x - start[over, 0]) / (end[over, 0] - start[over, 0])
    top = float((start[over, 1] + way * (end[over, 1] - start[over, 1])).max())
    return Opening(x, top + radius + _LIFT * thick, radius, thick, is_loop=True)


def with_openings(outline: Contours, openings: tuple[Opening, ...], spacing_mm: float) -> Contours:
    """The outline with a loop joined to it and holes cut out."""
    rings, tolerance_mm = list(outline.rings), outline.tolerance_mm
    for each in sorted(openings, key=lambda opening: not opening.is_loop):  # a loop is joined before holes are cut
        if each.is_loop:
            outer = each.radius_mm + each.rim_mm
            disc = Contours((circle(each.x_mm, each.y_mm, outer, spacing_mm),))
            around = Contours((circle(each.x_mm, each.y_mm, outer + 2 * each.rim_mm, spacing_mm),))
            joined = cross_section(outline.rings) + cross_section(disc.rings)
            # round the two notches beside the loop, there only
            closed = cross_section(offset(offset(contours_of(joined, 0.0), each.rim_mm), -each.rim_mm).rings)
            found = contours_of(joined + (closed ^ cross_section(around.rings)), tolerance_mm)
            rings = [ring for ring in found.rings if len(ring) > 2]
        hole = circle(each.x_mm, each.y_mm, each.radius_mm, spacing_mm)
        tolerance_mm = max(tolerance_mm, circle_tolerance(each.radius_mm, len(hole)))
        rings.append(hole[::-1].copy())
    return Contours(tuple(without_short_edges(ring, _SHORTEST * spacing_mm) for ring in rings), tolerance_mm)


def outer_slope(board: Board, depth_mm: Float64, slope_mm: float) -> Float64:
    """(rows, cols) float64: share of a frame that continues beyond the edge of its plate, into the neck of a loop.

    Parameters
    ----------
    board : Board
    depth_mm : (rows, cols) float64
        Distance from the edge of the plate without the loop, positive inside.
    slope_mm : float
        Width of the slope on which the frame runs out.
    """
    # two pixels beyond the edge, where the outline of the plate itself does not reach
    return slope(depth_mm + 2 * board.pitch_mm + slope_mm / 2, slope_mm, board.pitch_mm)


def rim_heights(board: Board, opening: Opening, height_mm: float) -> Float64:
    """(rows, cols) float64 mm: the half-round rim around a hole, whose middle is given on the grid."""
    x, y = np.meshgrid(board.x_mm - opening.x_mm, board.y_mm - opening.y_mm)
    depth_mm = np.hypot(x, y) - opening.radius_mm

    def rim(depth: Float64) -> Float64:
        return half_round(2 * np.clip(depth / opening.rim_mm, 0, 1) - 1)

    return averaged(rim, depth_mm, opening.rim_mm, board.pitch_mm) * height_mm
