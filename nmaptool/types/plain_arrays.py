"""Check plain arrays and convert them to numbers, masks and unit normals."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.errors import InputError, UsageError
from nmaptool.core.vectors import FLAT, unit


def is_array(value: object) -> bool:
    """Whether a value is an array, can be converted to one, or is a list."""
    return hasattr(value, "__array__") or isinstance(value, list | tuple)


def as_numbers(value: Any, what: str) -> NDArray[Any]:
    """Return any array of booleans, integers or floats, with its type.

    Raises
    ------
    UsageError
        If the value is something else, such as a path.
    """
    try:
        array = np.asarray(value)
    except (TypeError, ValueError):  # lists of unequal length
        array = np.asarray(None)
    if array.dtype.kind not in "biuf":
        raise UsageError(f"{what} must be an array of numbers, found {type(value).__name__}")
    return array


def as_float32(value: Any, what: str) -> Float32:
    """Convert any array of numbers to float32; values beyond its range become infinite."""
    with np.errstate(over="ignore"):
        return as_numbers(value, what).astype(np.float32, copy=False)


def as_mask(value: Any, what: str = "the mask") -> Float32:
    """Convert a mask of any type to float32 in [0, 1]; bool becomes 0 and 1.

    Raises
    ------
    InputError
        If a value is outside [0, 1] or not finite.
    UsageError
        If the value is not an array of numbers.
    """
    array = as_float32(value, what)
    if array.size and not (np.isfinite(array).all() and array.min() >= 0 and array.max() <= 1):
        raise InputError(f"{what} must hold values from 0 to 1 (divide 8-bit codes by 255)")
    return array


def check_sizes(name: str, shape: tuple[int, ...], others: dict[str, tuple[int, ...]]) -> None:
    """Refuse inputs whose size differs from ``shape`` (rows, cols), the size of ``name``.

    Raises
    ------
    InputError
    """
    rows, cols = shape
    for what, other in others.items():
        if other != (rows, cols):
            size = " x ".join(str(n) for n in reversed(other)) or "a single value"
            raise InputError(f"{name} is {cols} x {rows} pixels but {what} is {size}; make them the same size")


def unit_normals(values: Any, coverage: Float32 | None, name: str) -> tuple[Float32, Float32]:
    """Return normals of unit length, flat where nothing is covered, and the coverage.

    Parameters
    ----------
    values : (H, W, 3) float of any type
        Vectors of any length; float32 vectors already of unit length to rounding keep their bits.
    coverage : (H, W) float32 in [0, 1] or None
        None covers everything.
    name : str
        Name for messages.

    Raises
    ------
    InputError
        If the array does not hold normals, sizes differ, or a covered vector has no direction.
    UsageError
        If the value is not an array of numbers.
    """
    vectors = as_numbers(values, name)
    if vectors.dtype.kind != "f":
        raise InputError(
            f"{name}: found {vectors.dtype}, expected floats from -1 to 1; convert codes to normals with "
            "decode_normal_map"
        )
    if vectors.ndim != 3 or vectors.shape[2] != 3:
        hint = "; move the components last, with numpy.moveaxis(normals, 0, -1)" if vectors.shape[:1] == (3,) else ""
        raise InputError(f"{name}: found shape {vectors.shape}, expected (H, W, 3){hint}")
    shape = vectors.shape[:2]
    if coverage is None:
        coverage = np.ones(shape, np.float32)
    check_sizes(name, shape, {"the mask": coverage.shape})
    return _directions(vectors, coverage > 0, name), coverage


def _directions(vectors: NDArray[Any], inside: Mask, name: str) -> Float32:
    largest = np.abs(vectors).max(axis=2, initial=0)
    sound = np.isfinite(largest) & (largest > 0)  # NaN is not finite either
    lost = inside & ~sound
    if lost.any():
        row, col = np.argwhere(lost)[0]
        raise InputError(
            f"{name}: normals without a direction (zero length or not finite): {np.count_nonzero(lost)} of "
            f"{np.count_nonzero(inside)}, the first at row {row}, column {col}; exclude them with a mask"
        )
    # squares of very long or very short vectors exceed the range of float32
    extreme = inside & ((largest < 0.25) | (largest > 4))
    if not inside.all() or extreme.any():
        vectors = np.where(inside[..., None], vectors, np.array(FLAT, vectors.dtype))
        vectors[extreme] /= largest[extreme][:, None]
    return unit(vectors)
