"""Resident memory of this process: current use and peak since a given moment.

Only Linux reports the current use; on other systems, a peak counts from the start of the process.
"""

from __future__ import annotations

import ctypes
import re
import resource
import sys
from pathlib import Path

_STATUS, _CLEAR = Path("/proc/self/status"), Path("/proc/self/clear_refs")


def begin() -> int:
    """Release free memory and reset the peak; return the bytes in use."""
    try:
        ctypes.CDLL(None).malloc_trim(0)
        _CLEAR.write_text("5", encoding="utf-8")
    except (AttributeError, OSError):
        return peak()
    return _read("VmRSS")


def peak() -> int:
    """Peak bytes since `begin`."""
    if _STATUS.exists():
        return _read("VmHWM")
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def _read(name: str) -> int:
    found = re.search(rf"^{name}:\s*(\d+) kB", _STATUS.read_text(encoding="utf-8"), re.M)
    return int(found[1]) * 1024 if found else 0
