"""``nmap compose pack``."""

from __future__ import annotations

import dataclasses
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from nmaptool.errors import UsageError
from nmaptool.options import PackOptions, ReadOptions
from nmaptool_cli.compose.outputs import say_map
from nmaptool_cli.session import COMPOSING, OUTPUTS, READING, RUN, RunOptions, Session, input_files

if TYPE_CHECKING:
    import nmaptool as nm

_Words = Annotated[tuple[str, ...], Parameter(show_default=False)]
_PLACE = re.compile(r"\s*([-+]?\d+)\s*(?:px)?\s*,\s*([-+]?\d+)\s*(?:px)?\s*")


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
        Place of the map's top left corner in px, across,down, such as 40,-12. Default: 0,0.
    name:
        What the layer is called. Default: the file's name.
    mask:
        Grey picture of the map's size, white where it shows: the layer's mask. "none" for a map without.
    """

    at: _Words = ()
    name: _Words = ()
    mask: _Words = ()

    def check(self, count: int) -> None:
        """Refuse flags that are not given once for every map."""
        for flag in ("at", "name", "mask"):
            given = len(getattr(self, flag))
            if given not in (0, count):
                raise UsageError(
                    f"--{flag}: is given {given} times for {count} maps; give it once for each map, or never"
                )

    def places(self, count: int) -> list[tuple[int, int]]:
        """(left, top) of each map."""
        found = []
        for text in self.at:
            match = _PLACE.fullmatch(text)
            if match is None:
                raise UsageError(f"--at {text!r}: expected whole pixels across and down, such as 40,-12")
            found.append((int(match.group(1)), int(match.group(2))))
        return found or [(0, 0)] * count


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

    Example: nmap compose pack base.exr detail.exr --at 0,0 --at 120,40 -o work.psd, and after the editor nmap compose
    unpack work.psd -o maps

    Parameters
    ----------
    maps:
        Normal maps, bottom to top; FILE.exr:layer names a layer.
    """
    from nmaptool.io.normal_maps import split_layer
    from nmaptool.io.replace import check_target
    from nmaptool.io.workspaces import check_workspace_target

    session = Session(run)
    target = output.output
    if target is None:
        raise UsageError("nothing to write: say where, such as -o work.psd")
    bits = check_workspace_target(target, options.bits, options.half)
    layering.check(len(maps))
    places = layering.places(len(maps))
    check_target(target, output.overwrite)
    inputs = (split_layer(name)[0] for name in (*maps, *layering.mask))
    if target.exists() and any(path.exists() and target.samefile(path) for path in inputs):
        raise UsageError(f"{target}: is also an input; give another name for the output")
    import nmaptool as nm

    masks = [None if name == "none" else name for name in layering.mask] or [None] * len(maps)
    with input_files(*maps, *masks) as sources:
        read = [nm.read_normal_map(str(name), reading) for name in sources[: len(maps)]]
        grey = [None if m is None else nm.read_grey(m, reading.max_megapixels) for m in sources[len(maps) :]]
    names = layering.name or _names(maps)
    rows = zip(read, names, places, grey, strict=True)
    placed = [nm.PackedMap(one, name, *place, mask=mask) for one, name, place, mask in rows]
    workspace = nm.pack(placed, dataclasses.replace(options, bits=bits))
    nm.write_workspace(target, workspace, overwrite=output.overwrite)
    _say(session, read, target, workspace)
    if run.json:
        session.data({"output": str(target), **(workspace.metadata or {})})


def _names(maps: tuple[str, ...]) -> tuple[str, ...]:
    """``maps/work.exr:detail`` is called detail, ``shell.png`` shell."""
    from nmaptool.io.normal_maps import split_layer

    return tuple(layer or path.stem for path, layer in map(split_layer, maps))


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
