"""``nmap compose split``."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated, Any

from cyclopts import Parameter

from nmaptool.options import ReadOptions, SplitOptions
from nmaptool_cli.bake import LayerOutputs, destination, say_written
from nmaptool_cli.compose.outputs import say_map
from nmaptool_cli.session import FILTER, OUTPUTS, READING, RUN, RunOptions, Session, input_files


def split(
    map: str,
    /,
    *,
    outputs: Annotated[LayerOutputs, Parameter(name="*", group=OUTPUTS)] = LayerOutputs(),
    options: Annotated[SplitOptions, Parameter(name="*", group=FILTER)] = SplitOptions(),
    reading: Annotated[ReadOptions, Parameter(name="*", group=READING)] = ReadOptions(),
    run: Annotated[RunOptions, Parameter(name="*", group=RUN)] = RunOptions(),
) -> None:
    """Split a normal map that has no mesh into base and detail.

    Example: nmap compose split lion.png -o layers, then nmap relief lion.png --detail layers/detail.exr -o lion.stl

    Parameters
    ----------
    map:
        Normal map: PNG, EXR, TIFF, JPEG or BMP; FILE.exr:layer names a layer; - reads standard input.
    """
    from nmaptool.io.output.layers import layer_outputs

    session = Session(run)
    output, report, to_stdout = destination(outputs)
    files = layer_outputs(
        output, format=outputs.format, plot=outputs.plot, report=report, curl=outputs.curl, overwrite=outputs.overwrite
    )
    files.check()
    import nmaptool as nm
    from nmaptool_cli.wording import describe_split

    with input_files(map) as (source,), session.progress() as progress:
        assert source is not None
        original = nm.read_normal_map(source, reading)
        layers = nm.split(original, options, progress=progress)
    metadata: dict[str, Any] = {
        "version": nm.__version__,
        "files": {"map": map},
        "reading": asdict(reading),
        "outputs": files.names,
        "layers": [layers.report.to_dict()],
    }
    files.write([layers], metadata)
    say_map(session, original)
    for line in describe_split(layers.report):
        session.say(line)
    session.detail(f"  seconds {', '.join(f'{k} {v:.2f}' for k, v in layers.report.seconds.items())}")
    say_written(session, files.paths)
    if run.json or to_stdout:
        session.data(metadata)
