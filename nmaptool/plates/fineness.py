"""Detail that is finer than the machine can make."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nmaptool.options.plates import MachineOptions
from nmaptool.plates.letters import Letters
from nmaptool.types.height import Height

# what a machine may leave out or fill, by the width of its finest detail, before it is counted as lost
_LOST = 0.05
_WORTH_SAYING = 0.01


def finer_share(height: Height, machine: MachineOptions, letters: Sequence[Letters]) -> tuple[float | None, list[str]]:
    """Share of a surface that a round tool or spot cannot make, and warnings.

    A detail is lost where opening or closing of the heights with a disc of the finest detail's diameter changes them
    by more than a twentieth of that diameter.

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
    import cv2

    if machine.finest is None:
        return None, []
    finest_mm = machine.finest.to_mm(1.0, 1)
    name = machine.for_ or "the machine"
    warnings = [
        f"strokes of the text {each.options.text!r} are {each.stroke_mm:.3g} mm wide, finer than the {finest_mm:g} mm "
        f"of {name}; use a larger `text_size` or a bolder font"
        for each in letters
        if each.stroke_mm < finest_mm
    ]
    radius = round(finest_mm / 2 / height.pitch_mm)
    if radius < 1:
        return 0.0, warnings
    z = height.at_pixels()
    domain = height.domain
    z = np.where(domain, z, np.nanmin(z)).astype(np.float32)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1, 2 * radius + 1))
    opened, closed = (cv2.morphologyEx(z, kind, disc) for kind in (cv2.MORPH_OPEN, cv2.MORPH_CLOSE))
    # slopes across the disc are no lost detail: what both operations change evenly
    lost = np.maximum(z - opened, closed - z) > _LOST * finest_mm
    share = float((lost & domain).sum() / domain.sum())
    if share > _WORTH_SAYING:
        warnings.append(
            f"{share:.0%} of the surface has detail finer than the {finest_mm:g} mm that {name} can make; it will be "
            "rounded off. Make the plate wider, or the detail softer with a smaller `mu`"
        )
    return share, warnings
