"""Messages about work on large maps."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nmaptool.reliefs.wording import describe_solve
from nmaptool.types.shown import counted

if TYPE_CHECKING:
    from nmaptool.types.tiled import TiledReport
    from nmaptool_cli.run import Run


def describe_large(run: Run, name: str, made: TiledReport) -> None:
    """How a large map was cut and solved, with warnings."""
    relief = made.relief
    run.say(
        f"{name}: {made.cols} x {made.rows} px, {counted(made.tiles, 'tile')} of {made.tile} px with {made.overlap} px "
        f"overlap, coarse grid of {made.factor} px, {counted(made.workers, 'worker')}"
    )
    if made.resumed:
        run.say(f"  went on from an earlier run that had finished {counted(made.resumed, 'step')} of tiles")
    run.say(*(f"  {line}" for line in describe_solve(relief)))
    run.warn(*made.warnings, *relief.warnings)
    run.detail(f"  residual of each sweep: {' '.join(f'{r:.1e}' for r in relief.history)}")
    run.seconds(relief.seconds)
