"""How many processes work at the same time, and with how many threads each: by the memory that items need."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from nmaptool.core.memory import available_bytes
from nmaptool.core.parallel import cores
from nmaptool.io.pictures.picture_size import picture_size
from nmaptool.options.batch import BatchOptions
from nmaptool.solver.memory import estimate
from nmaptool.types.batch import BatchItem

# measured at 4096 x 4096 px: what a process holds before its first map, and what reading, writing and pictures need
# beside the solver's arrays, in bytes per px of the largest input and of each other one
PROCESS_BYTES = 400_000_000
_BYTES_PER_PX, _BYTES_PER_OTHER_PX = 100, 24
# a mesh in memory, and its renderings, in bytes for each byte of its file
_BYTES_PER_MESH_BYTE = 12
_LARGEST_DEFAULT_VIEW_PX = 4_000_000
# the share of the free memory that is planned; the rest is for the system's own cache of files
_SHARE = 0.9
_MESHES = (".ply", ".obj", ".stl", ".off", ".glb", ".gltf", ".3mf", ".dae", ".usd", ".usda", ".usdc", ".usdz")


@dataclass(frozen=True)
class Shift:
    """Items that are run together.

    Parameters
    ----------
    workers, threads : int
        Processes, and threads in each.
    items : tuple of int
        Numbers of the items, in order.
    """

    workers: int
    threads: int
    items: tuple[int, ...]


def needed_bytes(item: BatchItem) -> int:
    """Estimate the peak memory of a process that runs an item, from the headers of its pictures."""
    sizes = sorted((each for name in item.files if (each := _size(name)) is not None), key=lambda s: s[0] * s[1])
    needed = PROCESS_BYTES
    if sizes:
        cols, rows = sizes[-1]
        needed += cols * rows * _BYTES_PER_PX + sum(c * r for c, r in sizes[:-1]) * _BYTES_PER_OTHER_PX
        needed += estimate((rows, cols), 0, "multigrid")
    for name in item.files:
        if name.lower().endswith(_MESHES):
            needed += Path(name).stat().st_size * _BYTES_PER_MESH_BYTE + _LARGEST_DEFAULT_VIEW_PX * _BYTES_PER_PX
    return needed


def _size(name: str) -> tuple[int, int] | None:
    path = Path(name)
    return None if path.suffix.lower() in (*_MESHES, ".toml") else picture_size(path)


def shifts(
    needed: Mapping[int, int], options: BatchOptions, *, free: int | None = None, machine: int | None = None
) -> list[Shift]:
    """Divide items into shifts: small ones on one process for each core, larger ones on fewer with more threads.

    Parameters
    ----------
    needed : mapping of int to int
        The memory that each item needs, by number.
    options : BatchOptions
    free, machine : int, optional
        Bytes of memory, and cores. Default: those of this machine.

    Returns
    -------
    list of Shift
        The one with most processes first; every item is in one of them.

    Examples
    --------
    >>> shifts({0: 10, 1: 10, 2: 60, 3: 120}, BatchOptions(), free=100, machine=4)
    [Shift(workers=2, threads=2, items=(0, 1)), Shift(workers=1, threads=4, items=(2, 3))]
    """
    machine = cores() if machine is None else machine
    most = options.workers or machine
    limit = options.memory_limit_bytes
    if limit is None:
        found = available_bytes() if free is None else free
        limit = None if found is None else int(found * _SHARE)
    groups: dict[int, list[int]] = {}
    for number, size in needed.items():
        fitting = most if limit is None else max(1, min(most, limit // max(size, 1)))
        groups.setdefault(_round(fitting, most), []).append(number)
    return [
        Shift(workers, max(1, machine // workers), tuple(numbers))
        for count, numbers in sorted(groups.items(), reverse=True)
        if (workers := min(count, len(numbers)))
    ]


def _round(fitting: int, most: int) -> int:
    """Round down to ``most`` or its half, quarter and so on, so that there are few shifts."""
    count = most
    while count > fitting:
        count //= 2
    return max(1, count)


def sizes_of(items: Sequence[BatchItem], numbers: Sequence[int]) -> dict[int, int]:
    """Estimate the memory of some of the items."""
    return {number: needed_bytes(items[number]) for number in numbers}
