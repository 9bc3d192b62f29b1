"""Checks of masks and maps that several features share."""

from __future__ import annotations

from typing import Any

import numpy as np

from nmaptool.core.arrays import Float32
from nmaptool.core.errors import InputError, UsageError
from nmaptool.types.normal_map import NormalMap


def require_map(value: Any, what: str) -> None:
    """Refuse what is not a normal map, such as a path.

    Raises
    ------
    UsageError
    """
    if not isinstance(value, NormalMap):
        raise UsageError(f"{what} must be a NormalMap, found {type(value).__name__}; read one with read_normal_map")


def check_sizes(original: NormalMap, others: dict[str, tuple[int, ...]]) -> None:
    """Refuse inputs of another size than the original.

    Raises
    ------
    InputError
    """
    rows, cols = original.frame.shape
    for what, shape in others.items():
        if shape != (rows, cols):
            size = " x ".join(str(n) for n in reversed(shape)) or "a single value"
            raise InputError(f"{original.name} is {cols} x {rows} pixels but {what} is {size}; make them the same size")


def check_mask(mask: Any) -> Float32 | None:
    """A mask as float32 in 0..1.

    Raises
    ------
    InputError
        If it holds anything else; bool counts as 0 and 1.
    """
    if mask is None:
        return None
    try:
        array = np.asarray(mask, np.float32)
    except (TypeError, ValueError):
        raise UsageError(f"the mask must be an array of numbers, found {type(mask).__name__}") from None
    if array.size and not (np.isfinite(array).all() and array.min() >= 0 and array.max() <= 1):
        raise InputError("the mask must hold values from 0 to 1 (divide 8-bit codes by 255)")
    return array


def motif_coverage(normal_map: NormalMap) -> Float32:
    """(H, W) float32 coverage of the motif alone: 0 on a background that is a defined part of the map."""
    background = (normal_map.coverage == 1) & ~normal_map.foreground
    return np.where(background, np.float32(0), normal_map.coverage)
