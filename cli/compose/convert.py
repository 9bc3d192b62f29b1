"""``nmap compose convert``."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from nmaptool.core.errors import UsageError
from nmaptool.options import ReadOptions, WriteOptions
from nmaptool_cli.command import command
from nmaptool_cli.compose.edits import finish_edit
from nmaptool_cli.compose.large_convert import ConvertOutputs, is_large, large_convert
from nmaptool_cli.outputs import as_given
from nmaptool_cli.run import Run
from nmaptool_cli.streams import display_name


@command(ConvertOutputs, WriteOptions, ReadOptions)
def convert(run: Run, map: str, out: Path | None = None, /) -> None:
    """Convert a normal map: file format, bits, green up or down, zero code, all three components.

    Valid codes stay as they are, and vectors off unit length are normalised. A background that is white, grey, black
    or not a normal becomes alpha. Maps larger than memory are converted by windows, and grey pictures copied.

    Example: nmap compose convert bricks-dx.png bricks.exr --green down

    Parameters
    ----------
    map:
        Normal map: {pictures}; FILE.exr:layer reads one layer; - reads standard input. Also a Zarr store or a folder
        of tiles.
    out:
        File to write, .png, .exr, .tif or .zarr, or a folder of tiles; the same as -o.
    """
    flags, writing, reading = run[ConvertOutputs], run[WriteOptions], run[ReadOptions]
    if out is not None and flags.output is not None:
        raise UsageError(f"{out}: -o {flags.output} also names the output; give only one of them")
    written = flags.output or out
    if written is not None and is_large(map, as_given(written), reading):
        large_convert(run, flags, map, as_given(written))
        return
    flags.refuse_for_files()
    outputs = dataclasses.replace(flags, output=written).plan(writing, run.options.json)
    run.begin(outputs, map=map)
    import nmaptool as nm
    from nmaptool.composition.conversion import convert_image
    from nmaptool.io.output.conversion import converted_map
    from nmaptool.io.output.normal_map import bits_of
    from nmaptool_cli.wording.edits import describe_conversion

    with run.work() as (files, _):
        image = nm.read_raster(files["map"], reading)
        image = dataclasses.replace(image, name=display_name(image.name))
        result, settled = convert_image(image, bits_of(outputs.places[0], writing), reading, writing)
    assert isinstance(result.report, nm.ConvertReport)
    more = list(describe_conversion(result.report))
    finish_edit(run, outputs, result, [result.normal_map], written=converted_map(image, result, settled), more=more)
