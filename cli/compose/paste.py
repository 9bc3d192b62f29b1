"""``nmap compose paste``."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from nmaptool.core.errors import UsageError
from nmaptool.core.units import Length
from nmaptool.options import LayerOptions, ReadOptions, WriteOptions
from nmaptool.options.plain_values import plain_values
from nmaptool_cli.compose.outputs import MapOutputs, MapWriter, read_map, report_header, say_composition, say_map
from nmaptool_cli.per_input import spread
from nmaptool_cli.session import COMPOSING, OUTPUTS, READING, RUN, RunOptions, Session, input_files

# repeatable flags, whose defaults are those of LayerOptions
_Words = Annotated[tuple[str, ...], Parameter(show_default=False)]
_Numbers = Annotated[tuple[float, ...], Parameter(show_default=False)]


@dataclass(frozen=True)
class Placing:
    """Where layers lie. Every flag holds for all layers; given as often as there are layers, for one each.

    Parameters
    ----------
    at:
        Where the layer's anchor goes: across,down from the top left corner, such as 30%,12mm (% of the canvas's width
        and height). Default: the same anchor of the background.
    anchor:
        Point of the layer that is placed, and turned about: center (default), top-left, top, top-right, left, right,
        bottom-left, bottom, bottom-right.
    scale:
        Factor, or two (across,down), or the width that the layer gets, such as 30mm. Default: 1.
    rotate:
        Degrees counter-clockwise.
    flip_h:
        Mirror left and right.
    flip_v:
        Mirror top and bottom.
    feather:
        Width of the soft edge inside the layer's outline, such as 6px; % are of the longer side of the layer's picture
        as it is placed.
    mode:
        over (default) covers what is below; rnm, pd, whiteout, udn, linear, overlay blend with it, as in blend.
    strength:
        How much of the layer: 0 none, 1 all (default).
    height_factor:
        Factor on the layer's heights. Default: its scale, so that slopes stay; 1 where it is stretched.
    clip:
        yes: only where something lies below; no: everywhere; auto (default): modes other than over are clipped.
    mask:
        Grey picture of the layer's size, white where it shows.
    """

    at: _Words = ()
    anchor: _Words = ()
    scale: _Words = ()
    rotate: _Numbers = ()
    flip_h: bool = False
    flip_v: bool = False
    feather: _Words = ()
    mode: _Words = ()
    strength: _Numbers = ()
    height_factor: _Numbers = ()
    clip: _Words = ()
    mask: _Words = ()

    def of_each(self, count: int) -> list[dict[str, Any]]:
        """The flags of each of ``count`` layers."""
        each: list[dict[str, Any]] = [{} for _ in range(count)]
        for field in dataclasses.fields(self):
            given = getattr(self, field.name)
            flag = field.name.replace("_", "-")
            values = (
                [given] * count if isinstance(given, bool) else spread(flag, given or [None], count, "layer layers")
            )
            for layer, value in zip(each, values, strict=True):
                if value is not None:
                    layer[field.name] = value
        return each


def paste(
    background: str,
    /,
    *layers: str,
    outputs: Annotated[MapOutputs, Parameter(name="*", group=OUTPUTS)] = MapOutputs(),
    placed: Annotated[Path | None, Parameter(group=OUTPUTS)] = None,
    writing: Annotated[WriteOptions, Parameter(name="*", group=OUTPUTS)] = WriteOptions(),
    placing: Annotated[Placing, Parameter(name="*", group=COMPOSING)] = Placing(),
    width: Annotated[Length | None, Parameter(group=COMPOSING)] = None,
    reading: Annotated[ReadOptions, Parameter(name="*", group=READING)] = ReadOptions(),
    run: Annotated[RunOptions, Parameter(name="*", group=RUN)] = RunOptions(),
) -> None:
    """Paste layers on a background; their normals turn with the picture.

    A layer brings its motif along, not its background. More control: nmap compose stack.

    Example: nmap compose paste plate.exr bunny.exr igea.exr -o both.exr --at 30%,50% --at 70%,50% --scale 0.6

    Parameters
    ----------
    background:
        Normal map; the result has its size.
    layers:
        One or more normal maps, from the lowest to the topmost.
    placed:
        Picture of where the layers lie, .png: the --mask of nmap relief for a background that keeps its own height.
    width:
        Width of the whole picture, such as 100mm, so that lengths in mm have a meaning. Default: what the background
        says.
    """
    session = Session(run)
    if not layers:
        raise UsageError("nothing to paste: give one or more layers after the background, such as plate.exr motif.exr")
    each = placing.of_each(len(layers))
    masks = [flags.pop("mask", None) for flags in each]
    options = [LayerOptions(**flags) for flags in each]
    inputs = (background, *layers, *(mask for mask in masks if mask is not None))
    writer = MapWriter(session, outputs, writing, run, inputs, placed=placed)
    import nmaptool as nm

    with input_files(background, *layers, *masks) as sources, session.progress() as progress:
        files, mask_files = sources[: 1 + len(layers)], sources[1 + len(layers) :]
        ground = read_map(files[0], reading)
        others = dataclasses.replace(reading, layer=None)
        maps = [read_map(file, others) for file in files[1:]]
        chosen = [
            None if name is None else nm.read_grey(name, max_megapixels=reading.max_megapixels) for name in mask_files
        ]
        names = ["" if name is None else name for name in masks]
        stack = [nm.Layer(*parts) for parts in zip(maps, options, chosen, names, strict=True)]
        result = nm.paste(ground, stack, width=width, progress=progress)
    for normal_map in (ground, *maps):
        say_map(session, normal_map)
    named = {"background": background, "layers": layers, "masks": [mask for mask in masks if mask is not None]}
    flags = [plain_values(option) for option in options]
    metadata = report_header((ground, *maps), files=named, reading=dataclasses.asdict(reading), placing=flags)
    writer.write_composition(result, metadata)
    say_composition(session, result)
    writer.finish()
