"""Read the cross-section of a frame from an SVG file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from nmaptool.core.arrays import Float64, read_only
from nmaptool.core.errors import InputError
from nmaptool.io.vector.svg import read_stretches

_TOLERANCE = 1e-4  # of the width
_BACKWARDS = 1e-6  # of the width


def read_svg_profile(path: str | Path) -> Float64:
    """Read the profile of a frame from an SVG file: one open path that goes from left to right, or back.

    Its left end is the outer edge of the frame, its right end the inner edge. The lowest point has height 0, the
    highest 1. It may have steps (vertical parts), but must not turn back.

    Parameters
    ----------
    path : str or Path
        A plain SVG file without texts.

    Returns
    -------
    (n, 2) float64
        Places from 0 to 1 that never decrease, and heights from 0 to 1. Straight parts are exact, curves to 1e-4 of
        the width.

    Raises
    ------
    InputError
        If the file is not a readable SVG file, or does not hold one open path that goes from left to right.
    LimitError
        If the file is too large.

    Examples
    --------
    >>> Path("step.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg"><path d="M0,9 H4 V0 H8"/></svg>')
    71
    >>> nm.read_svg_profile("step.svg").tolist()
    [[0.0, 0.0], [0.5, 0.0], [0.5, 1.0], [1.0, 1.0]]
    """
    name = Path(path)
    rough = read_stretches(name, 1.0)
    if len(rough) != 1:
        raise InputError(f"{name}: has {len(rough)} paths; expected one open path from the outer edge to the inner")
    width, height = np.ptp(rough[0].points, axis=0)
    if not rough[0].gap_mm:
        raise InputError(f"{name}: the path is closed; expected an open path from the outer edge to the inner")
    if not width > 0:
        raise InputError(f"{name}: the path has no width; expected a path from left to right")
    points = read_stretches(name, float(width) * _TOLERANCE)[0].points
    height = np.ptp(points[:, 1])
    if not height > 0:
        raise InputError(f"{name}: the path is level, without a height; use `frame_profile='flat'`")
    points = points if points[-1, 0] > points[0, 0] else points[::-1]
    low, width = points[:, 0].min(), np.ptp(points[:, 0])
    x, y = (points[:, 0] - low) / width, (points[:, 1] - points[:, 1].min()) / height
    back = np.maximum.accumulate(x) - x
    if back.max() > _BACKWARDS:
        raise InputError(
            f"{name}: the path turns back by {back.max() * width:.3g} mm of {width:.3g} mm; expected a path from left "
            "to right with one height at each place"
        )
    return read_only(np.stack([np.maximum.accumulate(x), y], axis=1))
