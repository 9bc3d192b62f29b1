"""A relief in parts that fit each other: each a closed solid or an open surface."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from nmaptool.core.arrays import Mask
from nmaptool.core.errors import InputError, UsageError
from nmaptool.options.parts import PartOptions
from nmaptool.options.solid import SolidOptions
from nmaptool.solids.bodies import closed_solid
from nmaptool.solids.cutting.clip import SNAP_PX
from nmaptool.solids.cutting.clipped import check_clipped, clipped_parts, several_pieces
from nmaptool.solids.cutting.crop import cropped_sheet, cut_vertices
from nmaptool.solids.cutting.plan import plan_parts, plan_plate, surface_box
from nmaptool.solids.cutting.raised_part import raised_part
from nmaptool.solids.cutting.source import Source, sources_of_relief, sources_of_window
from nmaptool.solids.cutting.whole import PartFrame
from nmaptool.solids.fronts import zero_of
from nmaptool.solids.outline import OutlineEdges, outline_edges
from nmaptool.solids.piece import Back, Piece, back_of, bounds_of, pocket_mm3
from nmaptool.solids.raised import RaisedFront
from nmaptool.solids.sheet import Sheet
from nmaptool.solids.solid import solid as solid_of
from nmaptool.solids.thinning import thinned_surfaces
from nmaptool.types.height import Height
from nmaptool.types.inputs import as_height
from nmaptool.types.parts import PlannedPart
from nmaptool.types.picture import Frame
from nmaptool.types.relief import Relief
from nmaptool.types.solid import Body, Solid


def parts(
    relief: Height | Relief, options: PartOptions, solid: SolidOptions | None = None
) -> Iterator[tuple[int, int, Solid]]:
    """Cut a relief into parts that fit each other without gap or overlap.

    Neighbours have the same vertices along the line between them, and vertical walls there. All parts have the back of
    the whole: their volumes together are that of the whole solid, except that ``hollow`` gives every part its own
    walls. Vertices between parts stay where ``max_error`` or ``triangles`` leaves out others; ``triangles`` is
    the limit for each part, and ``one_piece`` refuses a part that would fall apart. A plate with an exact outline is
    thinned as a whole; where its outline comes nearer to a cut than 1/256 px, it is moved away.

    Parameters
    ----------
    relief : Height or Relief
    options : PartOptions
    solid : SolidOptions, optional
        Default: open surfaces with two triangles for each pixel.

    Returns
    -------
    iterator of (int, int, Solid)
        Row and column, from 0 at the upper left, and the part; parts without any pixel of the relief are left out.

    Raises
    ------
    UsageError
        If the options do not say how large the parts are, or a plate with an exact outline is to be hollowed.
    InputError
        As `nmaptool.solid` and `nmaptool.plan_parts`.

    Examples
    --------
    >>> height = nm.Height(np.zeros((3, 5)), np.ones((2, 4), bool), nm.Frame(2, 4, pitch_mm=0.5))
    >>> for row, col, part in nm.parts(height, nm.PartOptions(parts="2x1"), nm.SolidOptions(base=nm.length("2mm"))):
    ...     print(row, col, part)
    0 0 <Solid 1 x 1 x 2 mm, 1 closed body, 32 faces>
    0 1 <Solid 1 x 1 x 2 mm, 1 closed body, 32 faces>
    """
    for part, found in cut_relief(relief, options, solid or SolidOptions())[1]:
        if found is not None:
            yield part.row, part.col, found


def cut_relief(
    relief: Height | Relief, options: PartOptions, solid: SolidOptions
) -> tuple[Frame, Iterator[tuple[PlannedPart, Solid | None]]]:
    """All planned parts of a relief in memory, as `parts`, in pixels of a frame; None for those that are left out."""
    height = as_height(relief)
    if height.outline is not None:
        return _cut_plate(relief, height, options, solid)
    plan = plan_parts(*height.frame.shape, height.pitch_mm, options, within=surface_box(height.domain))
    whole = PartFrame(height.frame, *height.range_mm, solid, zero_of(relief, height), options.part_origin)
    sources, facts = sources_of_relief(relief, height, whole.solid, plan)
    return height.frame, ((part, solid_of_part(sources, whole, part, facts)) for part in plan)


def _cut_plate(
    relief: Height | Relief, height: Height, options: PartOptions, solid: SolidOptions
) -> tuple[Frame, Iterator[tuple[PlannedPart, Solid | None]]]:
    """The parts of a plate with an exact outline."""
    assert height.outline is not None
    check_clipped(solid)
    rings = np.concatenate(height.outline.rings)
    frame, plan = plan_plate(height.frame, np.stack([rings.min(axis=0), rings.max(axis=0)]), options)
    made = solid_of(relief, dataclasses.replace(solid, one_piece=False))
    snap_mm = SNAP_PX * height.pitch_mm
    return frame, clipped_parts(made, frame, plan, snap_mm, origin=options.part_origin, one_piece=solid.one_piece)


def part_of(window: Height, whole: PartFrame, part: PlannedPart) -> Solid | None:
    """The triangles of one part of a relief that is not in memory as a whole; its outline follows the pixels.

    Parameters
    ----------
    window : Height
        The pixels of ``whole.window_of(part)`` and their vertices.
    whole : PartFrame
    part : PlannedPart

    Returns
    -------
    Solid or None
        None if no pixel of the part belongs to the relief.

    Raises
    ------
    InputError
        If the window has another size or pitch, or the part falls apart and ``one_piece`` is given.
    UsageError
        If a smooth outline is asked for.
    """
    rows, cols = whole.window_of(part)
    wanted = (rows.stop - rows.start, cols.stop - cols.start)
    if window.frame.shape != wanted or window.pitch_mm != whole.pitch_mm:
        raise InputError(
            f"the window of part {part.row}, {part.col} is {window.frame.with_pitch}; expected "
            f"{Frame(*wanted, whole.pitch_mm).with_pitch}"
        )
    check_outline(whole.options)
    down, across = part.top - rows.start, part.left - cols.start
    if not window.domain[down : down + part.shape[0], across : across + part.shape[1]].any():
        return None
    sources = sources_of_window(window, rows.start, cols.start, whole.solid)
    return solid_of_part(sources, whole, part, {"outline": "exact", "outline_deviation_mm": 0.0})


def check_outline(options: SolidOptions) -> None:
    """Refuse a smooth outline of a relief that is not in memory as a whole."""
    if options.outline == "smooth":
        raise UsageError("`outline='smooth'`: the parts of a large map follow its pixels; use `outline='exact'`")


def solid_of_part(
    sources: Sequence[Source], whole: PartFrame, part: PlannedPart, facts: dict[str, Any]
) -> Solid | None:
    """Cut one part out of surfaces that cover it; None if none of them has a pixel there."""
    facts = {key: value for key, value in facts.items() if key != "split_corners"}
    if len(sources) == 1 and isinstance(sources[0].front, RaisedFront):
        raised = raised_part(sources[0], whole, part, facts)
        if raised is not None:
            return raised
        sources = [_one_sided(sources[0], part)]
    cut = [piece for source in sources for piece in _pieces(source, whole, part)]
    if not cut:
        return None
    if whole.solid.one_piece and len(cut) > 1:
        raise several_pieces(part, len(cut))
    facts["split_corners"] = sum(len(front.shape.splits.vertices) for front, *_ in cut)
    if whole.solid.hollow is not None:
        facts["hollowed_mm3"] = sum(pocket_mm3(back) for _, _, back, _ in cut if back is not None)
    height = sources[0].height
    surfaces = [(front, edges, back) for front, edges, back, _ in cut]
    thinned = thinned_surfaces(surfaces, height, whole.solid, facts, [kept for *_, kept in cut])
    if whole.solid.is_closed:
        return closed_solid([Piece(front, edges, back) for front, edges, back in thinned if back is not None], facts)
    bodies = tuple(Body("relief", front.parts, front.face_count, front.shape.node_count) for front, _, _ in thinned)
    bounds = np.array([bounds_of(front, edges) for front, edges, _ in thinned])
    return Solid(bodies, False, np.stack([bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)]), facts=facts)


def _one_sided(source: Source, part: PlannedPart) -> Source:
    """The motif or the plate of a raised front, whichever fills the part."""
    assert isinstance(source.front, RaisedFront)
    front = source.front
    row, col = part.top - source.top, part.left - source.left
    sheet = front.motif if front.motif.shape.mask[row, col] else front.plate
    return dataclasses.replace(source, front=dataclasses.replace(sheet, first_node=0))


def _pieces(
    source: Source, whole: PartFrame, part: PlannedPart
) -> Iterator[tuple[Sheet, OutlineEdges, Back | None, Mask]]:
    """Front, outline, back and vertices between parts of each piece that a part has of a surface."""
    assert isinstance(source.front, Sheet)
    rows, cols = source.front.shape.mask.shape
    top, bottom = max(part.top - source.top, 0), min(part.bottom - source.top, rows)
    left, right = max(part.left - source.left, 0), min(part.right - source.left, cols)
    if top >= bottom or left >= right:
        return
    mask = source.front.shape.mask[top:bottom, left:right]
    for piece, down, across in _connected(mask, whole.solid.is_closed):
        yield _piece(source, whole, part, piece, top + down, left + across)


def _piece(
    source: Source, whole: PartFrame, part: PlannedPart, mask: Mask, top: int, left: int
) -> tuple[Sheet, OutlineEdges, Back | None, Mask]:
    assert isinstance(source.front, Sheet)
    row, col = source.top + top, source.left + left
    placing = whole.placing(part, row, col, len(mask))
    front = cropped_sheet(source.front, mask, top, left, placing)
    edges = outline_edges(mask, front.shape.splits)
    kept = cut_vertices(whole, part, row, col, mask.shape)
    back: Back | None = None
    if source.back is not None:
        back = cropped_sheet(source.back, mask, top, left, placing, front.node_count)
        split_as = source.back
        while split_as.diagonals_of is not None:
            split_as = split_as.diagonals_of
        # behind a raised motif and its plate, pixels are split as those of the motif
        diagonals = front if split_as is source.front else cropped_sheet(split_as, mask, top, left, placing)
        back = dataclasses.replace(back, shape=front.shape, diagonals_of=diagonals)
    elif whole.solid.is_closed:
        back = back_of(front, edges, source.height, whole.solid, whole.zero_mm)
    return front, edges, back, kept


def _connected(mask: Mask, is_closed: bool) -> Iterator[tuple[Mask, int, int]]:
    """The pieces of a mask, each with the row and column of its upper left corner; one piece for an open surface."""
    if not mask.any():
        return
    if mask.all() or not is_closed:
        yield mask, 0, 0
        return
    from scipy import ndimage  # takes long to load

    labels, _ = ndimage.label(mask)
    for number, (rows, cols) in enumerate(ndimage.find_objects(labels), start=1):
        yield labels[rows, cols] == number, rows.start, cols.start
