"""``nmap compose split``."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

from nmaptool.options import ReadOptions, SplitOptions, TilingOptions
from nmaptool_cli.command import command
from nmaptool_cli.compose.large import edit_large, finish_large, is_large, refuse_for_large, store_name
from nmaptool_cli.inputs import map_header, read_map
from nmaptool_cli.outputs import LayerOutputs, by_folder
from nmaptool_cli.run import Run
from nmaptool_cli.wording.maps import say_map

if TYPE_CHECKING:
    import nmaptool as nm
    from nmaptool.core.progress import Progress
    from nmaptool.types.tiled_edit import TiledEdit


@command(LayerOutputs, SplitOptions, TilingOptions, ReadOptions)
def split(run: Run, map: str, /) -> None:
    """Split a normal map into base and detail, without a mesh.

    Example: nmap compose split lion.png -o layers, then nmap relief lion.png --detail layers/detail.exr -o lion.stl

    Parameters
    ----------
    map:
        Normal map: {pictures}; FILE.exr:layer reads one layer; - reads standard input.
    """
    if is_large(run, run[LayerOutputs].output, map, max_megapixels=run[ReadOptions].max_megapixels):
        _split_large(run, map)
        return
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


def _split_large(run: Run, name: str) -> None:
    """Split a large map; base and detail become the arrays of one store."""
    flags = run[LayerOutputs]
    refuse_for_large({"curl": flags.curl, "plot": flags.plot, "format": run.named(LayerOutputs).get("format")})
    output = store_name(flags.output)
    import nmaptool as nm

    def made(progress: Progress | None) -> TiledEdit[nm.LayerReport]:
        return nm.tiled.split(
            name,
            output,
            run[SplitOptions],
            reading=run[ReadOptions],
            tiling=run[TilingOptions],
            overwrite=flags.overwrite,
            progress=progress,
        )

    finish_large(run, flags, edit_large(run, flags, made, map=name), reading=asdict(run[ReadOptions]))
