"""Parts of heights that are larger than memory: each is read with its surroundings, triangulated and written."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from nmaptool.core.progress import Progress
from nmaptool.io.output.parts import ASSEMBLY_ENDINGS, check_templates, file_of_part, new_folders, write_assembly_file
from nmaptool.io.output.targets import Destination, check_folders, place_of
from nmaptool.io.output.transaction import Outputs, Target
from nmaptool.io.output.writing import write_together
from nmaptool.io.solids.writer import write_solid
from nmaptool.io.stores.height_windows import (
    ArrayHeights,
    HeightRange,
    HeightSource,
    blocks,
    frame_of,
    height_window,
    surface_range,
)
from nmaptool.options.parts import PartOptions
from nmaptool.options.solid import SolidOptions
from nmaptool.solids.cutting.cut import check_outline, part_of
from nmaptool.solids.cutting.plan import plan_parts
from nmaptool.solids.cutting.whole import PartFrame
from nmaptool.types.height import Height
from nmaptool.types.parts import Assembly, PlacedPart, PlannedPart, assembly_of, placed_part
from nmaptool.types.picture import Frame

# longer side of the heights below the plan of an assembly
_PICTURE_PX = 1600


def part_frame(
    source: HeightSource,
    options: PartOptions,
    solid: SolidOptions | None = None,
    *,
    found: HeightRange | None = None,
    on_plate: bool = True,
) -> PartFrame:
    """What the parts of a source must know of the whole.

    Parameters
    ----------
    source : HeightSource
    options : PartOptions
    solid : SolidOptions, optional
    found : HeightRange, optional
        Of the surface's corners. Default: all heights are read.
    on_plate : bool
        Whether the base is measured from height 0; otherwise from the lowest point.

    Raises
    ------
    InputError
        As `PartFrame` and `surface_range`.
    """
    found = surface_range(source) if found is None else found
    zero_mm = 0.0 if on_plate else found.low_mm
    return PartFrame(
        frame_of(source), found.low_mm, found.high_mm, solid or SolidOptions(), zero_mm, options.part_origin
    )


def write_part(
    source: HeightSource, whole: PartFrame, part: PlannedPart, templates: Sequence[str], *, overwrite: bool = False
) -> PlacedPart | None:
    """Read one part with its surroundings, triangulate it and write its files: all of them appear, or none.

    Parts can be written in any order, by several processes.

    Parameters
    ----------
    source : HeightSource
    whole : PartFrame
    part : PlannedPart
    templates : sequence of str
        File names with {row} and {col}; their folders exist.
    overwrite : bool

    Returns
    -------
    PlacedPart or None
        None if no pixel of the part is surface; then there are no files.

    Raises
    ------
    InputError
        As `part_of`.
    OutputError
        If a file cannot be written or fails its check, or exists and ``overwrite`` is False.
    """
    window = height_window(source, *whole.window_of(part))
    solid = None if window is None else part_of(window, whole, part)
    if solid is None:
        return None
    files = [file_of_part(template, part.row, part.col) for template in templates]
    title = f"part {part.row}, {part.col}"
    write_together([(file, partial(write_solid, solid, title=title)) for file in files], overwrite)
    return placed_part(part, whole.frame, whole.origin, solid, [file.name for file in files])


def check_parts(
    frame: Frame,
    outputs: Sequence[str | Path],
    options: PartOptions,
    solid: SolidOptions | None = None,
    *,
    assembly: Sequence[Destination] = (),
    overwrite: bool = False,
) -> list[PlannedPart]:
    """Refuse what `export_parts` would refuse, as far as it is known before there are heights.

    Parameters
    ----------
    frame : Frame
        Of the surface; the pitch is known.
    outputs, options, solid, assembly, overwrite
        As for `export_parts`.

    Returns
    -------
    list of PlannedPart

    Raises
    ------
    UsageError, InputError, OutputError
    """
    check_part_files(outputs, solid, assembly=assembly, overwrite=overwrite)
    assert frame.pitch_mm is not None
    return plan_parts(frame.rows, frame.cols, frame.pitch_mm, options)


def check_part_files(
    outputs: Sequence[str | Path],
    solid: SolidOptions | None = None,
    *,
    assembly: Sequence[Destination] = (),
    overwrite: bool = False,
) -> None:
    """As `check_parts`, without what needs the size of the map."""
    templates = [str(output) for output in outputs]
    check_templates(templates, overwrite)
    check_folders(new_folders(templates), "parts are written into it; give another name")
    _assembly_plan(assembly, overwrite, lambda *_: None).check()
    check_outline(solid or SolidOptions())


def _assembly_plan(
    places: Sequence[Destination], overwrite: bool, write: Callable[[Assembly, Path], None]
) -> Outputs[Assembly]:
    targets = [Target(place_of(place), "an assembly", ASSEMBLY_ENDINGS, write) for place in places]
    return Outputs(targets, overwrite=overwrite)


def export_parts(
    source: HeightSource,
    *outputs: str | Path,
    options: PartOptions,
    solid: SolidOptions | None = None,
    found: HeightRange | None = None,
    on_plate: bool = True,
    assembly: Sequence[Destination] = (),
    overwrite: bool = False,
    progress: Progress | None = None,
) -> Assembly:
    """Write the parts of heights one after the other, in the memory that one part needs.

    Parameters
    ----------
    source : HeightSource
    *outputs : str or Path
        Names with {row} and {col}; a folder is created if missing.
    options : PartOptions
    solid : SolidOptions, optional
        Default: open surfaces. The outline follows the pixels.
    found : HeightRange, optional
        Of the surface's corners. Default: all heights are read before.
    on_plate : bool
        Whether the base is measured from height 0; otherwise from the lowest point.
    assembly : sequence of str, Path or OutputStream
        Index (.json) and picture (.png) of the parts.
    overwrite : bool
    progress : callable, optional
        Called with "parts" and the share done.

    Returns
    -------
    Assembly

    Raises
    ------
    UsageError, InputError, OutputError
        As `nmaptool.write_parts`. Parts that are finished stay.
    """
    templates = [str(output) for output in outputs]
    frame = frame_of(source)
    check_parts(frame, outputs, options, solid, assembly=assembly, overwrite=overwrite)
    found = surface_range(source) if found is None else found
    parts = plan_parts(frame.rows, frame.cols, source.pitch_mm, options, within=found.box)
    whole = part_frame(source, options, solid, found=found, on_plate=on_plate)
    for folder in new_folders(templates):
        folder.mkdir(exist_ok=True)
    placed: dict[tuple[int, int], PlacedPart] = {}
    for number, part in enumerate(parts, start=1):
        entry = write_part(source, whole, part, templates, overwrite=overwrite)
        if entry is not None:
            placed[part.row, part.col] = entry
        if progress is not None:
            progress("parts", number / len(parts))
    made = assembly_of(frame, options.part_origin, parts, placed)

    def write(made: Assembly, path: Path) -> None:
        write_assembly_file(made, path, small_height(source) if path.suffix.lower() == ".png" else None)

    _assembly_plan(assembly, overwrite, write).write(made)
    return made


def small_height(source: HeightSource, longer_px: int = _PICTURE_PX) -> Height | None:
    """Every n-th height, for a picture; None if none of them is on the surface."""
    step = max(1, -(-max(source.rows, source.cols) // longer_px))
    side = max(1, 512 // step) * step
    out = np.full((-(-source.rows // step), -(-source.cols // step)), np.nan)
    for rows, cols in blocks(source, side):
        window = source.window(rows, cols)[::step, ::step]
        top, left = rows.start // step, cols.start // step
        out[top : top + window.shape[0], left : left + window.shape[1]] = window
    small = ArrayHeights(out, source.pitch_mm * step)
    return height_window(small, slice(0, small.rows), slice(0, small.cols))
