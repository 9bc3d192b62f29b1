"""A relief on a plate: layout, solve, frame, lettering and openings, as one height field with an exact outline."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from nmaptool.core.arrays import Mask
from nmaptool.core.errors import UsageError
from nmaptool.core.progress import Progress
from nmaptool.core.units import Length
from nmaptool.options import ReliefOptions
from nmaptool.plates.enlarging import enlarged
from nmaptool.plates.layout import Layout, lay_out, outline_of
from nmaptool.plates.letters import Letters, letters_of
from nmaptool.plates.mounting import mounted
from nmaptool.plates.openings import loop_of, openings_of, rims_mm
from nmaptool.plates.resampling import reported, resampled
from nmaptool.reliefs.inputs import pitch_of
from nmaptool.reliefs.relief import relief
from nmaptool.types.height import Height
from nmaptool.types.inputs import FloatsLike, MaskLike, NormalsLike, as_normal_map
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.plain_arrays import as_mask
from nmaptool.types.plate import PlateDesign
from nmaptool.types.relief import Relief

# corners of an outline for each pixel along it
_CORNERS = 1.0
_SAME = 0.02
# pixels across a stroke, a frame with a pattern, a plain frame, and a rim that keep their shape
_STROKE_PX = 5.0
_PATTERN_PX = 30.0
_FRAME_PX = 10.0
_RIM_PX = 8.0
# no finer pixels than this many are chosen unasked
_MOST_UNASKED = 12e6


def plate(
    original: NormalsLike,
    detail: NormalsLike | None = None,
    options: ReliefOptions | None = None,
    *,
    design: PlateDesign,
    mask: MaskLike | None = None,
    surface: NormalsLike | Height | None = None,
    mu_map: FloatsLike | None = None,
    beta_map: FloatsLike | None = None,
    delta_map: FloatsLike | None = None,
    wall_mask: MaskLike | None = None,
    progress: Progress | None = None,
) -> Relief:
    """Solve a relief on a plate with an exact outline, a frame, holes and lettering.

    The motif is placed in the middle of the field inside frame, lettering and margin. The relief is solved at the size
    that it has there, so its height is exact.

    Parameters
    ----------
    original, detail
        As for `nmaptool.relief`.
    options : ReliefOptions, optional
        ``width`` is the width of the plate; without it, the motif keeps its size, and the plate is as large as needed.
        Lengths in % refer to the longer side of the plate.
    design : PlateDesign
        From `nmaptool.read_design`, or from options alone if they name no files.
    mask, surface, mu_map, beta_map, delta_map, wall_mask, progress
        As for `nmaptool.relief`.

    Returns
    -------
    Relief
        Its height field covers the plate and has the exact ``outline``; ``plate`` is the report of the plate.

    Raises
    ------
    InputError
        If something does not fit on the plate, and as for `nmaptool.relief`.
    UsageError
        If there is no shape, or the background is cut.
    LimitError, ConvergenceError
        As for `nmaptool.relief`.

    Examples
    --------
    >>> y, x = np.mgrid[1:-1:64j, -1:1:64j]
    >>> normals = np.dstack([x, y, np.ones_like(x)])
    >>> options = nm.ReliefOptions(height=nm.length("1mm"), width=nm.length("30mm"))
    >>> design = nm.PlateDesign(nm.PlateOptions(shape="round"), nm.FrameOptions(frame=nm.length("2mm")))
    >>> coin = nm.plate(normals, options=options, design=design, mask=np.hypot(x, y) < 0.9)
    >>> f"{coin.height.outline.area_mm2:.1f} mm2, {coin.height.range_mm[1]:.3f} mm high"
    '706.8 mm2, 1.000 mm high'
    """
    options = options or ReliefOptions()
    _check(options, design)
    original = as_normal_map(original, "the original", None if mask is None else as_mask(mask))
    motif = _motif(original, mask)
    width_mm = None if options.width is None else options.width.to_mm(1.0, 1)
    pitch_mm = pitch_of(original)[0] if width_mm is None else None
    layout = lay_out(motif, design, pitch_mm=pitch_mm, width_mm=width_mm)
    options, warnings = _edged(options, layout)
    bare = outline_of(layout, motif, design, layout.pitch_mm)
    letters = letters_of(layout, bare, design)
    larger = layout if width_mm is None else enlarged(layout, motif, design, letters)
    if larger is not layout:
        # the plate and its letters are the same elsewhere
        x_mm, y_mm = (larger.middle_mm - layout.middle_mm).tolist()
        bare, letters = bare.moved(x_mm, y_mm), tuple(each.moved(x_mm, y_mm) for each in letters)
        layout = larger
    loop = loop_of(layout, bare, design)
    openings = (*openings_of(layout, bare, design), *([] if loop is None else [loop]))
    inputs: dict[str, Any] = {
        "original": original, "detail": detail, "mask": mask, "surface": surface, "mu_map": mu_map,
        "beta_map": beta_map, "delta_map": delta_map, "wall_mask": wall_mask,
    }  # fmt: skip
    factor, inputs = _at_pitch(inputs, original, layout, design, letters)
    found = relief(**inputs, options=_in_mm(options, layout, original), progress=progress)
    spacing_mm = found.pitch_mm * _CORNERS
    outline = outline_of(layout, motif, design, spacing_mm)
    made = mounted(found, layout, design, outline, letters, openings, factor)
    assert made.plate is not None  # mounted sets it
    about = dataclasses.replace(made.plate, warnings=(*warnings, *made.plate.warnings))
    return dataclasses.replace(made, report=reported(made.report, original, options), plate=about)


def _check(options: ReliefOptions, design: PlateDesign) -> None:
    """Refuse options that contradict a plate."""
    shape = design.plate.shape
    if shape is None:
        raise UsageError("`shape`: a plate needs a shape, such as `shape='round'`")
    if design.plate.is_drawn and design.outline is None:
        raise UsageError(f"`shape={shape!r}`: the design lacks the outline of the file; read it with read_design")
    if design.frame.is_drawn and design.profile is None:
        name = design.frame.frame_profile
        raise UsageError(
            f"`frame_profile={name!r}`: the design lacks the profile of the file; read it with read_design"
        )
    if options.background == "cut":
        raise UsageError(f"`background='cut'`: leaves no plate; use `background='plane'` with `shape={shape!r}`")


def _edged(options: ReliefOptions, layout: Layout) -> tuple[ReliefOptions, list[str]]:
    """Options for a picture that covers the plate, which has no edge for a wall; and what to say about it."""
    if not layout.is_cover or options.edge == "blend":
        return options, []
    warning = f"`edge='{options.edge}'` has no effect: the picture covers the plate, so the motif has no edge on it"
    return dataclasses.replace(options, edge="blend", edge_height=None), [warning]


def _motif(original: NormalMap, mask: MaskLike | None) -> Mask:
    covered = original.coverage
    if mask is not None:
        given = as_mask(mask)
        covered = covered * given if given.shape == covered.shape else covered
    found: Mask = covered >= 0.5
    return found


def _in_mm(options: ReliefOptions, layout: Layout, original: NormalMap) -> ReliefOptions:
    """Options with the picture's width, and with lengths in % of the plate as mm."""
    changed: dict[str, Any] = {"width": Length(layout.pitch_mm * original.frame.cols, "mm")}
    for name in ("height", "edge_height", "outline_round"):
        length = getattr(options, name)
        if length is not None:
            changed[name] = Length(layout.sizes.mm(length), "mm")
    return dataclasses.replace(options, **changed)


