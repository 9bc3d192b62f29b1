"""``nmap compose split``."""

from __future__ import annotations

from nmaptool.options import ReadOptions, SplitOptions
from nmaptool_cli.command import command
from nmaptool_cli.inputs import map_header, read_map
from nmaptool_cli.outputs import LayerOutputs, by_folder
from nmaptool_cli.run import Run
from nmaptool_cli.wording.maps import say_map


@command(LayerOutputs, SplitOptions, ReadOptions)
def split(run: Run, map: str, /) -> None:
    """Split a normal map into base and detail, without a mesh.

    Example: nmap compose split lion.png -o layers, then nmap relief lion.png --detail layers/detail.exr -o lion.stl

    Parameters
    ----------
    map:
        Normal map: {pictures}; FILE.exr:layer reads one layer; - reads standard input.
    """
    outputs = run[LayerOutputs].plan()
    run.begin(outputs, map=map)
    import nmaptool as nm
    from nmaptool_cli.wording.layers import describe_split

    with run.work() as (files, progress):
        original = read_map(run, files["map"])
        layers = nm.split(original, run[SplitOptions], progress=progress)
    say_map(run, original)
    run.say(*describe_split(layers.report))
    run.seconds(layers.report.seconds)
    metadata = map_header(run, original, layers=[layers.report.to_dict()])
    run.finish(outputs, [layers], metadata, written=by_folder(outputs.paths))
