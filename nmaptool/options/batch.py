"""Options for sets of jobs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from nmaptool.core.errors import UsageError
from nmaptool.core.units import memory
from nmaptool.options.fields import Options, option
from nmaptool.options.kinds import Count, Switch, Text


@dataclass(frozen=True)
class BatchOptions(Options, group="Batch"):
    """How the jobs of a set are run.

    Parameters
    ----------
    workers:
        Processes that work at the same time. Default: one for each core, or fewer with more threads each if the maps
        are too large for the memory.
    memory_limit:
        Most memory for all processes together, such as 8GB; it decides how many work at the same time, and nmap relief
        refuses a map that needs more alone. Default: the machine's free memory.
    scheduler:
        Use a running Dask cluster at this address, such as tcp://10.0.0.5:8786, instead of processes on this machine.
        All files must have the same paths on its workers.
    journal:
        File that records finished items. Default: .nmap-batch.jsonl in the folder of the outputs.
    again:
        Run every item again, also those that are finished and unchanged.
    """

    workers: int | None = option(None, Count("4", 1, 1024))
    memory_limit: str | None = option(None, Text("8GB"))
    scheduler: str | None = option(None, Text("tcp://10.0.0.5:8786"))
    journal: Path | None = option(None)
    again: bool = option(False, Switch())

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.memory_limit is not None:
            try:
                memory(self.memory_limit)
            except UsageError as error:
                raise UsageError(f"`memory_limit={self.memory_limit!r}`: {str(error).partition(': ')[2]}") from None
        if self.scheduler is not None and self.workers is not None:
            raise UsageError("`workers`: a cluster has its own workers; leave it out with `scheduler`")
        if self.scheduler is not None and "://" not in self.scheduler:
            raise UsageError(
                f"`scheduler={self.scheduler!r}`: must be the address of a scheduler, such as tcp://10.0.0.5:8786"
            )

    @property
    def memory_limit_bytes(self) -> int | None:
        """The limit in bytes; None if none is given."""
        return None if self.memory_limit is None else memory(self.memory_limit)
