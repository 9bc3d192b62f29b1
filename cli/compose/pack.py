"""``nmap compose pack``."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from nmaptool.core.errors import UsageError
from nmaptool.core.units import Offset
from nmaptool.options import LayerOptions, PackOptions, ReadOptions
from nmaptool_cli.compose.outputs import read_map, say_map
from nmaptool_cli.session import COMPOSING, OUTPUTS, READING, RUN, RunOptions, Session, input_files, refuse_inputs

if TYPE_CHECKING:
    import nmaptool as nm

_Words = Annotated[tuple[str, ...], Parameter(show_default=False)]
_Numbers = Annotated[tuple[float, ...], Parameter(show_default=False)]


@dataclass(frozen=True)
class WorkspaceOutput:
    """What is written.

    Parameters
    ----------
    output:
        Workspace: .psd (.psb where it is very large), .ora, .tif or .exr.
    overwrite:
        Replace a file that exists.
    """

    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None
    overwrite: bool = False


@dataclass(frozen=True)
class Layering:
    """How the maps lie in the workspace; each flag once for every map, bottom to top.

    Parameters
    ----------
    at:
        Place of the map's top left corner, across,down, such as 40px,-12px or 10%,5mm, to the nearest pixel. Default:
        0,0.
    name:
        What the layer is called. Default: the file's name.
    mode:
        How it is to be composed again after unpacking: over (default), rnm, pd, whiteout, udn, linear, overlay.
    strength:
        How much of it is composed then: 0 none, 1 all (default).
    mask:
        Grey picture of the map's size, white where it shows: the layer's mask. "none" for a map without.
    """

    at: _Words = ()
    name: _Words = ()
    mode: _Words = ()
    strength: _Numbers = ()
    mask: _Words = ()

    def check(self, count: int, *, recipe: bool) -> None:
        """Refuse flags that are not given once for every map, and those that a recipe already says."""
        for field in dataclasses.fields(self):
            given = len(getattr(self, field.name))
            if given and recipe:
                raise UsageError(f"--{field.name}: is for maps; a recipe says it of each layer")
            if given not in (0, count):
                raise UsageError(
                    f"--{field.name}: is given {given} times for {count} maps; give it once for each map, or never"
                )
        modes, strengths = self.mode or ("over",) * count, self.strength or (1.0,) * count
        for mode, strength in zip(modes, strengths, strict=True):
            LayerOptions(mode=mode, strength=strength)  # type: ignore[arg-type]

    def places(self, frame: nm.Frame, count: int) -> list[tuple[int, int]]:
        """(left, top) of each map on a canvas, in px."""
        corners = [LayerOptions(at=text).place for text in self.at] or [(Offset(0, "px"),) * 2] * count
        return [
            (round(across.to_px(frame.pitch_mm, frame.cols)), round(down.to_px(frame.pitch_mm, frame.rows)))
            for across, down in corners
        ]


def pack(
    maps: Annotated[tuple[str, ...], Parameter(negative="")],
    /,
    *,
    output: Annotated[WorkspaceOutput, Parameter(name="*", group=OUTPUTS)] = WorkspaceOutput(),
    options: Annotated[PackOptions, Parameter(name="*", group=OUTPUTS)] = PackOptions(),
    layering: Annotated[Layering, Parameter(name="*", group=COMPOSING)] = Layering(),
    reading: Annotated[ReadOptions, Parameter(name="*", group=READING)] = ReadOptions(),
    run: Annotated[RunOptions, Parameter(name="*", group=RUN)] = RunOptions(),
) -> None:
    """Lay normal maps over each other as the layers of one file for an image editor.

    A recipe (.toml) is packed with its layers on their places, vectors turned.

    Example: nmap compose pack base.exr detail.exr --mode over --mode rnm -o work.psd, and after the editor nmap compose
    unpack work.psd -o maps

    Parameters
    ----------
    maps:
        Normal maps, bottom to top; FILE.exr:layer names a layer. Or one recipe, such as scene.toml.
    """
    from nmaptool.io.replace import check_target
    from nmaptool.io.workspaces.files import check_workspace_target

    session = Session(run)
    target = output.output
    if target is None:
        raise UsageError("nothing to write: say where, such as -o work.psd")
    bits = check_workspace_target(target, options.bits, options.half)
    is_recipe = Path(maps[0]).suffix.lower() == ".toml"
    if is_recipe and len(maps) > 1:
        raise UsageError(f"{maps[0]}: a recipe is packed alone; give it, or maps")
    layering.check(len(maps), recipe=is_recipe)
    check_target(target, output.overwrite)
    import nmaptool as nm

    if is_recipe:
        recipe = nm.read_recipe(maps[0], max_megapixels=reading.max_megapixels)
        refuse_inputs([target], (maps[0], *(str(Path(recipe.folder) / name) for name in recipe.files)))
        stack = nm.read_stack(recipe, reading)
        read = list(stack.maps)
        placed, frame = nm.place_layers(stack.layers, stack.canvas)
        ground: str = stack.canvas.ground
    else:
        refuse_inputs([target], (*maps, *layering.mask))
        read, placed, frame = _read(maps, layering, reading)
        ground = "clear"
    workspace = nm.pack(placed, dataclasses.replace(options, bits=bits), frame=frame, ground=ground)
    nm.write_workspace(target, workspace, overwrite=output.overwrite)
    _say(session, read, target, workspace)
    if run.json:
        session.data({"output": str(target), **(workspace.metadata or {})})


def _read(
    maps: tuple[str, ...], layering: Layering, reading: ReadOptions
) -> tuple[list[nm.NormalMap], tuple[nm.PackedMap, ...], nm.Frame]:
    """The maps, how they lie, and their canvas."""
    import nmaptool as nm
    from nmaptool.workspace.pack import common_frame

    masks = [None if name == "none" else name for name in layering.mask] or [None] * len(maps)
    with input_files(*maps, *masks) as sources:
        read = [read_map(name, reading) for name in sources[: len(maps)]]
        grey = [
            None if m is None else nm.read_grey(m, max_megapixels=reading.max_megapixels) for m in sources[len(maps) :]
        ]
    frame = common_frame(read)
    modes, strengths = layering.mode or ("over",) * len(maps), layering.strength or (1.0,) * len(maps)
    rows = zip(
        read, layering.name or ("",) * len(maps), layering.places(frame, len(maps)), modes, strengths, grey, strict=True
    )
    placed = tuple(
        nm.PackedMap(one, name, left, top, mode, strength, mask)
        for one, name, (left, top), mode, strength, mask in rows
    )
    return read, placed, frame


def _say(session: Session, read: list[nm.NormalMap], target: Path, workspace: nm.Workspace) -> None:
    for one in read:
        say_map(session, one)
    kind = f"{'half' if workspace.half else workspace.bits} {'' if workspace.half else 'bit '}".strip()
    session.say(f"  {len(workspace.layers)} layers on {workspace.frame}, {kind}, bottom to top:")
    for layer in workspace.layers:
        rows, cols = layer.size
        session.say(
            f"    {layer.name}: {cols} x {rows} at {layer.left},{layer.top}{', with a mask' if layer.mask else ''}"
        )
    session.say(f"  wrote {target}")
