"""``nmap compose blend``."""

from __future__ import annotations

from dataclasses import dataclass

from nmaptool.options import BlendOptions, ReadOptions, WriteOptions
from nmaptool.options.fields import Options, option
from nmaptool_cli.command import command
from nmaptool_cli.compose.edits import finish_edit
from nmaptool_cli.inputs import read_grey, read_map
from nmaptool_cli.outputs import MapOutputs
from nmaptool_cli.run import Run


@dataclass(frozen=True)
class BlendMask(Options, group="Inputs"):
    """Where the detail is applied.

    Parameters
    ----------
    mask:
        Grey picture, white where the detail is applied.
    """

    mask: str | None = option(None)


@command(BlendMask, MapOutputs, WriteOptions, BlendOptions, ReadOptions)
def blend(run: Run, base: str, detail: str, /) -> None:
    """Blend a detail map with a base map of the same size.

    Example: nmap compose blend maps/base.exr maps/detail.exr -o crisper.exr --strength 1.5

    Parameters
    ----------
    base:
        Normal map of the forms; the result has the same coverage. - reads standard input.
    detail:
        Normal map of the detail, flat where nothing should change, such as the detail map of nmap bake.
    """
    mask = run[BlendMask].mask
    outputs = run[MapOutputs].plan(run[WriteOptions], run.options.json)
    run.begin(outputs, base=base, detail=detail, mask=mask)
    import nmaptool as nm

    with run.work() as (files, _):
        below = read_map(run, files["base"])
        above = read_map(run, files["detail"], like=below, own_layer=False)
        chosen = read_grey(run, files["mask"])
        result = nm.blend(below, above, run[BlendOptions], mask=chosen, mask_name=mask or "")
    files = {"base": base, "detail": detail, "mask": mask}
    finish_edit(run, outputs, result, [below, above], files=files)
