"""``nmap compose depth``."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from nmaptool.options import DepthOptions, ReadOptions, TilingOptions, WriteOptions
from nmaptool.options.fields import Options, option
from nmaptool.options.plain_values import plain_values
from nmaptool_cli.command import command
from nmaptool_cli.compose.large import edit_large, finish_large, is_large, refuse_for_large, store_name
from nmaptool_cli.outputs import MapOutputs
from nmaptool_cli.run import Run
from nmaptool_cli.streams import display_name

if TYPE_CHECKING:
    import nmaptool as nm
    from nmaptool.core.progress import Progress
    from nmaptool.types.tiled_edit import TiledEdit


@dataclass(frozen=True)
class DepthInputs(Options, group="Inputs"):
    """A mask, and the picture to read.

    Parameters
    ----------
    mask:
        Grey picture, white where the surface is.
    layer:
        Read this layer of an EXR that holds several. FILE.exr:depth does the same.
    max_megapixels:
        Refuse larger pictures before any memory is used.
    """

    mask: str | None = option(None)
    layer: str | None = option(None)
    max_megapixels: float = option(ReadOptions.max_megapixels)


@dataclass(frozen=True)
class DepthOutputs(MapOutputs):
    """A normal map with pictures of its curl and of the jumps.

    Parameters
    ----------
    jumps_out:
        Picture (.png) of the jumps: brighter is higher. Its metadata gives the height of white.
    """

    jumps_out: Path | None = option(None)


@command(DepthInputs, DepthOutputs, WriteOptions, DepthOptions, TilingOptions)
def depth(run: Run, image: str, /) -> None:
    """Turn a depth or height picture into a normal map, without cliffs where one part hides another.

    Example: nmap compose depth rooster.jpg -o rooster.exr --depth-scale 8%, then nmap relief rooster.exr -o rooster.stl

    Parameters
    ----------
    image:
        Grey picture, 8 or 16 bit or float: {pictures}; FILE.exr:depth reads one layer; - reads
        standard input.
    """
    inputs, flags, options = run[DepthInputs], run[DepthOutputs], run[DepthOptions]
    if is_large(run, flags.output, image, inputs.mask, max_megapixels=inputs.max_megapixels):
        _depth_large(run, image)
        return
    outputs = flags.plan(run[WriteOptions], run.options.json, jumps=flags.jumps_out)
    run.begin(outputs, image=image, mask=inputs.mask)
    import nmaptool as nm
    from nmaptool.io.output.map_pictures import jumps_picture
    from nmaptool.io.output.normal_map import WrittenMap
    from nmaptool_cli.wording.depths import describe_depth

    with run.work() as (files, progress):
        reading = ReadOptions(layer=inputs.layer, max_megapixels=inputs.max_megapixels)
        picture = nm.read_raster(files["image"], reading, holds="depth")
        limit = inputs.max_megapixels
        chosen = None if files["mask"] is None else nm.read_grey(files["mask"], max_megapixels=limit, upright=True)
        result = nm.depth_to_normals(picture, options, mask=chosen, progress=progress)
    describe_depth(run, display_name(picture.name), result)
    recipe = json.dumps({"command": "depth", "options": plain_values(options)})
    pictures = {"jumps": partial(jumps_picture, result.jumps)}
    metadata = run.header(
        files={"image": image, "mask": inputs.mask}, **result.report.to_dict(), writing=asdict(run[WriteOptions])
    )
    run.finish(outputs, WrittenMap(result.normal_map, {"recipe": recipe}, pictures=pictures), metadata)


def _depth_large(run: Run, image: str) -> None:
    """Turn a large depth picture into a normal map."""
    inputs, flags = run[DepthInputs], run[DepthOutputs]
    refuse_for_large({"curl": flags.curl, "jumps_out": flags.jumps_out})
    output = store_name(flags.output)
    import nmaptool as nm

    def made(progress: Progress | None) -> TiledEdit[nm.DepthReport]:
        return nm.tiled.depth(
            image,
            output,
            run[DepthOptions],
            mask=inputs.mask,
            layer=inputs.layer,
            writing=run[WriteOptions],
            tiling=run[TilingOptions],
            overwrite=flags.overwrite,
            progress=progress,
        )

    done = edit_large(run, flags, made, image=image, mask=inputs.mask)
    run.say(f"{image}: {done.cols} x {done.rows}")
    finish_large(run, flags, done, writing=asdict(run[WriteOptions]))
