"""Messages about the parts of a relief."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from nmaptool.io.output.parts import earlier_parts, file_of_part
from nmaptool.io.solids.sizes import about_bytes
from nmaptool.types.shown import counted

if TYPE_CHECKING:
    from nmaptool.io.output.parts import CutRelief
    from nmaptool.types.parts import Assembly
    from nmaptool_cli.run import Run

# so many parts that are left out are named
_NAMED = 12


def describe_parts(run: Run, cut: CutRelief) -> None:
    """How many parts there are, how large they are, and which are left out."""
    errors = [solid.facts["max_error_mm"] for solid in cut.solids if "max_error_mm" in solid.facts]
    describe_assembly(run, cut.assembly, cut.templates, max(errors, default=None))


def describe_assembly(
    run: Run, assembly: Assembly, templates: Sequence[str], max_error_mm: float | None = None
) -> None:
    """The same of an assembly; the error is that of triangles that were left out."""
    wide, tall, deep = (max(part.size_mm[axis] for part in assembly.parts) for axis in range(3))
    count = counted(len(assembly.parts), "part")
    size = f"{wide:.5g} x {tall:.5g} x {deep:.4g} mm"
    run.say(f"  {count} in {assembly.cols} x {assembly.rows}, at most {size}{_volume(assembly.volume_mm3)}")
    if assembly.left_out:
        run.say(f"  left out, because nothing of the relief lies there: {_listed(assembly.left_out)}")
    pieces = [part for part in assembly.parts if part.bodies > 1]
    if pieces and assembly.volume_mm3 is not None:
        named = _listed([(part.row, part.col) for part in pieces])
        run.warn(f"{counted(len(pieces), 'part')} in several pieces: {named}")
    error = "" if max_error_mm is None else f", at most {max_error_mm:.3g} mm from the full grid"
    faces = sum(part.triangles for part in assembly.parts)
    endings = dict.fromkeys(Path(template).suffix.lower() for template in templates)
    sizes = [f"{ending} about {about_bytes(ending, faces) / 1e6:.1f} MB" for ending in endings]
    run.say(f"  {faces} triangles{error}{': ' if sizes else ''}{', '.join(sizes)}")
    run.warn(*_left_behind(assembly, templates))


def written_names(paths: Sequence[Path], cut: CutRelief | None) -> Iterator[str]:
    """Names for messages: one line for all parts of a name."""
    templates = [] if cut is None else cut.templates
    count = 0 if cut is None else len(cut.solids)
    for template in templates:
        yield f"{template}: {counted(count, 'part')}"
    yield from map(str, paths[count * len(templates) :])


def _volume(volume_mm3: float | None) -> str:
    return ", open surfaces; add `base='2mm'` for solids" if volume_mm3 is None else f", {volume_mm3 / 1000:.4g} cm3"


def _listed(places: Sequence[tuple[int, int]]) -> str:
    """Parts by row and column."""
    named = " ".join(f"{row}_{col}" for row, col in places[:_NAMED])
    return f"{named} and {len(places) - _NAMED} more" if len(places) > _NAMED else named


def _left_behind(assembly: Assembly, templates: Sequence[str]) -> Iterator[str]:
    """Files of an earlier run, with other parts."""
    for template in templates:
        own = {file_of_part(template, part.row, part.col) for part in assembly.parts}
        others = [file for file in earlier_parts(template) if file not in own]
        if others:
            more = f" and {len(others) - 1} more" if len(others) > 1 else ""
            yield f"{others[0]}{more}: left from an earlier run and not among these parts; delete what is not needed"
