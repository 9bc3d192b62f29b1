"""Messages about a relief: how it was solved."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from nmaptool.core.units import memory_text
from nmaptool.reliefs.wording import describe_solve
from nmaptool_cli.wording.maps import say_map

if TYPE_CHECKING:
    from nmaptool import NormalMap, Relief
    from nmaptool_cli.run import Run


def describe_relief(run: Run, maps: Sequence[NormalMap], relief: Relief) -> None:
    """What was read and solved, with warnings."""
    for normal_map in maps:
        say_map(run, normal_map, makes_heights=True)
    report = relief.report
    run.say(*(f"  {line}" for line in describe_solve(report)))
    run.warn(*report.warnings)
    run.detail(f"  memory planned for the solver {memory_text(report.planned_bytes)}")
    run.detail(f"  residual of each iteration: {' '.join(f'{r:.1e}' for r in report.history)}")
    run.seconds(report.seconds)
