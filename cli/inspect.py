"""``nmap inspect``."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from nmaptool.core.errors import UsageError
from nmaptool.options import ReadOptions, TilingOptions
from nmaptool.options.fields import Options, option
from nmaptool.options.kinds import Switch
from nmaptool.options.presets import DEPTH_PRESETS, NORMAL_PRESETS
from nmaptool_cli.command import command
from nmaptool_cli.compose.large import is_large
from nmaptool_cli.inputs import read_grey
from nmaptool_cli.mentions import in_flags
from nmaptool_cli.run import Run
from nmaptool_cli.streams import display_name


@dataclass(frozen=True)
class Mask(Options, group="Inputs"):
    """The area to inspect, or the presets.

    Parameters
    ----------
    mask:
        Grey picture, white where the map is to be inspected.
    presets:
        List the programs that --from knows, and how each writes its files. Needs no map.
    """

    mask: str | None = option(None)
    presets: bool = option(False, Switch())


@command(Mask, TilingOptions, ReadOptions)
def inspect(run: Run, map: str | None = None, /) -> int:
    """Inspect a normal map: its conventions, background and precision, and every problem with its remedy.

    Exit code 0: no findings; 1: findings.

    Example: nmap inspect lion.png

    Parameters
    ----------
    map:
        Normal map: {pictures}; FILE.exr:layer reads one layer; - reads standard input.
    """
    if run[Mask].presets:
        return _list_presets(run)
    if map is None:
        raise UsageError("MAP is missing; name one, such as nmap inspect lion.png, or list the `presets`")
    reading = run[ReadOptions]
    if is_large(run, None, map, max_megapixels=reading.max_megapixels):
        return _inspect_large(run, map)
    run.begin(map=map, mask=run[Mask].mask)
    import nmaptool as nm

    with run.work() as (files, _):
        chosen = read_grey(run, files["mask"])
        found = nm.inspect_map(nm.read_raster(files["map"], reading), reading, mask=chosen)
    found = dataclasses.replace(found, name=display_name(found.name))
    if run.options.json:
        run.data(found.to_dict())
    elif not run.options.quiet:
        from nmaptool_cli.wording.maps import describe_inspection

        print(in_flags("\n".join(describe_inspection(found))))
    return 1 if found.findings else 0


def _inspect_large(run: Run, name: str) -> int:
    """Inspect a large map."""
    mask = run[Mask].mask
    run.begin(map=name, mask=mask)
    import nmaptool as nm

    with run.progress() as progress:
        found = nm.tiled.inspect(
            name, reading=run[ReadOptions], mask=mask, tiling=run[TilingOptions], progress=progress
        )
    if run.options.json:
        run.data(found.to_dict())
    elif not run.options.quiet:
        from nmaptool_cli.wording.large_edits import describe_large_inspection

        print(in_flags("\n".join(describe_large_inspection(found))))
    return 1 if found.findings else 0


def _list_presets(run: Run) -> int:
    """Print the table of presets."""
    if run.options.json:
        normals = {name: dataclasses.asdict(preset) for name, preset in NORMAL_PRESETS.items()}
        depths = {name: dataclasses.asdict(preset) for name, preset in DEPTH_PRESETS.items()}
        run.data({"normals": normals, "depths": depths})
        return 0
    from nmaptool_cli.wording.maps import describe_presets

    print("\n".join(describe_presets()))
    return 0
