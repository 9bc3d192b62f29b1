"""A plate with an exact outline to triangles."""

from __future__ import annotations

from typing import Any

import numpy as np

from nmaptool.options.solid import SolidOptions
from nmaptool.solids.curved_back import hollow_back, shell_back
from nmaptool.solids.exact.plate import CurvedPlateBack, FlatPlateBack, PlateBack, PlateFront, PlatePiece
from nmaptool.solids.exact.rings import outline_points
from nmaptool.solids.exact.sampling import heights_along, heights_at
from nmaptool.solids.exact.surface import Pixels, front_of, pixels_of
from nmaptool.solids.exact.thinned_plate import thinned_plate
from nmaptool.solids.exact.triangulate import triangulated
from nmaptool.solids.piece import base_below, in_mm
from nmaptool.solids.sheet import Sheet
from nmaptool.types.height import Height
from nmaptool.types.relief import Relief
from nmaptool.types.solid import Body, Solid


def plate_solid(relief: Height | Relief, height: Height, options: SolidOptions) -> Solid:
    """The solid or open surface of a plate whose outline is exact.

    Raises
    ------
    InputError
        If the outline crosses itself, leaves the picture or comes near to a raised motif; if the base is thinner than
        the relief is deep.
    UsageError
        If fewer triangles are asked for of a shell or a hollow solid with a raised motif.
    """
    assert height.outline is not None
    points = outline_points(height.outline, height)
    pixels = pixels_of(relief, height, points, options)
    z_mm = heights_along(points, pixels.rim.z_mm, height)
    front = front_of(pixels, points, z_mm)
    is_plane = not isinstance(relief, Relief) or relief.report.options.background == "plane"
    back = _back_of(front, pixels, height, options, is_plane) if options.is_closed else None
    facts: dict[str, Any] = {
        "outline": "curve",
        "outline_tolerance_mm": height.outline.tolerance_mm,
        "outline_deviation_mm": pixels.deviation_px * height.pitch_mm,
        "area_mm2": height.outline.area_mm2,
    }
    if options.hollow is not None and back is not None:
        facts["hollowed_mm3"] = back.volume_mm3 - back.lowest_mm * height.outline.area_mm2
    if options.max_error is not None or options.triangles is not None:
        front, back, facts["max_error_mm"] = thinned_plate(pixels, front, back, height, options)
    if back is None:
        body = Body("relief", front.parts, front.face_count, front.node_count)
        return Solid((body,), False, front.bounds_mm, facts=facts)
    piece = PlatePiece(front, back)
    return Solid((piece.body("relief"),), True, piece.bounds_mm, piece.volume_mm3, {**facts, "pieces": 1})


def _back_of(front: PlateFront, pixels: Pixels, height: Height, options: SolidOptions, is_plane: bool) -> PlateBack:
    """The back that the options ask for."""
    whole, points, pitch_mm = pixels.whole, front.strip.points, height.pitch_mm
    first = front.node_count + len(front.z_mm)
    if options.shell is not None:
        thickness_mm = in_mm(options.shell, height)
        z_mm = shell_back(whole.z_mm, pixels.over, thickness_mm, pitch_mm)
        z_along = np.minimum(heights_at(z_mm, points.xy_mm, pitch_mm), front.z_mm - thickness_mm)
        moved = whole.z_of_moved - (whole.z_mm - z_mm).ravel()[whole.shape.vertex_of(whole.shape.moved)]
        sheet = Sheet(z_mm, whole.shape, whole.placing, -1, first, moved, diagonals_of=whole)
        return CurvedPlateBack(sheet, front.strip, z_along)
    lowest_mm = front.bounds_mm[0, 2]
    base_mm = base_below(height, options, 0.0 if is_plane else lowest_mm, lowest_mm)
    if options.hollow is not None:
        wall_mm = in_mm(options.hollow, height)
        z_mm = hollow_back(whole.z_mm, pixels.over, wall_mm, base_mm, pitch_mm, whole.shape.mask)
        moved = z_mm.ravel()[whole.shape.vertex_of(whole.shape.moved)]
        sheet = Sheet(z_mm, whole.shape, whole.placing, -1, first, moved, diagonals_of=whole)
        return CurvedPlateBack(sheet, front.strip, np.full(len(front.z_mm), -base_mm))
    corners = points.chosen(points.is_corner)
    faces = triangulated(corners.rings)
    return FlatPlateBack(np.full(len(corners.xy_mm), -base_mm), corners, faces, front.node_count)
