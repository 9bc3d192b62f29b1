"""``nmap inspect``."""

from __future__ import annotations

import dataclasses
from typing import Annotated

from cyclopts import Parameter

from nmaptool.options import ReadOptions
from nmaptool_cli.session import READING, RUN, RunOptions, Session, display_name, input_files


def inspect(
    map: str,
    /,
    *,
    mask: str | None = None,
    reading: Annotated[ReadOptions, Parameter(name="*", group=READING)] = ReadOptions(),
    run: Annotated[RunOptions, Parameter(name="*", group=RUN)] = RunOptions(),
) -> int:
    """Look a normal map over: convention, background, precision, and what is wrong, each with a remedy.

    Exit code 0: clean; 1: there are findings.

    Example: nmap inspect lion.png

    Parameters
    ----------
    map:
        Normal map: PNG, EXR, TIFF, JPEG or BMP; FILE.exr:layer names a layer; - reads standard input.
    mask:
        Grey picture, white where to look.
    """
    import nmaptool as nm

    session = Session(run)
    with input_files(map, mask) as (source, mask_source):
        assert source is not None
        chosen = nm.read_grey(mask_source, max_megapixels=reading.max_megapixels) if mask_source is not None else None
        seen = nm.inspect_map(nm.read_raster(source, reading), reading, mask=chosen)
    seen = dataclasses.replace(seen, name=display_name(seen.name))
    if run.json:
        session.data(seen.to_dict())
    elif not run.quiet:
        from nmaptool_cli.wording import describe_inspection

        print("\n".join(describe_inspection(seen)))
    return 1 if seen.findings else 0
