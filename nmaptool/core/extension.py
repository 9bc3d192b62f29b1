"""The extension module of compiled loops; see `nmaptool.kernels`. Nothing heavy is imported here."""

from __future__ import annotations

import importlib
import os
from typing import Any


def load_extension() -> Any:
    """The extension; None if it was not built, or ``NMAPTOOL_KERNELS=numpy`` asks for NumPy."""
    if _is_switched_off():
        return None
    try:
        return importlib.import_module("nmaptool._compiled")
    except ImportError:
        return None


def kernels_in_use() -> str:
    """``compiled`` or ``numpy``, for reports."""
    return "numpy" if load_extension() is None else "compiled"


def extension_is_missing() -> bool:
    """Whether the extension was not built, although nothing asks for NumPy."""
    return not _is_switched_off() and load_extension() is None


def _is_switched_off() -> bool:
    return os.environ.get("NMAPTOOL_KERNELS") == "numpy"
