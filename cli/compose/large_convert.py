"""``nmap compose convert`` of maps larger than memory, and to and from Zarr stores and folders of tiles."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from nmaptool.core.errors import UsageError
from nmaptool.options import ReadOptions, WriteOptions
from nmaptool.options.fields import option
from nmaptool.options.kinds import Count, Switch
from nmaptool_cli.outputs import MapOutputs
from nmaptool_cli.run import Run
from nmaptool_cli.streams import STREAM, refuse_stream

if TYPE_CHECKING:
    import nmaptool as nm


@dataclass(frozen=True)
class ConvertOutputs(MapOutputs):
    """A normal map, also in a Zarr store or as tiles.

    Parameters
    ----------
    output:
        Normal map to write; - writes EXR to standard output, for the next command. A name in .zarr is a Zarr store, one
        without an ending a folder of tiles; a .tif of a large map is in tiles. The ending sets the format:
    tile:
        Side in px of the tiles, or of the shards of a Zarr store. Default: 2048, in a TIFF 512.
    pyramid:
        Add smaller versions to a Zarr store, each of half the size, up to 512 px; the store becomes a group.
    """

    tile: int | None = option(None, Count("1024"))
    pyramid: bool = option(False, Switch())

    def refuse_for_files(self) -> None:
        """Refuse flags that do not apply to a map that is converted in memory.

        Raises
        ------
        UsageError
        """
        given = "pyramid" if self.pyramid else None if self.tile is None else f"tile={self.tile}"
        if given is not None:
            raise UsageError(f"`{given}`: applies to Zarr stores, folders of tiles and large maps; leave it out")


def is_large(name: str, output: str, reading: ReadOptions) -> bool:
    """Whether a map is converted by windows: from or to a store, or from a large TIFF."""
    from nmaptool.io.stores.names import output_kind
    from nmaptool.io.stores.recognition import is_large_map

    made_by_windows = output != STREAM and output_kind(output) in ("zarr", "tiles")
    return made_by_windows or is_large_map(name, reading.max_megapixels)


def large_convert(run: Run, flags: ConvertOutputs, name: str, output: str) -> None:
    """Convert a normal map, or copy a grey picture, by windows."""
    import nmaptool as nm
    from nmaptool.io.output.transaction import Outputs
    from nmaptool.io.stores.opening import open_picture

    reading, writing = run[ReadOptions], run[WriteOptions]
    refuse_stream("a map is converted by windows from and to files and stores; give a name", name, output)
    if flags.curl is not None:
        raise UsageError(f"{flags.curl}: the curl is not drawn for a map that is converted by windows; leave it out")
    run.begin(None, map=name)
    picture = open_picture(name, reading.layer)
    more: dict[str, Any] = {"tile": flags.tile, "pyramid": flags.pyramid, "overwrite": flags.overwrite}
    with run.progress() as progress:
        if "R" in picture.channels:
            report: nm.ConvertReport | None = nm.tiled.convert(
                name, output, reading, writing, **more, progress=progress
            )
        else:
            _refuse_writing(run, name)
            nm.tiled.copy(name, output, **more, progress=progress)
            report = None
    run.say(*_described(name, picture.rows, picture.cols, report))
    if report is not None:
        run.warn(*(f"{name}: {warning}" for warning in report.warnings))
    run.say(f"  wrote {output}")
    told = {} if report is None else report.to_dict()
    metadata = run.header(reading=asdict(reading), rows=picture.rows, cols=picture.cols, **told, output=output)
    run.finish(Outputs((), flags.shared["report"], flags.overwrite), None, metadata, written=())


def _refuse_writing(run: Run, name: str) -> None:
    """Refuse flags about the codes of normal maps for a picture that is copied."""
    for flag in run.named(WriteOptions):
        raise UsageError(f"{name}: is a grey picture, which is copied as it is; leave out `{flag}`")


def _described(name: str, rows: int, cols: int, report: nm.ConvertReport | None) -> Iterator[str]:
    """How the source was read, and what was changed."""
    from nmaptool_cli.wording.edits import describe_conversion

    if report is None:
        yield f"{name}: {cols} x {rows}, a grey picture: copied as it is"
        return
    was = report.source
    share = report.vectors / (rows * cols)
    yield f"{name}: {cols} x {rows}, background {was['background']}, {share:.0%} covered, green {was['green']}"
    yield from describe_conversion(report)
    yield f"  mean |curl| {report.curl_after:.4f} slope per px (before {report.curl_before:.4f})"
