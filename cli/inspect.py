"""``nmap inspect``."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from nmaptool.options import ReadOptions
from nmaptool.options.fields import Options, option
from nmaptool_cli.command import command
from nmaptool_cli.inputs import read_grey
from nmaptool_cli.mentions import in_flags
from nmaptool_cli.run import Run
from nmaptool_cli.streams import display_name


@dataclass(frozen=True)
class Mask(Options, group="Inputs"):
    """Where to look.

    Parameters
    ----------
    mask:
        Grey picture, white where to look.
    """

    mask: str | None = option(None)


@command(Mask, ReadOptions)
def inspect(run: Run, map: str, /) -> int:
    """Look a normal map over: convention, background, precision, and what is wrong, each with a remedy.

    Exit code 0: clean; 1: there are findings.

    Example: nmap inspect lion.png

    Parameters
    ----------
    map:
        Normal map: {pictures}; FILE.exr:layer names a layer; - reads standard input.
    """
    reading = run[ReadOptions]
    run.begin(map=map, mask=run[Mask].mask)
    import nmaptool as nm

    with run.work() as (files, _):
        chosen = read_grey(run, files["mask"])
        found = nm.inspect_map(nm.read_raster(files["map"], reading), reading, mask=chosen)
    found = dataclasses.replace(found, name=display_name(found.name))
    if run.options.json:
        run.data(found.to_dict())
    elif not run.options.quiet:
        from nmaptool_cli.wording.maps import describe_inspection

        print(in_flags("\n".join(describe_inspection(found))))
    return 1 if found.findings else 0
