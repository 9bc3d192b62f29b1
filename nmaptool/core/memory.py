"""The memory that is available, as the operating system reports it."""

from __future__ import annotations

import ctypes
import os
import sys
from pathlib import Path

# share of the installed memory to use where the system does not report free memory
_SHARE_OF_ALL = 0.75


def available_bytes(root: Path = Path("/")) -> int | None:
    """Bytes of memory that can be used without swapping; None if the system does not report them.

    On Linux, the available memory or what the control groups (containers) leave, whichever is smaller. On Windows, the
    free memory. Elsewhere, such as on macOS, three quarters of the installed memory.

    Parameters
    ----------
    root : Path
        The folder that contains ``proc`` and ``sys``.
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
    """The number in a file; None for ``max`` or if there is no file."""
    text = _text(path).strip()
    return int(text) if text.isdecimal() else None


def _fields(text: str) -> dict[str, int]:
    """Parse lines of a name and a number."""
    rows = (line.replace(":", " ").split() for line in text.splitlines())
    return {row[0]: int(row[1]) for row in rows if len(row) > 1 and row[1].isdecimal()}


def _meminfo(path: Path) -> int | None:
    size = _fields(_text(path)).get("MemAvailable")
    return None if size is None else size * 1024


def _groups(root: Path) -> list[int]:
    """The memory that each control group of this process leaves; cached files do not count as used."""
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
        # in a container the path may be that of the host; the mount itself is then the group
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
