"""Messages about edits of large maps."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from nmaptool.types.shown import counted
from nmaptool_cli.wording.depths import describe_depth_report
from nmaptool_cli.wording.edits import describe_layers_and_curl
from nmaptool_cli.wording.layers import describe_split
from nmaptool_cli.wording.maps import describe_decoding, describe_inspection

if TYPE_CHECKING:
    from nmaptool.types.tiled_edit import TiledEdit
    from nmaptool.types.tiled_inspection import TiledInspection
    from nmaptool_cli.run import Run


def describe_edit(run: Run, made: TiledEdit[Any]) -> None:
    """How inputs were read, how the map was cut, and what was done, with warnings."""
    import nmaptool as nm

    for source in made.inputs:
        run.say(f"{source.name}: {source.cols} x {source.rows}, {describe_decoding(source.decoding)}")
        run.warn(*(f"{source.name}: {warning}" for warning in source.decoding.warnings))
    overlap = f" with an overlap of {made.overlap} px" if made.overlap else ""
    workers = f", {counted(made.workers, 'worker')}" if made.workers else ""
    touched = "" if made.touched is None else f"; layers touch {made.touched} of them, the others are copied"
    run.say(f"  {counted(made.tiles, 'tile')} of {made.tile} px{overlap}{workers}{touched}")
    if made.resumed:
        run.say(f"  went on from an earlier run that had finished {counted(made.resumed, 'step')} of tiles")
    report = made.report
    if isinstance(report, nm.ComposeReport):
        run.say(*describe_layers_and_curl(report, nm.Frame(made.rows, made.cols, made.pitch_mm)))
    elif isinstance(report, nm.LayerReport):
        run.say(*describe_split(report))
    elif isinstance(report, nm.DepthReport):
        run.say(*(f"{made.inputs[0].name if made.inputs else 'the picture'}: {note}" for note in report.notes))
        run.say(*describe_depth_report(report))
    run.warn(*report.warnings)
    run.seconds(report.seconds)


def describe_large_inspection(found: TiledInspection) -> Iterator[str]:
    """An inspection, one line each; the size of the chunks follows that of the map."""
    first, *rest = describe_inspection(found.inspection)
    yield first
    read = counted(found.tiles - found.unreadable, "tile")
    yield f"  chunks       {found.chunk[1]} x {found.chunk[0]} px; {read} of {found.tile} px inspected"
    yield from rest
