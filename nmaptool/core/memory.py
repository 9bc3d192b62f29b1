"""How much memory this computer has to give, asked of the operating system itself."""

from __future__ import annotations

import ctypes
import os
import sys
from pathlib import Path

# where the system does not say what is free: so much of what is built in
_SHARE_OF_ALL = 0.75


def available_bytes(root: Path = Path("/")) -> int | None:
    """Memory that can be had without swapping; None where the system does not tell.

    Linux says what is free and what its control groups (containers) leave; Windows says what is free. Elsewhere, as on
    macOS, it is three quarters of what is built in.

    Parameters
    ----------
    root : Path
        Where ``proc`` and ``sys`` are.
    """
    if sys.platform == "win32":
        return _free_on_windows()
    found = [size for size in (_meminfo(root / "proc/meminfo"), *_groups(root)) if size is not None]
    if not found:
        built_in = _built_in()
        return None if built_in is None else int(_SHARE_OF_ALL * built_in)
    return min(found)


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="ascii", errors="replace")
    except OSError:
        return ""


def _number(path: Path) -> int | None:
    """What a file of one number says; None for ``max`` and where there is no file."""
    text = _text(path).strip()
    return int(text) if text.isdecimal() else None


def _fields(text: str) -> dict[str, int]:
    """Lines of a name and a number."""
    rows = (line.replace(":", " ").split() for line in text.splitlines())
    return {row[0]: int(row[1]) for row in rows if len(row) > 1 and row[1].isdecimal()}


def _meminfo(path: Path) -> int | None:
    size = _fields(_text(path)).get("MemAvailable")
    return None if size is None else size * 1024


def _groups(root: Path) -> list[int]:
    """What each control group around this process leaves, cached files not counted as taken."""
    mount = root / "sys/fs/cgroup"
    left = []
    for line in _text(root / "proc/self/cgroup").splitlines():
        _, _, rest = line.partition(":")
        controllers, _, inside = rest.partition(":")
        if controllers == "":
            base, limit_name, used_name = mount, "memory.max", "memory.current"
        elif "memory" in controllers.split(","):
            base, limit_name, used_name = mount / "memory", "memory.limit_in_bytes", "memory.usage_in_bytes"
        else:
            continue
        # within a container the path may be the host's: the mount itself is the group then
        group = base / inside.strip("/")
        for folder in (group, *group.parents):
            limit, used = _number(folder / limit_name), _number(folder / used_name)
            if limit is not None and used is not None:
                statistics = _fields(_text(folder / "memory.stat"))
                cached = statistics.get("total_inactive_file", statistics.get("inactive_file", 0))
                left.append(max(0, limit - used + cached))
            if folder == base:
                break
    return left


def _built_in() -> int | None:
    if sys.platform == "win32":
        return None
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):
        return None


class _MemoryStatus(ctypes.Structure):
    """MEMORYSTATUSEX."""

    _fields_ = (
        ("length", ctypes.c_ulong),
        ("load", ctypes.c_ulong),
        *((name, ctypes.c_ulonglong) for name in ("all", "free", "all_page", "free_page", "all_virtual")),
        ("free_virtual", ctypes.c_ulonglong),
        ("free_extended", ctypes.c_ulonglong),
    )


def _free_on_windows() -> int | None:
    status = _MemoryStatus()
    status.length = ctypes.sizeof(status)
    windows = getattr(ctypes, "windll", None)
    if windows is None or not windows.kernel32.GlobalMemoryStatusEx(ctypes.byref(status)):
        return None
    return int(status.free)
