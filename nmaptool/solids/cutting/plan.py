"""Where the parts of a relief lie."""

from __future__ import annotations

import math

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.errors import InputError, UsageError
from nmaptool.options.parts import PartOptions
from nmaptool.types.parts import PlannedPart
from nmaptool.types.picture import Frame

MOST_PARTS = 10_000
# a size that is a whole number of pixels but for rounding holds that many
_ROUNDING = 1e-9
# pixels of a plate with an exact outline are divided so finely; its box may be so many of these too large
_FINER, _SLACK = 1024, 3


def plan_parts(
    rows: int, cols: int, pitch_mm: float, options: PartOptions, *, within: tuple[slice, slice] | None = None
) -> list[PlannedPart]:
    """Divide a relief into equal parts, whose sides differ by at most one pixel.

    Parameters
    ----------
    rows, cols : int
        Pixels of the whole.
    pitch_mm : float
        Size of a pixel.
    options : PartOptions
    within : (slice, slice), optional
        The rows and columns to divide. Default: all of them.

    Returns
    -------
    list of PlannedPart
        From the top, and from the left in each row.

    Raises
    ------
    UsageError
        If the options do not say how large the parts are.
    InputError
        If a part would be smaller than a pixel, or there would be more than 10 000.

    Examples
    --------
    >>> [(part.row, part.col, part.shape) for part in nm.plan_parts(50, 90, 1.0, nm.PartOptions(part="60mm"))]
    [(0, 0, (50, 45)), (0, 1, (50, 45))]
    """
    within_rows, within_cols = (slice(0, rows), slice(0, cols)) if within is None else within
    return _divided(within_rows, within_cols, pitch_mm, options)


def _divided(
    within_rows: slice, within_cols: slice, pitch_mm: float, options: PartOptions, slack: int = 0
) -> list[PlannedPart]:
    """Divide some rows and columns, which may be so many pixels longer than a whole number of parts."""
    top, left = within_rows.start, within_cols.start
    rows, cols = within_rows.stop - top, within_cols.stop - left
    across, down = _counts(rows, cols, pitch_mm, options, slack)
    if across * down > MOST_PARTS:
        given = f"`part='{options.part}'`" if options.parts is None else f"`parts='{options.parts}'`"
        raise InputError(
            f"{given}: makes {across} x {down} parts of a relief of {_size(rows, cols, pitch_mm)}; at most "
            f"{MOST_PARTS:,} are written, so use larger parts"
        )
    tops = [top + rows * number // down for number in range(down + 1)]
    lefts = [left + cols * number // across for number in range(across + 1)]
    return [
        PlannedPart(row, col, tops[row], tops[row + 1], lefts[col], lefts[col + 1])
        for row in range(down)
        for col in range(across)
    ]


def _counts(rows: int, cols: int, pitch_mm: float, options: PartOptions, slack: int) -> tuple[int, int]:
    """How many parts there are across and down."""
    if options.counts is not None:
        across, down = options.counts
        if across > cols or down > rows:
            raise InputError(
                f"`parts='{options.parts}'`: the relief has only {cols} x {rows} px; use fewer parts, such as "
                f"`parts='{min(across, cols)}x{min(down, rows)}'`"
            )
        return across, down
    if options.largest_mm is None:
        raise UsageError(
            "no parts are asked for; give `part`, such as `part='400mm'`, or `parts`, such as `parts='3x4'`"
        )
    most = [int(side_mm / pitch_mm * (1 + _ROUNDING)) for side_mm in options.largest_mm]
    if min(most) < 1:
        raise InputError(
            f"`part='{options.part}'`: is smaller than a pixel of the relief, {pitch_mm:.4g} mm; use larger parts"
        )
    return -(-max(1, cols - slack) // most[0]), -(-max(1, rows - slack) // most[1])


def _size(rows: int, cols: int, pitch_mm: float) -> str:
    return f"{cols * pitch_mm:.4g} x {rows * pitch_mm:.4g} mm"


def surface_box(domain: Mask) -> tuple[slice, slice]:
    """The rows and columns of pixels that hold a surface; there is at least one.

    >>> surface_box(np.array([[False, False], [False, True]]))
    (slice(1, 2, None), slice(1, 2, None))
    """
    rows, cols = np.flatnonzero(domain.any(axis=1)), np.flatnonzero(domain.any(axis=0))
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(cols[0]), int(cols[-1]) + 1)


def plan_plate(frame: Frame, bounds_mm: Float64, options: PartOptions) -> tuple[Frame, list[PlannedPart]]:
    """Divide the box around an exact outline, whose parts need not end between pixels.

    Parameters
    ----------
    frame : Frame
        Of the whole; the pitch is known.
    bounds_mm : (2, 2) float64
        Least and greatest x and y.
    options : PartOptions

    Returns
    -------
    frame : Frame
        The same with finer pixels, which the parts consist of.
    plan : list of PlannedPart

    Raises
    ------
    UsageError, InputError
        As `plan_parts`.
    """
    assert frame.pitch_mm is not None
    fine = Frame(frame.rows * _FINER, frame.cols * _FINER, frame.pitch_mm / _FINER)
    (left, lower), (right, upper) = bounds_mm * (_FINER / frame.pitch_mm)
    rows = slice(fine.rows - math.ceil(upper), fine.rows - math.floor(lower))
    cols = slice(math.floor(left), math.ceil(right))
    assert fine.pitch_mm is not None
    # a plate that is a whole number of parts wide is divided into that many, although its box was rounded up
    return fine, _divided(rows, cols, fine.pitch_mm, options, _SLACK)
