"""Where the parts of a relief lie."""

from __future__ import annotations

from nmaptool.core.errors import InputError, UsageError
from nmaptool.options.parts import PartOptions
from nmaptool.types.parts import PlannedPart

MOST_PARTS = 10_000
# a size that is a whole number of pixels but for rounding holds that many
_ROUNDING = 1e-9


def plan_parts(rows: int, cols: int, pitch_mm: float, options: PartOptions) -> list[PlannedPart]:
    """Divide a relief into equal parts, whose sides differ by at most one pixel.

    Parameters
    ----------
    rows, cols : int
        Pixels of the whole.
    pitch_mm : float
        Size of a pixel.
    options : PartOptions

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
    across, down = _counts(rows, cols, pitch_mm, options)
    if across * down > MOST_PARTS:
        given = f"`part='{options.part}'`" if options.parts is None else f"`parts='{options.parts}'`"
        raise InputError(
            f"{given}: makes {across} x {down} parts of a relief of {_size(rows, cols, pitch_mm)}; at most "
            f"{MOST_PARTS:,} are written, so use larger parts"
        )
    tops = [rows * number // down for number in range(down + 1)]
    lefts = [cols * number // across for number in range(across + 1)]
    return [
        PlannedPart(row, col, tops[row], tops[row + 1], lefts[col], lefts[col + 1])
        for row in range(down)
        for col in range(across)
    ]


def _counts(rows: int, cols: int, pitch_mm: float, options: PartOptions) -> tuple[int, int]:
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
    return -(-cols // most[0]), -(-rows // most[1])


def _size(rows: int, cols: int, pitch_mm: float) -> str:
    return f"{cols * pitch_mm:.4g} x {rows * pitch_mm:.4g} mm"
