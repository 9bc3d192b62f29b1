"""Detail that is finer than the machine can make."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nmaptool.core.arrays import Float32, Mask
from nmaptool.options.plates import MACHINES, MachineOptions
from nmaptool.plates.letters import Letters
from nmaptool.types.height import Height

# height that a machine may leave out or fill before it counts as lost: by the width of its finest detail, and by the
# height of the relief
_LOST = 0.05
_LOST_OF_RELIEF = 0.05
_WORTH_SAYING = 0.01
# outlines of level cuts are known to this many pixels
_PIXELS = 1.0
# fewer pixels side by side are corners of the grid, not detail
_FEWEST = 4


def finer_share(height: Height, machine: MachineOptions, letters: Sequence[Letters]) -> tuple[float | None, list[str]]:
    """Share of a surface that has detail finer than the machine can make, and warnings.

    A ball nose leaves material where it does not reach the surface. A nozzle, a spot of light or a pixel cannot make
    parts and gaps of a level cut through the relief that are narrower than itself. The steepness of a surface does not
    matter: the sides of a dome are no fine detail.

    Parameters
    ----------
    height : Height
    machine : MachineOptions
    letters : sequence of Letters

    Returns
    -------
    share : float or None
        None if ``finest`` is not given.
    warnings : list of str
    """
    if machine.finest is None:
        return None, []
    finest_mm = machine.finest.to_mm(1.0, 1)
    name = machine.for_ or "the machine"
    warnings = [
        f"strokes of the text {each.name} are {each.stroke_mm:.3g} mm wide, finer than the {finest_mm:g} mm "
        f"of {name}; use a larger `text_size` or a bolder font"
        for each in letters
        if each.stroke_mm < finest_mm
    ]
    is_ball = machine.for_ is not None and MACHINES[machine.for_].is_ball
    inner = away_from_edge(height.domain, finest_mm / 2 / height.pitch_mm)
    lost = lost_detail(height, finest_mm, is_ball=is_ball) & inner
    share = float(lost.sum() / max(1, inner.sum()))
    if share > _WORTH_SAYING:
        warnings.append(
            f"{share:.0%} of the surface has detail finer than the {finest_mm:g} mm that {name} can make; it will be "
            "rounded off. Make the plate wider, or the detail softer with a smaller `mu`"
        )
    return share, warnings


def away_from_edge(domain: Mask, distance_px: float) -> Mask:
    """(H, W) bool: the pixels of a surface that are farther from its edge than a distance."""
    import cv2

    found = cv2.distanceTransform(np.pad(domain, 1).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return np.asarray(found[1:-1, 1:-1] > distance_px + 1, bool)


def lost_detail(height: Height, finest_mm: float, *, is_ball: bool) -> Mask:
    """(H, W) bool: where a surface has detail that a tool of a diameter cannot make; uncertain along its edge."""
    import cv2
    from scipy import ndimage  # takes long to load

    none: Mask = np.zeros(height.domain.shape, bool)
    radius = round(finest_mm / 2 / height.pitch_mm)
    if radius < 1:
        return none
    domain = height.domain
    centres = height.at_pixels()
    # beyond the edge, the surface continues: the edge itself is cut, whatever its height
    rows, cols = ndimage.distance_transform_edt(~domain, return_distances=False, return_indices=True)
    z: Float32 = np.ascontiguousarray(centres[rows, cols], np.float32)
    if is_ball:
        missing = _closed(z, radius, height.pitch_mm) - z
    else:
        missing = np.maximum(z + _closed(-z, radius), _closed(z, radius) - z)
    # a cut through a slope is known to a pixel, so its height to a pixel times the slope
    down, across = (cv2.GaussianBlur(each, (0, 0), radius) for each in np.gradient(z))
    least_mm = min(_LOST * finest_mm, _LOST_OF_RELIEF * float(np.ptp(z)))
    lost = (missing > least_mm + _PIXELS * np.hypot(down, across)) & domain
    parts, count = ndimage.label(lost, np.ones((3, 3)))
    kept = np.bincount(parts.ravel(), minlength=count + 1) >= _FEWEST
    kept[0] = False
    # detail is lost as a whole, also where the tool touches its crests
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1, 2 * radius + 1))
    found = cv2.morphologyEx(kept[parts].astype(np.uint8), cv2.MORPH_CLOSE, disc)
    return np.asarray((found > 0) & domain, bool)


def _closed(z: Float32, radius: int, pitch_mm: float | None = None) -> Float32:
    """Heights closed with a disc of a radius in px, or with a ball if a size of the pixels is given."""
    raised = _dilated(z, radius, pitch_mm)
    return -_dilated(-raised, radius, pitch_mm)


def _dilated(z: Float32, radius: int, pitch_mm: float | None) -> Float32:
    """The highest of the heights around each pixel, within a disc or as a ball on them reaches."""
    import cv2

    # discs that grow by a pixel: octagons of crosses and squares
    cross, square = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3)), np.ones((3, 3), np.uint8)
    out = grown = z
    for step in range(1, radius + 1):
        grown = cv2.dilate(grown, cross if step % 2 else square)
        if pitch_mm is not None:
            drop_mm = (radius - np.sqrt(radius**2 - step**2)) * pitch_mm
            out = np.maximum(out, grown - np.float32(drop_mm))
    return np.asarray(grown if pitch_mm is None else out, np.float32)
