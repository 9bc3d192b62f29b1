"""Messages about a plate: its sizes, and what was chosen for it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nmaptool.core.mentions import written_name

if TYPE_CHECKING:
    from nmaptool import MachineOptions, PlateReport, Relief, SolidOptions
    from nmaptool_cli.run import Run


def describe_plate(run: Run, report: PlateReport) -> None:
    """The plate, its frame, texts and openings, with warnings."""
    from nmaptool.plates.wording import describe_plate as lines_of

    run.say(*(f"  {line}" for line in lines_of(report)))
    run.warn(*report.warnings)


def describe_machine(run: Run, machine: MachineOptions, solid: SolidOptions, relief: Relief) -> None:
    """What the machine sets, what was given instead, and what it cannot make on a relief without a plate."""
    if machine.for_ is not None:
        from nmaptool.options.plates import MACHINES

        chosen = MACHINES[machine.for_]
        now = {name: getattr(machine if hasattr(machine, name) else solid, name) for name in chosen.values}
        kept: list[str] = []
        instead: list[str] = []
        for name, value in chosen.values.items():
            said = f"{written_name(name).replace('_', ' ')} {'not set' if now[name] is None else now[name]}"
            (kept if str(now[name]) == value else instead).append(said)
        sets = f"sets {', '.join(kept)}" if kept else "sets nothing"
        given = f"; given: {', '.join(instead)}" if instead else ""
        run.say(f"  {machine.for_} ({chosen.description}) {sets}{given}")
    if relief.plate is None and machine.finest is not None:
        from nmaptool.plates.fineness import finer_share

        run.warn(*finer_share(relief.height, machine, ())[1])
