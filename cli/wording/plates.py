"""Messages about a plate: its sizes, and what was chosen for it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nmaptool.plates.wording import describe_plate as lines_of

if TYPE_CHECKING:
    from nmaptool import MachineOptions, PlateReport, Relief
    from nmaptool_cli.run import Run


def describe_plate(run: Run, report: PlateReport) -> None:
    """The plate, its frame, texts and openings, with warnings."""
    run.say(*(f"  {line}" for line in lines_of(report)))
    run.warn(*report.warnings)


def describe_machine(run: Run, machine: MachineOptions, relief: Relief) -> None:
    """What the machine sets, and what it cannot make on a relief without a plate."""
    if machine.for_ is not None:
        from nmaptool.options.plates import MACHINES

        chosen = MACHINES[machine.for_]
        run.say(f"  {machine.for_}, {chosen.description}: {chosen.listed}, unless given")
    if relief.plate is None and machine.finest is not None:
        from nmaptool.plates.fineness import finer_share

        run.warn(*finer_share(relief.height, machine, ())[1])
