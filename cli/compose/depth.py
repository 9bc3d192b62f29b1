"""``nmap compose depth``."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from nmaptool.core.errors import UsageError
from nmaptool.core.units import Length, length
from nmaptool.options import DepthOptions, ReadOptions, WriteOptions
from nmaptool_cli.compose.outputs import MapOutputs, MapWriter
from nmaptool_cli.session import COMPOSING, INPUTS, OUTPUTS, RUN, RunOptions, Session, display_name, input_files


def _height(name: str, text: str) -> Length | str:
    """A height, or one of the words."""
    if text in ("auto", "none"):
        return text
    try:
        return length(text)
    except UsageError:
        raise UsageError(f"--{name} {text!r}: use auto, none or a height, such as 2px") from None


# the parser alone would take a Length for two words
for _name in ("jump", "smooth"):
    _parse = Parameter(
        n_tokens=1, accepts_keys=False, converter=lambda _, tokens, name=_name: _height(name, tokens[0].value)
    )
    DepthOptions.__annotations__[_name] = Annotated[Length | Literal["auto", "none"], _parse]


def depth(
    image: str,
    /,
    *,
    mask: Annotated[str | None, Parameter(group=INPUTS)] = None,
    outputs: Annotated[MapOutputs, Parameter(name="*", group=OUTPUTS)] = MapOutputs(),
    jumps_out: Annotated[Path | None, Parameter(group=OUTPUTS)] = None,
    writing: Annotated[WriteOptions, Parameter(name="*", group=OUTPUTS)] = WriteOptions(),
    options: Annotated[DepthOptions, Parameter(name="*", group=COMPOSING)] = DepthOptions(),
    layer: Annotated[str | None, Parameter(group=INPUTS)] = None,
    max_megapixels: Annotated[float, Parameter(group=INPUTS)] = ReadOptions.max_megapixels,
    run: Annotated[RunOptions, Parameter(name="*", group=RUN)] = RunOptions(),
) -> None:
    """Turn a depth or height picture into a normal map, without cliffs where one part hides another.

    Example: nmap compose depth rooster.jpg -o rooster.exr --depth-scale 8%, then nmap relief rooster.exr -o rooster.stl

    Parameters
    ----------
    image:
        Grey picture, 8 or 16 bit or float: PNG, EXR, TIFF, JPEG or BMP; FILE.exr:depth names a layer; - reads
        standard input.
    mask:
        Grey picture, white where the surface is.
    jumps_out:
        Picture of the jumps, .png: the brighter, the higher; how high white is stands in its metadata.
    layer:
        Layer of an EXR that holds several. Also written as FILE.exr:depth.
    max_megapixels:
        Refuse larger pictures before any memory is taken.
    """
    session = Session(run)
    writer = MapWriter(session, outputs, writing, run, (image, mask), jumps=jumps_out)
    import nmaptool as nm
    from nmaptool.io.output.maps import jumps_picture
    from nmaptool.options.plain_values import plain_values
    from nmaptool_cli.wording import describe_depth

    with input_files(image, mask) as (source, mask_file), session.progress() as progress:
        assert source is not None
        picture = nm.read_raster(source, ReadOptions(layer=layer, max_megapixels=max_megapixels))
        chosen = None if mask_file is None else nm.read_grey(mask_file, max_megapixels=max_megapixels)
        result = nm.depth_to_normals(picture, options, mask=chosen, progress=progress)
    recipe = json.dumps({"command": "depth", "options": plain_values(options)})
    metadata = {
        "version": nm.__version__,
        "files": {"image": image, "mask": mask},
        **result.report.to_dict(),
        "writing": asdict(writing),
    }
    writer.write(result.normal_map, {"jumps": lambda: jumps_picture(result.jumps)}, metadata, recipe)
    name = display_name(picture.name)
    session.say(f"{name}: {result.normal_map.frame}")
    for warning in result.report.warnings:
        session.warn(f"{name}: {warning}")
    for line in describe_depth(result.report):
        session.say(line)
    session.detail(f"  seconds {', '.join(f'{k} {v:.2f}' for k, v in result.report.seconds.items())}")
    writer.finish()
