"""Place shaped lines: straight, along a curve, spread over a closed curve, or repeated around it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError
from nmaptool.lettering.curve import TextCurve, curve_around
from nmaptool.lettering.rings import united
from nmaptool.lettering.shaping import TextLine
from nmaptool.types.contours import Contours

_REMEDY = "use a smaller `text_size`, less `text_spacing` or a shorter text"


def straight(lines: Sequence[TextLine | None], rotate_deg: float = 0.0) -> Contours:
    """Straight lines below each other, centred at (0, 0).

    Each line is centred by its outlines, not by its advance, as the eye sees it. The middle between the top of the
    capitals of the first line and the baseline of the last is at y = 0.

    Parameters
    ----------
    lines : sequence of TextLine or None
        As of `nmaptool.lettering.shaping.lay_out_lines`; None is an empty line.
    rotate_deg : float
        Counter-clockwise.
    """
    found = [line for line in lines if line is not None]
    pitch, size = max(line.line_height_mm for line in found), found[0].size_mm
    top = (size + pitch * (len(lines) - 1)) / 2 - size
    rings: list[Float64] = []
    for number, line in enumerate(lines):
        if line is None:
            continue
        left, right = line.ink_mm
        shift = np.array([-(left + right) / 2, top - number * pitch])
        for start, cluster in zip(line.starts_mm, line.clusters, strict=False):
            rings += [ring + shift + (start, 0.0) for ring in cluster.rings]
    turn = math.radians(rotate_deg)
    rotation = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
    tolerance = max(line.tolerance_mm for line in found)
    return united((ring @ rotation for ring in rings) if rotate_deg else rings, tolerance)


def around(line: TextLine, ring: Float64, path: str = "arc", side: str = "top") -> Contours:
    """A line around a closed curve, such as the legend of a coin.

    The curve is the inner edge of the band of letters: at the top the capitals stand on it, at the bottom their heads
    touch it. Spaces are measured on it, so letters are nowhere closer together than in a straight line.

    Parameters
    ----------
    line : TextLine
    ring : (n, 2) float64
        A closed polygon in mm, of either direction.
    path : str
        "arc": centred at the top or bottom; "circle": spread over the whole curve (`spread`); "ring": repeated around
        it (`repeated`).
    side : str
        "top" or "bottom": where the text, or one of the repeated texts, is centred, and where it can be read.

    Raises
    ------
    InputError
        If the text is longer than the curve.
    """
    curve, middle = curve_around(ring, side)
    place = {"arc": along, "circle": spread, "ring": repeated}[path]
    return place(line, curve, middle, 0.0 if side == "top" else -line.size_mm)


def along(line: TextLine, curve: TextCurve, middle_mm: float | None = None, baseline_mm: float = 0.0) -> Contours:
    """A line along a curve, on its left.

    Each cluster is turned as a whole, so that its middle stands upright on the curve. Scripts that join letters are
    bent with the curve.

    Parameters
    ----------
    line : TextLine
    curve : TextCurve
    middle_mm : float, optional
        Length along the curve up to the middle of the text. Default: half of the curve.
    baseline_mm : float
        Distance of the baseline from the curve, to the left. With ``-line.size_mm`` the heads of the capitals touch
        the curve.

    Raises
    ------
    InputError
        If the text is longer than the curve, or reaches beyond an end of it.
    """
    left, right = line.ink_mm
    length = curve.length_mm
    if right - left > length:
        raise InputError(
            f"the text is {right - left:.1f} mm long at {line.size_mm:g}mm, the edge has {length:.1f} mm; {_REMEDY}"
        )
    start = (length / 2 if middle_mm is None else middle_mm) - (left + right) / 2
    if not curve.is_closed and (start + left < 0 or start + right > length):
        beyond = max(-(start + left), start + right - length)
        raise InputError(f"the text reaches {beyond:.1f} mm beyond the end of its line of {length:.1f} mm; {_REMEDY}")
    return united(_along(line, curve, start, baseline_mm), line.tolerance_mm)


def _along(line: TextLine, curve: TextCurve, start_mm: float, baseline_mm: float) -> list[Float64]:
    """Rings of a line whose left end is at a place of a curve."""
    rings: list[Float64] = []
    for start, cluster in zip(line.starts_mm, line.clusters, strict=False):
        if cluster.is_joined:
            rings += [_bent(ring, line, curve, start_mm + start, baseline_mm) for ring in cluster.rings]
            continue
        middle = start_mm + start + cluster.advance_mm / 2
        x, y = curve.directions(middle, max(cluster.advance_mm, line.size_mm / 4))
        turn = np.array([[x, y], [-y, x]])
        foot = curve.at(np.asarray(middle))
        shift = np.array([-cluster.advance_mm / 2, baseline_mm])
        rings += [(ring + shift) @ turn + foot for ring in cluster.rings]
    return rings


def _bent(ring: Float64, line: TextLine, curve: TextCurve, start_mm: float, baseline_mm: float) -> Float64:
    """A ring whose x follows a curve and whose y is the distance from it."""
    step = line.size_mm / 20
    ends = np.roll(ring, -1, axis=0)
    counts = np.ceil(np.hypot(*(ends - ring).T) / step).astype(int).clip(1)
    part = np.concatenate([np.arange(count) / count for count in counts])[:, None]
    dense = np.repeat(ring, counts, axis=0) * (1 - part) + np.repeat(ends, counts, axis=0) * part
    places = start_mm + dense[:, 0]
    direction = curve.directions(places, line.size_mm / 4)
    normal = np.stack([-direction[:, 1], direction[:, 0]], axis=1)
    return np.asarray(curve.at(places) + normal * (dense[:, 1:] + baseline_mm), np.float64)


def spread(line: TextLine, curve: TextCurve, middle_mm: float, baseline_mm: float = 0.0) -> Contours:
    """A line whose clusters are spread evenly over the whole of a closed curve.

    A text of several words has a space between its last word and its first.

    Parameters
    ----------
    line : TextLine
    curve : TextCurve
        Closed.
    middle_mm : float
        Length along the curve up to the middle of the text.
    baseline_mm : float
        As for `along`.

    Raises
    ------
    InputError
        If the text is longer than the curve.
    """
    has_words = any(cluster.is_space for cluster in line.clusters)
    return _closed(line, curve, 1, has_words, middle_mm, baseline_mm)


def repeated(line: TextLine, curve: TextCurve, middle_mm: float, baseline_mm: float = 0.0) -> Contours:
    """A line repeated around a closed curve as often as it fits, with a space between, and stretched to close exactly.

    Parameters
    ----------
    line : TextLine
    curve : TextCurve
        Closed.
    middle_mm : float
        Length along the curve up to the middle of one of the texts.
    baseline_mm : float
        As for `along`.

    Raises
    ------
    InputError
        If the text is longer than the curve.
    """
    period = line.advance_mm + line.word_space_mm + 2 * line.gap_mm
    return _closed(line, curve, max(int(curve.length_mm / period + 1e-9), 1), True, middle_mm, baseline_mm)


def _closed(
    line: TextLine, curve: TextCurve, times: int, has_space: bool, middle_mm: float, baseline_mm: float
) -> Contours:
    """A line a number of times around a closed curve, with equal spaces put between all clusters."""
    if not curve.is_closed:
        raise InputError("the text goes around a closed curve; the curve is open")
    # the join counts as a space cluster with a gap on each side, or as one gap
    space, joins = (line.word_space_mm, 2) if has_space else (0.0, 1)
    natural = line.stretched(0.0).advance_mm + space
    gaps = sum(line.stretchable) + joins
    share = curve.length_mm / times
    needed = natural + line.gap_mm * gaps
    if needed > share * (1 + 1e-9):
        raise InputError(
            f"the text is {needed:.1f} mm long at {line.size_mm:g}mm, the edge has {curve.length_mm:.1f} mm; {_REMEDY}"
        )
    fitted = line.stretched((share - natural) / gaps)
    left, right = fitted.ink_mm
    rings: list[Float64] = []
    for number in range(times):
        rings += _along(fitted, curve, middle_mm + number * share - (left + right) / 2, baseline_mm)
    return united(rings, line.tolerance_mm)
