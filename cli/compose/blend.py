"""``nmap compose blend``."""

from __future__ import annotations

import dataclasses
from typing import Annotated

from cyclopts import Parameter

from nmaptool.options import BlendOptions, ReadOptions, WriteOptions
from nmaptool_cli.compose.outputs import MapOutputs, MapWriter, read_map, report_header, say_composition, say_map
from nmaptool_cli.session import COMPOSING, INPUTS, OUTPUTS, READING, RUN, RunOptions, Session, input_files


def blend(
    base: str,
    detail: str,
    /,
    *,
    mask: Annotated[str | None, Parameter(group=INPUTS)] = None,
    outputs: Annotated[MapOutputs, Parameter(name="*", group=OUTPUTS)] = MapOutputs(),
    writing: Annotated[WriteOptions, Parameter(name="*", group=OUTPUTS)] = WriteOptions(),
    options: Annotated[BlendOptions, Parameter(name="*", group=COMPOSING)] = BlendOptions(),
    reading: Annotated[ReadOptions, Parameter(name="*", group=READING)] = ReadOptions(),
    run: Annotated[RunOptions, Parameter(name="*", group=RUN)] = RunOptions(),
) -> None:
    """Blend a detail map with a base map of the same size.

    Example: nmap compose blend maps/base.exr maps/detail.exr -o crisper.exr --strength 1.5

    Parameters
    ----------
    base:
        Normal map of the forms; the result is covered where it is. - reads standard input.
    detail:
        Normal map that is flat where it changes nothing, such as bake's detail.
    mask:
        Grey picture, white where the detail counts.
    """
    session = Session(run)
    writer = MapWriter(session, outputs, writing, run, (base, detail, mask))
    import nmaptool as nm

    with input_files(base, detail, mask) as (base_file, detail_file, mask_file):
        below = read_map(base_file, reading)
        above = read_map(detail_file, dataclasses.replace(reading, layer=None), like=below)
        chosen = None if mask_file is None else nm.read_grey(mask_file, max_megapixels=reading.max_megapixels)
        result = nm.blend(below, above, options, mask=chosen, mask_name=mask or "")
    for each in (below, above):
        say_map(session, each)
    files = {"base": base, "detail": detail, "mask": mask}
    writer.write_composition(result, report_header((below, above), files=files, reading=dataclasses.asdict(reading)))
    say_composition(session, result)
    writer.finish()
