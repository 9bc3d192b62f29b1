"""A plate with an exact outline to triangles."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.errors import UsageError
from nmaptool.core.grid import touching_vertices
from nmaptool.options.solid import SolidOptions
from nmaptool.solids.curved_back import hollow_back, shell_back
from nmaptool.solids.exact.inner import inside_of, pixels_near
from nmaptool.solids.exact.plate import CurvedPlateBack, FlatPlateBack, PlateBack, PlateFront, PlatePiece
from nmaptool.solids.exact.rings import OutlinePoints, outline_points
from nmaptool.solids.exact.sampling import heights_along, heights_at, heights_inward
from nmaptool.solids.exact.strip import strip_between
from nmaptool.solids.exact.surface import Pixels, pixels_of, rings_px
from nmaptool.solids.exact.thinning import STRIP_PX, InnerThinning, PointThinning
from nmaptool.solids.exact.triangulate import triangulated
from nmaptool.solids.piece import base_below, in_mm
from nmaptool.solids.raised import InsetFront, RaisedFront
from nmaptool.solids.sheet import Sheet
from nmaptool.solids.thinned_sheet import Thinnable, Thinning, thin_pieces
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
    z_mm = heights_along(points, _plate_z(pixels), height)
    front = _front_of(pixels, points, z_mm)
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
        front, back, facts["max_error_mm"] = _thinned(pixels, front, back, height, options)
    if back is None:
        body = Body("relief", front.parts, front.face_count, front.node_count)
        return Solid((body,), False, front.bounds_mm, facts=facts)
    piece = PlatePiece(front, back)
    return Solid((piece.body("relief"),), True, piece.bounds_mm, piece.volume_mm3, {**facts, "pieces": 1})


def _plate_z(pixels: Pixels) -> Float64:
    """(H+1, W+1) heights that continue to the outline."""
    surface = pixels.surface
    return surface.plate.z_mm if isinstance(surface, RaisedFront) else surface.z_mm


def _front_of(pixels: Pixels, points: OutlinePoints, z_mm: Float64) -> PlateFront:
    surface = pixels.surface
    rim = surface.plate if isinstance(surface, RaisedFront) else surface
    return PlateFront(surface, strip_between(points, rim, pixels.edges), z_mm)


def _back_of(front: PlateFront, pixels: Pixels, height: Height, options: SolidOptions, is_plane: bool) -> PlateBack:
    """The back that the options ask for."""
    whole, points, pitch_mm = pixels.whole, front.strip.points, height.pitch_mm
    inner, rings = whole.shape.mask, rings_px(front.strip.points, height)
    # pixels that the outline passes through, or that lie inside
    over = inside_of(rings, inner.shape) | pixels_near(rings, inner.shape, 1e-6)
    first = front.node_count + len(front.z_mm)
    if options.shell is not None:
        thickness_mm = in_mm(options.shell, height)
        z_mm = shell_back(whole.z_mm, over, thickness_mm, pitch_mm)
        z_along = np.minimum(heights_at(z_mm, points.xy_mm, pitch_mm), front.z_mm - thickness_mm)
        moved = whole.z_of_moved - (whole.z_mm - z_mm).ravel()[whole.shape.vertex_of(whole.shape.moved)]
        sheet = Sheet(z_mm, whole.shape, whole.placing, -1, first, moved, diagonals_of=whole)
        return CurvedPlateBack(sheet, front.strip, z_along)
    lowest_mm = front.bounds_mm[0, 2]
    base_mm = base_below(height, options, 0.0 if is_plane else lowest_mm, lowest_mm)
    if options.hollow is not None:
        z_mm = hollow_back(whole.z_mm, over, in_mm(options.hollow, height), base_mm, pitch_mm, inner)
        moved = z_mm.ravel()[whole.shape.vertex_of(whole.shape.moved)]
        sheet = Sheet(z_mm, whole.shape, whole.placing, -1, first, moved, diagonals_of=whole)
        return CurvedPlateBack(sheet, front.strip, np.full(len(front.z_mm), -base_mm))
    corners = points.chosen(points.is_corner)
    faces = triangulated(corners.rings, is_even=False)
    return FlatPlateBack(np.full(len(corners.xy_mm), -base_mm), corners, faces, front.node_count)


def _thinned(
    pixels: Pixels, front: PlateFront, back: PlateBack | None, height: Height, options: SolidOptions
) -> tuple[PlateFront, PlateBack | None, float]:
    """Front and back with as many triangles as the options ask for, and the error."""
    surface = pixels.surface
    curved = back if isinstance(back, CurvedPlateBack) else None
    if curved is not None and isinstance(surface, RaisedFront):
        name = "max_error" if options.max_error is not None else "triangles"
        kind = "shell" if options.shell is not None else "hollow"
        raise UsageError(f"`{name}` and `{kind}` do not go together with a raised motif; leave one of them out")
    pieces: list[Thinnable] = [_points_thinning(pixels, front, back, height)]
    if isinstance(surface, RaisedFront):
        kept = touching_vertices(surface.motif.shape.mask) & touching_vertices(surface.plate.shape.mask)
        pieces.append(Thinning(surface.motif, surface.motif_edges, kept=kept))
        pieces.append(InnerThinning(surface.plate, surface.plate_edges, kept=kept))
    elif surface.shape.mask.any():
        pieces.append(InnerThinning(surface, pixels.edges, None if curved is None else curved.sheet))
    error_mm = None if options.max_error is None else in_mm(options.max_error, height)
    limit = wanted = options.triangle_count
    while True:
        found, reached_mm = thin_pieces(pieces, error_mm, limit, options.triangles)
        result = _rebuilt(pixels, front, back, found)
        faces = result[0].face_count if result[1] is None else PlatePiece(result[0], result[1]).face_count
        if limit is None or wanted is None or faces <= wanted:
            return (*result, reached_mm)
        limit -= faces - wanted


def _points_thinning(pixels: Pixels, front: PlateFront, back: PlateBack | None, height: Height) -> PointThinning:
    """Fewer points along the outline."""
    strip = front.strip
    layers = [front.z_mm[:, None], heights_inward(strip.points, _plate_z(pixels), height.pitch_mm, STRIP_PX)]
    # a point splits a triangle of each strip, and of the walls one for each back that has it, too
    sheets, each, other = 1, 1, 0
    if isinstance(back, CurvedPlateBack):
        layers += [back.z_mm[:, None], heights_inward(strip.points, back.sheet.z_mm, height.pitch_mm, STRIP_PX)]
        sheets, each = 2, 4
    elif back is not None:
        each, other = 2, back.face_count + len(back.z_mm)
    other += sheets * (len(strip.faces) - len(front.z_mm) - len(strip.nodes))
    return PointThinning(strip.points, np.concatenate(layers, axis=1), each, other)


def _rebuilt(
    pixels: Pixels, front: PlateFront, back: PlateBack | None, found: list[Any]
) -> tuple[PlateFront, PlateBack | None]:
    """Front and back of thinned parts: which points of the outline stay, and surfaces as `thin_pieces` returns them."""
    kept: Mask = found[0]
    sheet: Sheet | None = None
    if isinstance(pixels.surface, RaisedFront):
        (motif, motif_edges, _), (plate, plate_edges, _) = found[1:]
        surface = InsetFront(motif, plate, motif_edges, plate_edges)
        pixels = dataclasses.replace(pixels, surface=surface, edges=surface.border())
    elif len(found) > 1:
        ((front_sheet, edges, sheet),) = found[1:]
        pixels = dataclasses.replace(pixels, surface=front_sheet, edges=edges)
    front = _front_of(pixels, front.strip.points.chosen(kept), front.z_mm[kept])
    if isinstance(back, FlatPlateBack):
        return front, dataclasses.replace(back, first_point=front.node_count)
    if back is None:
        return front, None
    sheet = dataclasses.replace(sheet or back.sheet, first_node=front.node_count + len(front.z_mm))
    return front, CurvedPlateBack(sheet, front.strip, back.z_mm[kept])
