"""``nmap compose transform``."""

from __future__ import annotations

from nmaptool.options import ReadOptions, TransformOptions, WriteOptions
from nmaptool_cli.command import command
from nmaptool_cli.compose.edits import finish_edit
from nmaptool_cli.inputs import read_map
from nmaptool_cli.outputs import MapOutputs
from nmaptool_cli.run import Run


@command(MapOutputs, WriteOptions, TransformOptions, ReadOptions)
def transform(run: Run, map: str, /) -> None:
    """Crop, mirror, resize, rotate or pad a map; its vectors turn with the picture.

    Example: nmap compose transform lion.png -o lion-left.png --flip-h --rotate 12 --pad 5%

    Parameters
    ----------
    map:
        Normal map: {pictures}; FILE.exr:layer reads one layer; - reads standard input.
    """
    outputs = run[MapOutputs].plan(run[WriteOptions], run.options.json)
    run.begin(outputs, map=map)
    import nmaptool as nm

    with run.work() as (files, _):
        original = read_map(run, files["map"])
        result = nm.transform(original, run[TransformOptions], max_megapixels=run[ReadOptions].max_megapixels)
    finish_edit(run, outputs, result, [original])
