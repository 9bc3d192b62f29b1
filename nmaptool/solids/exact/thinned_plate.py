"""A plate with an exact outline with fewer triangles."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from nmaptool.core.arrays import Mask
from nmaptool.core.errors import UsageError
from nmaptool.core.grid import touching_vertices
from nmaptool.options.solid import SolidOptions
from nmaptool.solids.exact.flat_rim import STRIP_PX, bent_nearby
from nmaptool.solids.exact.plate import CurvedPlateBack, FlatPlateBack, PlateBack, PlateFront
from nmaptool.solids.exact.sampling import heights_inward
from nmaptool.solids.exact.surface import Pixels, front_of
from nmaptool.solids.exact.thinning import InnerThinning, PointThinning
from nmaptool.solids.piece import in_mm
from nmaptool.solids.raised import InsetFront, RaisedFront
from nmaptool.solids.sheet import Sheet
from nmaptool.solids.thinned_sheet import Thinnable, Thinning, thin_pieces
from nmaptool.types.height import Height


def thinned_plate(
    pixels: Pixels, front: PlateFront, back: PlateBack | None, height: Height, options: SolidOptions
) -> tuple[PlateFront, PlateBack | None, float]:
    """Front and back with as many triangles as the options ask for.

    Parameters
    ----------
    pixels : Pixels
        Of the front.
    front : PlateFront
    back : FlatPlateBack or CurvedPlateBack, optional
        Default: none, for an open surface.
    height : Height
        For lengths in px and %.
    options : SolidOptions

    Returns
    -------
    front, back
    max_error_mm : float
        What was reached.

    Raises
    ------
    InputError
        If the outline needs more triangles.
    UsageError
        For a shell or a hollow solid with a raised motif.
    """
    surface = pixels.surface
    curved = back if isinstance(back, CurvedPlateBack) else None
    if curved is not None and isinstance(surface, RaisedFront):
        name = "max_error" if options.max_error is not None else "triangles"
        kind = "shell" if options.shell is not None else "hollow"
        raise UsageError(f"`{name}` and `{kind}` do not go together with a raised motif; leave one of them out")
    heights = [pixels.rim.z_mm] if curved is None else [pixels.rim.z_mm, curved.sheet.z_mm]
    bent = bent_nearby(heights, pixels.over)
    between = pixels.between[bent.ravel()[pixels.between]]
    pixels = dataclasses.replace(pixels, between=between)
    pieces: list[Thinnable] = [_points_thinning(pixels, front, back, height)]
    if isinstance(surface, RaisedFront):
        kept = touching_vertices(surface.motif.shape.mask) & touching_vertices(surface.plate.shape.mask)
        pieces.append(Thinning(surface.motif, surface.motif_edges, kept=kept))
        pieces.append(InnerThinning(surface.plate, surface.plate_edges, None, bent, kept=kept))
    elif surface.shape.mask.any():
        pieces.append(InnerThinning(surface, pixels.edges, None if curved is None else curved.sheet, bent))
    error_mm = None if options.max_error is None else in_mm(options.max_error, height)
    found, reached_mm = thin_pieces(pieces, error_mm, options.triangle_count, options.triangles)
    return (*_rebuilt(pixels, front, back, found), reached_mm)


def _points_thinning(pixels: Pixels, front: PlateFront, back: PlateBack | None, height: Height) -> PointThinning:
    """Fewer points along the outline."""
    strip = front.strip
    layers = [front.z_mm[:, None], heights_inward(strip.points, pixels.rim.z_mm, height.pitch_mm, STRIP_PX)]
    # a point splits a triangle of each strip, and of the walls one for each back that has it, too
    sheets, each, other = 1, 1, 0
    if isinstance(back, CurvedPlateBack):
        layers += [back.z_mm[:, None], heights_inward(strip.points, back.sheet.z_mm, height.pitch_mm, STRIP_PX)]
        sheets, each = 2, 4
    elif back is not None:
        each, other = 2, back.face_count + len(back.z_mm)
    if isinstance(pixels.surface, RaisedFront):
        # two below each edge of the motif, which counts as an edge of the strip, too
        other += len(pixels.surface.walls.start)
    other += sheets * (strip.least_faces + 2 * len(pixels.between))
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
    front = front_of(pixels, front.strip.points.chosen(kept), front.z_mm[kept])
    if isinstance(back, FlatPlateBack):
        return front, dataclasses.replace(back, first_point=front.node_count)
    if back is None:
        return front, None
    sheet = dataclasses.replace(sheet or back.sheet, first_node=front.node_count + len(front.z_mm))
    return front, CurvedPlateBack(sheet, front.strip, back.z_mm[kept])
