"""``nmap compose transform``."""

from __future__ import annotations

import dataclasses
from typing import Annotated

from cyclopts import Parameter

from nmaptool.options import ReadOptions, TransformOptions, WriteOptions
from nmaptool_cli.compose.outputs import MapOutputs, MapWriter, read_map, report_header, say_composition, say_map
from nmaptool_cli.session import COMPOSING, OUTPUTS, READING, RUN, RunOptions, Session, input_files


def transform(
    map: str,
    /,
    *,
    outputs: Annotated[MapOutputs, Parameter(name="*", group=OUTPUTS)] = MapOutputs(),
    writing: Annotated[WriteOptions, Parameter(name="*", group=OUTPUTS)] = WriteOptions(),
    options: Annotated[TransformOptions, Parameter(name="*", group=COMPOSING)] = TransformOptions(),
    reading: Annotated[ReadOptions, Parameter(name="*", group=READING)] = ReadOptions(),
    run: Annotated[RunOptions, Parameter(name="*", group=RUN)] = RunOptions(),
) -> None:
    """Crop, mirror, resize, turn or pad a map: its vectors turn with the picture.

    Example: nmap compose transform lion.png -o lion-left.png --flip-h --rotate 12 --pad 5%

    Parameters
    ----------
    map:
        Normal map: PNG, EXR, TIFF, JPEG or BMP; FILE.exr:layer names a layer; - reads standard input.
    """
    session = Session(run)
    writer = MapWriter(session, outputs, writing, run, (map,))
    import nmaptool as nm

    with input_files(map) as (source,):
        original = read_map(source, reading)
        result = nm.transform(original, options, max_megapixels=reading.max_megapixels)
    say_map(session, original)
    writer.write_composition(
        result, report_header((original,), files={"map": map}, reading=dataclasses.asdict(reading))
    )
    say_composition(session, result)
    writer.finish()
