"""``nmap compose blend``."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

from nmaptool.options import BlendOptions, ReadOptions, TilingOptions, WriteOptions
from nmaptool.options.fields import Options, option
from nmaptool_cli.command import command
from nmaptool_cli.compose.edits import finish_edit
from nmaptool_cli.compose.large import edit_large, finish_large, is_large, refuse_for_large, store_name
from nmaptool_cli.inputs import read_grey, read_map
from nmaptool_cli.outputs import MapOutputs
from nmaptool_cli.run import Run

if TYPE_CHECKING:
    import nmaptool as nm
    from nmaptool.core.progress import Progress
    from nmaptool.types.tiled_edit import TiledEdit


@dataclass(frozen=True)
class BlendMask(Options, group="Inputs"):
    """Where the detail is applied.

    Parameters
    ----------
    mask:
        Grey picture, white where the detail is applied.
    """

    mask: str | None = option(None)


@command(BlendMask, MapOutputs, WriteOptions, BlendOptions, TilingOptions, ReadOptions)
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
    if is_large(run, run[MapOutputs].output, base, detail, mask, max_megapixels=run[ReadOptions].max_megapixels):
        _blend_large(run, base, detail, mask)
        return
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


def _blend_large(run: Run, base: str, detail: str, mask: str | None) -> None:
    """Blend large maps."""
    flags, options = run[MapOutputs], run[BlendOptions]
    refuse_for_large({"curl": flags.curl, "fit": options.fit})
    output, inputs = store_name(flags.output), {"base": base, "detail": detail, "mask": mask}
    import nmaptool as nm

    def blended(progress: Progress | None) -> TiledEdit[nm.ComposeReport]:
        return nm.tiled.blend(
            base,
            detail,
            output,
            options,
            mask=mask,
            reading=run[ReadOptions],
            writing=run[WriteOptions],
            tiling=run[TilingOptions],
            overwrite=flags.overwrite,
            progress=progress,
        )

    finish_large(run, flags, edit_large(run, flags, blended, **inputs), reading=asdict(run[ReadOptions]))
