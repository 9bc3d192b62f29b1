"""Parts of a motif that stands on its plate with vertical walls."""

from __future__ import annotations

import dataclasses
from typing import Any

from nmaptool.solids.bodies import closed_solid
from nmaptool.solids.cutting.crop import cropped_sheet, cut_vertices
from nmaptool.solids.cutting.source import Source
from nmaptool.solids.cutting.whole import PartFrame
from nmaptool.solids.fronts import check_raised_back
from nmaptool.solids.outline import outline_edges
from nmaptool.solids.piece import Back, back_of, pocket_mm3
from nmaptool.solids.raised import RaisedFront, RaisedPiece
from nmaptool.solids.thinning import thinned_front
from nmaptool.types.parts import PlannedPart
from nmaptool.types.solid import Body, Solid


def raised_part(source: Source, whole: PartFrame, part: PlannedPart, facts: dict[str, Any]) -> Solid | None:
    """The body or open surface of a part that has both motif and plate; None if it has only one of them."""
    front = _front(source, whole, part)
    if front is None:
        return None
    kept = cut_vertices(whole, part, part.top, part.left, part.shape)
    if not whole.solid.is_closed:
        front = thinned_front(front, source.height, whole.solid, facts, (), kept)
        body = Body("relief", front.parts, front.face_count, front.node_count)
        return Solid((body,), False, front.bounds_mm, facts=facts)
    back = _back(source, front, whole, part)
    check_raised_back(back, whole.solid)
    if whole.solid.hollow is not None:
        facts["hollowed_mm3"] = pocket_mm3(back)
    front = thinned_front(front, source.height, whole.solid, facts, (back,), kept)
    return closed_solid([RaisedPiece.of(front, back)], facts)


def _front(source: Source, whole: PartFrame, part: PlannedPart) -> RaisedFront | None:
    """The front of a part; None if motif or plate has no pixel there."""
    front = source.front
    assert isinstance(front, RaisedFront)
    top, left = part.top - source.top, part.left - source.left
    rows, cols = part.shape
    box = (slice(top, top + rows), slice(left, left + cols))
    motif_mask, plate_mask = front.motif.shape.mask[box], front.plate.shape.mask[box]
    if not (motif_mask.any() and plate_mask.any()):
        return None
    placing, every = whole.placing(part, part.top, part.left, rows), motif_mask | plate_mask
    motif = cropped_sheet(front.motif, motif_mask, top, left, placing, within=every)
    plate = cropped_sheet(front.plate, plate_mask, top, left, placing, motif.node_count, every)
    return RaisedFront(
        motif,
        plate,
        outline_edges(motif_mask, motif.shape.splits),
        outline_edges(plate_mask, plate.shape.splits),
    )


def _back(source: Source, front: RaisedFront, whole: PartFrame, part: PlannedPart) -> Back:
    behind = front.whole
    if source.back is None:
        return back_of(behind, front.border(), source.height, whole.solid, whole.zero_mm)
    top, left = part.top - source.top, part.left - source.left
    placing, mask = behind.placing, behind.shape.mask
    back = cropped_sheet(source.back, mask, top, left, placing, behind.node_count, mask)
    return dataclasses.replace(back, diagonals_of=behind)
