"""``nmap compose pack``."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from nmaptool.core.errors import UsageError
from nmaptool.core.units import Offset
from nmaptool.options import LayerOptions, PackOptions, ReadOptions
from nmaptool.options.blend_modes import layer_meanings
from nmaptool.options.fields import Options, option
from nmaptool.options.formats import WORKSPACE_FORMATS
from nmaptool.options.kinds import Kind, Numeric, SignedText, Switch
from nmaptool.types.shown import counted
from nmaptool_cli.command import command
from nmaptool_cli.compose.recipes import errors_of
from nmaptool_cli.inputs import read_grey, read_map
from nmaptool_cli.mentions import flag_of
from nmaptool_cli.outputs import FileOf
from nmaptool_cli.run import Run
from nmaptool_cli.wording.maps import say_map

if TYPE_CHECKING:
    import nmaptool as nm


@dataclass(frozen=True)
class ModeNames(Kind):
    """Layer modes, which the help lists."""

    def meanings(self) -> str:
        """As `Kind.meanings`."""
        return ", ".join(layer_meanings()) + "."


@dataclass(frozen=True)
class WorkspaceOutput(Options, group="Outputs"):
    """The layered file.

    Parameters
    ----------
    output:
        Layered file to write. The ending sets the format:
    overwrite:
        Replace an existing file.
    """

    output: Path | None = option(None, FileOf(formats=lambda: WORKSPACE_FORMATS), short="-o")
    overwrite: bool = option(False, Switch())


@dataclass(frozen=True)
class Layering(Options, group="Layers"):
    """How the maps are placed in the layered file; each flag once for every map, bottom to top.

    Parameters
    ----------
    at:
        Position of the map's top left corner: across,down, such as 40px,-12px or 10%,5mm, rounded to whole pixels.
        Default: 0,0.
    name:
        Name of the layer. Default: the file name.
    mode:
        How the layer is to be composed after unpacking. Default: over. One of
    strength:
        How strongly it is composed then: 0 not at all, 1 fully (default).
    mask:
        Mask of the layer: a grey picture of the map's size, white where the map shows. "none" for a map without a mask.
    """

    at: tuple[str, ...] = option((), SignedText())
    name: tuple[str, ...] = option(())
    mode: tuple[str, ...] = option((), ModeNames())
    strength: tuple[float, ...] = option((), Numeric())
    mask: tuple[str, ...] = option(())

    def of_each(self, count: int, *, recipe: bool) -> list[LayerOptions]:
        """Name, mode, strength and position of each of ``count`` maps.

        Raises
        ------
        UsageError
            If a flag is not given once for each map, or is given with a recipe.
        """
        for field in dataclasses.fields(self):
            given, flag = len(getattr(self, field.name)), flag_of(field.name)
            if given and recipe:
                raise UsageError(f"{flag}: applies to maps only; a recipe sets it for each layer")
            if given not in (0, count):
                remedy = "give it once for each map, or not at all"
                raise UsageError(f"{flag}: given {given} times for {count} maps; {remedy}")
        default = LayerOptions(at="0,0")
        rows = (getattr(self, key) or (getattr(default, key),) * count for key in ("name", "mode", "strength", "at"))
        return [LayerOptions(*row) for row in zip(*rows, strict=True)]


@command(WorkspaceOutput, PackOptions, Layering, ReadOptions)
def pack(run: Run, /, *maps: str) -> None:
    """Pack normal maps as the layers of one file for an image editor.

    A recipe (.toml) is packed with its layers in place and their normals rotated.

    Example: nmap compose pack base.exr detail.exr --mode over --mode rnm -o work.psd, and after editing nmap compose
    unpack work.psd -o maps

    Parameters
    ----------
    maps:
        One or more normal maps, bottom to top; FILE.exr:layer reads one layer. Or one recipe, such as scene.toml.
    """
    from nmaptool.io.output.workspace import check_workspace_target, workspace_outputs

    target, options, layering = run[WorkspaceOutput].output, run[PackOptions], run[Layering]
    if not maps:
        raise UsageError("no maps given: add one or more, or a recipe")
    if target is None:
        raise UsageError("no output given: add one, such as -o work.psd")
    bits = check_workspace_target(target, options.bits, options.half)
    is_recipe = Path(maps[0]).suffix.lower() == ".toml"
    if is_recipe and len(maps) > 1:
        raise UsageError(f"{maps[0]}: a recipe is packed alone; give one recipe, or maps")
    each = layering.of_each(len(maps), recipe=is_recipe)
    outputs = workspace_outputs(target, overwrite=run[WorkspaceOutput].overwrite)
    masks = tuple(name for name in layering.mask if name != "none")
    run.begin(outputs, maps=maps, masks=masks)
    import nmaptool as nm

    read, placed, frame, ground = _recipe(run, maps[0]) if is_recipe else _maps(run, each)
    workspace = nm.pack(placed, dataclasses.replace(options, bits=bits), frame=frame, ground=ground)
    for one in read:
        say_map(run, one)
    run.say(*_describe(workspace))
    outputs.write(workspace)
    run.say(f"  wrote {target}")
    run.speak()
    if run.options.json:
        run.data({"output": str(target), **(workspace.metadata or {})})


_Placed = tuple[list["nm.NormalMap"], tuple["nm.PackedMap", ...], "nm.Frame", str]


def _recipe(run: Run, name: str) -> _Placed:
    """The layers of a recipe, in place."""
    import nmaptool as nm

    recipe = nm.read_recipe(name, max_megapixels=run[ReadOptions].max_megapixels)
    run.refuse_inputs(name, *(str(Path(recipe.folder) / file) for file in recipe.files))
    stack = nm.read_stack(recipe, run[ReadOptions])
    with errors_of(stack):
        placed, frame = nm.place_layers(stack.layers, stack.canvas)
    return list(stack.maps), placed, frame, stack.canvas.ground


def _maps(run: Run, each: list[LayerOptions]) -> _Placed:
    """The maps, their placement and their canvas."""
    import nmaptool as nm
    from nmaptool.workspace.pack import common_frame

    with run.work() as (files, _):
        read = [read_map(run, name) for name in files["maps"]]
        left = iter(files["masks"])
        names = run[Layering].mask or ("none",) * len(read)
        masks = [None if name == "none" else read_grey(run, next(left)) for name in names]
    frame = common_frame(read)
    placed = tuple(
        nm.PackedMap(one, o.name, *_pixels(o.place, frame), o.mode, o.strength, mask)
        for one, o, mask in zip(read, each, masks, strict=True)
    )
    return read, placed, frame, "clear"


def _pixels(place: tuple[Offset, Offset], frame: nm.Frame) -> tuple[int, int]:
    """Left and top of a map on a canvas."""
    across, down = place
    return round(across.to_px(frame.pitch_mm, frame.cols)), round(down.to_px(frame.pitch_mm, frame.rows))


def _describe(workspace: nm.Workspace) -> Iterator[str]:
    kind = "half" if workspace.half else f"{workspace.bits} bit"
    yield f"  {counted(len(workspace.layers), 'layer')} on {workspace.frame}, {kind}, bottom to top:"
    for layer in workspace.layers:
        rows, cols = layer.size
        yield f"    {layer.name}: {cols} x {rows} at {layer.left},{layer.top}{', with a mask' if layer.mask else ''}"
