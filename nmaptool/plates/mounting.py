"""Put a solved relief on its plate, with frame, letters and openings."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.plates.board import Board
from nmaptool.plates.fineness import finer_share
from nmaptool.plates.frame import FrameSize
from nmaptool.plates.ground import board_cut, motif_and_frame
from nmaptool.plates.layout import Layout
from nmaptool.plates.letters import Letters, letter_heights
from nmaptool.plates.openings import Opening, rim_heights, with_openings
from nmaptool.types.contours import Contours
from nmaptool.types.height import Height
from nmaptool.types.picture import Frame
from nmaptool.types.plate import PlateDesign, PlateReport
from nmaptool.types.relief import Relief

# rim of a hole: height by width
_RIM_HEIGHT = 0.5
# share of lettering on the motif that is worth a warning
_OVERLAP = 0.02


def mounted(
    relief: Relief,
    layout: Layout,
    design: PlateDesign,
    outline: Contours,
    letters: Sequence[Letters],
    openings: tuple[Opening, ...],
    resampled: float,
) -> Relief:
    """A relief on its plate.

    Parameters
    ----------
    relief : Relief
    layout : Layout
    design : PlateDesign
    outline : Contours
        Of the plate alone, in mm from the lower left corner of the picture.
    letters : sequence of Letters
    openings : tuple of Opening
    resampled : float
        Pixels for each pixel of the map.

    Returns
    -------
    Relief
    """
    cut = with_openings(outline, openings, relief.pitch_mm)
    board = Board.around(cut, relief.pitch_mm)
    edge, cut = board.placed(outline), board.placed(cut)
    openings = tuple(each.on(board) for each in openings)
    z_mm, size = motif_and_frame(relief, layout, design, board, edge, openings)
    warnings = [*relief.report.warnings]
    motif = board_cut(relief.foreground, board, 0)
    for each in letters:
        depth_mm = each.height_mm(relief.report.relief_range_mm)
        added = letter_heights(board, each, depth_mm, design.plate.draft)
        warnings += _letter_warnings(each, board, added, motif, is_cover=layout.is_cover)
        z_mm += added
    for opening in openings:
        if opening.rim_mm > 0:
            high = max(size.height_mm if size is not None else 0.0, _RIM_HEIGHT * opening.rim_mm)
            rim = rim_heights(board, opening, min(high, opening.rim_mm))
            z_mm = np.where(rim > 0, np.maximum(z_mm, rim), z_mm)  # elsewhere, heights may be below the plate
    raised = None if relief.height.raised is None else board_cut(relief.height.raised, board, 0).astype(bool)
    domain = board.pixels_inside(cut)
    height = Height(z_mm, domain, Frame(board.rows, board.cols, board.pitch_mm), raised, cut)
    coverage = None if relief.coverage is None else board_cut(relief.coverage, board, 0)
    share, more = finer_share(height, design.machine, letters)
    report = _report(layout, design, height, edge, size, letters, openings, resampled, relief)
    report = dataclasses.replace(report, finer_share=share, warnings=(*warnings, *more))
    return dataclasses.replace(relief, height=height, foreground=motif, coverage=coverage, plate=report)


def _letter_warnings(each: Letters, board: Board, added: Float64, motif: Mask, *, is_cover: bool) -> list[str]:
    warnings = []
    inked = np.abs(added) > 0.5 * np.abs(added).max()
    if not is_cover:
        share = float((inked[1:, 1:] & motif).sum() / max(1, inked.sum()))
        if share > _OVERLAP:
            warnings.append(
                f"{share:.0%} of the text {each.name} lies on the motif; move it with `text_at`, or make "
                "`text_size` smaller"
            )
    stroke_px = each.stroke_mm / board.pitch_mm
    if stroke_px < 2.5:
        warnings.append(
            f"strokes of the text {each.name} are {each.stroke_mm:.3g} mm wide, {stroke_px:.1f} px; a finer "
            f"`pitch`, such as `pitch='{each.stroke_mm / 4:.2g}mm'`, keeps their shape"
        )
    return warnings


def _report(
    layout: Layout,
    design: PlateDesign,
    height: Height,
    edge: Contours,
    size: FrameSize | None,
    letters: Sequence[Letters],
    openings: Sequence[Opening],
    resampled: float,
    relief: Relief,
) -> PlateReport:
    assert height.outline is not None
    assert design.plate.shape is not None
    rows, cols = np.nonzero(relief.foreground)
    pitch_mm = height.pitch_mm
    low, high = height.range_mm
    frame = {} if size is None else {"width_mm": size.width_mm, "height_mm": size.height_mm}
    (left, low_edge), (_, top) = edge.bounds_mm
    return PlateReport(
        shape=design.plate.shape,
        width_mm=layout.width_mm,
        height_mm=float(top - low_edge),
        area_mm2=height.outline.area_mm2,
        outline_tolerance_mm=height.outline.tolerance_mm,
        pitch_mm=pitch_mm,
        resampled=resampled,
        picture_width_mm=relief.height.frame.cols * pitch_mm,
        motif_width_mm=float(np.ptp(cols) + 1) * pitch_mm,
        motif_height_mm=float(np.ptp(rows) + 1) * pitch_mm,
        fill="cover" if layout.is_cover else "inside",
        margin_mm=0.0 if layout.is_cover else layout.sizes.margin(design),
        frame={**frame, "profile": design.frame.frame_profile} if frame else {},
        texts=tuple(each.facts(relief.report.relief_range_mm) for each in letters),
        holes=tuple(
            {
                "diameter_mm": 2 * each.radius_mm,
                "across_mm": float(each.x_mm - left),
                "down_mm": float(top - each.y_mm),
                "rim_mm": each.rim_mm,
                "loop": each.is_loop,
            }
            for each in openings
        ),
        top_mm=high,
        lowest_mm=low,
    )
