"""Options for maps larger than memory."""

from __future__ import annotations

from dataclasses import dataclass

from nmaptool.core.errors import UsageError
from nmaptool.options.fields import Options, option
from nmaptool.options.kinds import Count, Text


@dataclass(frozen=True)
class TilingOptions(Options, group="Large maps"):
    """How a map larger than memory is worked on: a Zarr store, a folder of tiles or a large TIFF.

    Parameters
    ----------
    tile:
        Side of a tile in px, a multiple of 64. Default: the largest for which there is memory.
    workers:
        Worker processes on this machine; 0 works in the process of the command. Default: one per core, as far as the
        memory allows.
    scheduler:
        Use the workers of a running Dask cluster, such as tcp://10.0.0.5:8786. They must see the same files.
    work_folder:
        Folder or address for intermediate results, about 30 bytes per pixel. Default: the name of the output with
        .work. It is removed at the end; a run that was stopped goes on from it.
    """

    tile: int | None = option(None, Count("2048"))
    workers: int | None = option(None, Count("2", low=0))
    scheduler: str | None = option(None, Text("tcp://10.0.0.5:8786"))
    work_folder: str | None = option(None, Text("/scratch/relief.work"))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.tile is not None and self.tile % 64:
            raise UsageError(f"`tile={self.tile}`: must be a multiple of 64, such as `tile=2048`")
        if self.workers is not None and self.scheduler is not None:
            raise UsageError(f"`workers={self.workers}`: is for this machine; leave it out with `scheduler`")
