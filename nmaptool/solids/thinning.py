"""Surfaces of a solid with as many triangles as the options ask for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from nmaptool.core.arrays import Mask
from nmaptool.core.grid import touching_vertices
from nmaptool.options.solid import SolidOptions
from nmaptool.solids.flat_back import FlatBack, rectangle_corners
from nmaptool.solids.piece import Back, in_mm
from nmaptool.solids.raised import RaisedFront, RaisedPiece
from nmaptool.solids.thinned_sheet import Surfaces, Thinning, thin_pieces
from nmaptool.types.height import Height


def thinned_surfaces(
    surfaces: Sequence[Surfaces],
    height: Height,
    options: SolidOptions,
    facts: dict[str, Any],
    kept: Sequence[Mask | None] | None = None,
) -> Sequence[Surfaces]:
    """The pieces with as many triangles as the options ask for, and at least the vertices of each that are kept."""
    if options.max_error is None and options.triangles is None:
        return surfaces
    error_mm = None if options.max_error is None else in_mm(options.max_error, height)
    stay = [None] * len(surfaces) if kept is None else kept
    pieces = [Thinning(*each, kept=vertices) for each, vertices in zip(surfaces, stay, strict=True)]
    thinned, facts["max_error_mm"] = thin_pieces(pieces, error_mm, options.triangle_count, options.triangles)
    return thinned


def thinned_front(
    front: RaisedFront,
    height: Height,
    options: SolidOptions,
    facts: dict[str, Any],
    backs: Sequence[Back],
    also_kept: Mask | None = None,
) -> RaisedFront:
    """A raised front with as many triangles as the options ask for, and at least the vertices that are kept."""
    if options.max_error is None and options.triangles is None:
        return front
    error_mm = None if options.max_error is None else in_mm(options.max_error, height)
    # motif and plate share their outline
    kept = touching_vertices(front.motif.shape.mask) & touching_vertices(front.plate.shape.mask)
    if also_kept is not None:
        kept |= also_kept
    for back in backs:
        if isinstance(back, FlatBack):
            kept |= rectangle_corners(back)
    pieces = [Thinning(front.motif, front.motif_edges, kept=kept), Thinning(front.plate, front.plate_edges, kept=kept)]
    limit = wanted = options.triangle_count
    while True:
        thinned, facts["max_error_mm"] = thin_pieces(pieces, error_mm, limit, options.triangles)
        (motif, motif_edges, _), (plate, plate_edges, _) = thinned
        found = RaisedFront(motif, plate, motif_edges, plate_edges)
        faces = RaisedPiece.of(found, backs[0]).face_count if backs else found.face_count
        if limit is None or wanted is None or faces <= wanted:
            return found
        limit -= faces - wanted  # the walls and the back need triangles, too
