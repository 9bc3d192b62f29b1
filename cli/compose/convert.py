"""``nmap compose convert``."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from nmaptool.core.errors import UsageError
from nmaptool.options import ReadOptions, WriteOptions
from nmaptool_cli.compose.outputs import MapOutputs, MapWriter, report_header, say_composition, say_map
from nmaptool_cli.session import OUTPUTS, READING, RUN, RunOptions, Session, display_name, input_files


def convert(
    map: str,
    out: Path | None = None,
    /,
    *,
    outputs: Annotated[MapOutputs, Parameter(name="*", group=OUTPUTS)] = MapOutputs(),
    writing: Annotated[WriteOptions, Parameter(name="*", group=OUTPUTS)] = WriteOptions(),
    reading: Annotated[ReadOptions, Parameter(name="*", group=READING)] = ReadOptions(),
    run: Annotated[RunOptions, Parameter(name="*", group=RUN)] = RunOptions(),
) -> None:
    """Write a normal map as another kind of file: format, bits, green up or down, zero code, all three components.

    Codes that are sound stay as they are; vectors off unit length are normalised; a background that is white, grey,
    black or no normal at all becomes alpha.

    Example: nmap compose convert bricks-dx.png bricks.exr --green down

    Parameters
    ----------
    map:
        Normal map: PNG, EXR, TIFF, JPEG or BMP; FILE.exr:layer names a layer; - reads standard input.
    out:
        What is written, .png, .exr or .tif; the same as -o.
    """
    session = Session(run)
    if out is not None and outputs.output is not None:
        raise UsageError(f"{out}: the output is also named by -o {outputs.output}; name it once")
    outputs = dataclasses.replace(outputs, output=outputs.output if out is None else out)
    writer = MapWriter(session, outputs, writing, run, (map,))
    import nmaptool as nm
    from nmaptool.composition.conversion import convert_image
    from nmaptool.io.output.conversion import converted_map
    from nmaptool.io.output.normal_map import bits_of
    from nmaptool_cli.wording import describe_conversion

    with input_files(map) as (source,):
        assert source is not None
        image = nm.read_raster(source, reading)
        image = dataclasses.replace(image, name=display_name(image.name))
        result, settled = convert_image(image, bits_of(writer.output, writing), reading, writing)
    say_map(session, result.normal_map)
    for line in describe_conversion(result.report):
        session.say(line)
    metadata = report_header((result.normal_map,), files={"map": map}, reading=dataclasses.asdict(reading))
    writer.write(converted_map(image, result, settled), metadata | result.report.to_dict())
    say_composition(session, result)
    writer.finish()