def _at_pitch(
    inputs: dict[str, Any], original: NormalMap, layout: Layout, design: PlateDesign, letters: tuple[Letters, ...]
) -> tuple[float, dict[str, Any]]:
    """The inputs with pixels of the wanted size, and how many of them there are for each pixel of the map."""
    rows, cols = original.frame.shape
    wanted = design.machine.pitch
    if wanted is not None:
        factor = layout.pitch_mm / wanted.to_mm(1.0, 1)
    else:
        finest = _needed_pitch(layout, design, letters)
        most = max(1.0, float(np.sqrt(_MOST_UNASKED / (rows * cols))))
        factor = min(max(1.0, layout.pitch_mm / finest), most)
    if abs(factor - 1) < _SAME or (wanted is None and factor <= 1):
        return 1.0, inputs
    new_cols, new_rows = max(4, round(cols * factor)), max(4, round(rows * factor))
    pitch_mm = layout.pitch_mm * cols / new_cols
    return new_cols / cols, resampled(inputs, new_cols, new_rows, pitch_mm)


def _needed_pitch(layout: Layout, design: PlateDesign, letters: tuple[Letters, ...]) -> float:
    """The largest pixel that keeps the shape of letters, frame and rims, in mm."""
    found = [each.stroke_mm / _STROKE_PX for each in letters]
    found += [rim / _RIM_PX for rim in rims_mm(layout, design)]
    frame_mm = layout.sizes.frame(design)
    if frame_mm:
        found.append(frame_mm / (_PATTERN_PX if design.frame.frame_profile in ("rope", "bead") else _FRAME_PX))
    return min(found, default=np.inf)
