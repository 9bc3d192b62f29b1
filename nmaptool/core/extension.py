"""The extension module of compiled loops; see `nmaptool.kernels`. Nothing heavy is imported here."""

from __future__ import annotations

import importlib
import os
from typing import Any


def load_extension() -> Any:
    """The extension; None if it was not built, or ``NMAPTOOL_KERNELS=numpy`` asks for NumPy."""
    if os.environ.get("NMAPTOOL_KERNELS") == "numpy":
        return None
    try:
        return importlib.import_module("nmaptool._compiled")
    except ImportError:
        return None


def kernels_in_use() -> str:
    """``compiled`` or ``numpy``, for reports."""
    return "numpy" if load_extension() is None else "compiled"
