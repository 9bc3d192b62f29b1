"""``nmap compose paste``."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

from nmaptool.core.errors import UsageError
from nmaptool.core.units import Length
from nmaptool.options import LayerOptions, ReadOptions, TilingOptions, WriteOptions
from nmaptool.options.fields import Options, option
from nmaptool.options.length_kinds import LengthText
from nmaptool.options.plain_values import plain_values
from nmaptool_cli.command import command
from nmaptool_cli.compose.edits import finish_edit
from nmaptool_cli.compose.large import edit_large, finish_large, is_large, refuse_for_large, store_name
from nmaptool_cli.inputs import read_grey, read_map
from nmaptool_cli.outputs import PlacedOutputs
from nmaptool_cli.per_input import PerInput, spread
from nmaptool_cli.run import Run

if TYPE_CHECKING:
    import nmaptool as nm
    from nmaptool.core.progress import Progress
    from nmaptool.types.tiled_edit import TiledEdit

# a pasted layer has the name of its file
PLACING = PerInput(
    LayerOptions,
    tuple(field.name for field in dataclasses.fields(LayerOptions) if field.name != "name"),
    "layer layers",
    base=LayerOptions(),
)


@dataclass(frozen=True)
class PasteOptions(Options, group="Layers"):
    """Masks of the layers, and the width of the canvas.

    Parameters
    ----------
    mask:
        Grey picture of the layer's size, white where the layer shows.
    width:
        Width of the whole picture, such as 100mm, so that lengths can be given in mm. Default: the width stored in the
        background.
    """

    mask: tuple[str, ...] = option(())
    width: Length | None = option(None, LengthText("100mm"))


@command(PlacedOutputs, WriteOptions, PasteOptions, TilingOptions, ReadOptions, per_input=PLACING)
def paste(run: Run, background: str, /, *layers: str) -> None:
    """Paste layers onto a background; their normals turn with the picture.

    Only the motif of a layer is pasted, not its background. Give placement flags once for all layers, or once for each.
    For more control, use nmap compose stack.

    Example: nmap compose paste plate.exr bunny.exr igea.exr -o both.exr --at 30%,50% --at 70%,50% --scale 0.6

    Parameters
    ----------
    background:
        Normal map of the background; the result has the same size.
    layers:
        One or more normal maps, bottom to top.
    """
    if not layers:
        raise UsageError("no layers given: add one or more after the background, such as plate.exr motif.exr")
    flags, more = run[PlacedOutputs], run[PasteOptions]
    options = run.per_input(len(layers))
    given = more.mask or (None,)
    masks = spread("mask", given, len(layers), "layer layers")
    names = (background, *layers, *masks)
    if is_large(run, flags.output, *names, max_megapixels=run[ReadOptions].max_megapixels):
        _paste_large(run, background, layers, options, masks)
        return
    outputs = flags.plan(run[WriteOptions], run.options.json, placed=flags.placed, walls=flags.walls)
    run.begin(outputs, background=background, layers=layers, masks=tuple(mask for mask in masks if mask is not None))
    import nmaptool as nm

    with run.work() as (files, progress):
        ground = read_map(run, files["background"])
        maps = [read_map(run, file, own_layer=False) for file in files["layers"]]
        read = iter(files["masks"])
        chosen = [None if mask is None else read_grey(run, next(read)) for mask in masks]
        called = [mask or "" for mask in masks]
        stack = [nm.Layer(*parts) for parts in zip(maps, options, chosen, called, strict=True)]
        result = nm.paste(ground, stack, width=more.width, progress=progress)
    flags.check_walls(result)
    placing = [plain_values(option) for option in options]
    finish_edit(run, outputs, result, [ground, *maps], placing=placing)


def _paste_large(
    run: Run, background: str, layers: Sequence[str], options: Sequence[LayerOptions], masks: Sequence[str | None]
) -> None:
    """Paste layers on a large background."""
    flags = run[PlacedOutputs]
    refuse_for_large({"curl": flags.curl})
    output = store_name(flags.output)
    placed, walls = (None if path is None else store_name(path) for path in (flags.placed, flags.walls))
    import nmaptool as nm

    files = [nm.LayerFile(*parts) for parts in zip(layers, options, masks, strict=True)]

    def pasted(progress: Progress | None) -> TiledEdit[nm.ComposeReport]:
        return nm.tiled.paste(
            background,
            files,
            output,
            width=run[PasteOptions].width,
            placed=placed,
            walls=walls,
            reading=run[ReadOptions],
            writing=run[WriteOptions],
            tiling=run[TilingOptions],
            overwrite=flags.overwrite,
            progress=progress,
        )

    named = tuple(mask for mask in masks if mask is not None)
    made = edit_large(run, flags, pasted, background=background, layers=tuple(layers), masks=named)
    placing = [plain_values(option) for option in options]
    finish_large(run, flags, made, reading=asdict(run[ReadOptions]), placing=placing)
