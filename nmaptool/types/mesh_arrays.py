"""Convert plain arrays and trimesh objects to the vertices and faces of a mesh."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError, UsageError
from nmaptool.types.plain_arrays import as_numbers

MM_PER_UNIT = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}


def as_vertices(values: Any, name: str) -> Float64:
    """Convert any array of numbers to (N, 3) float64."""
    array = as_numbers(values, f"{name}: vertices")
    _require_three(array, f"{name}: vertices", "")
    return array.astype(np.float64, copy=False).reshape(-1, 3)


def as_faces(values: Any, vertices: int, name: str) -> NDArray[np.int32]:
    """Convert any array of whole numbers from 0 to ``vertices`` - 1 to (M, 3) int32.

    Raises
    ------
    InputError
        If it has another shape, or refers to a missing vertex.
    """
    array = as_numbers(values, f"{name}: faces")
    _require_three(array, f"{name}: faces", "; split larger faces into triangles")
    array = array.reshape(-1, 3)
    with np.errstate(invalid="ignore"):
        wrong = (array < 0) | (array >= vertices) | (array != np.floor(array))
    wrong |= ~np.isfinite(array)
    if wrong.any():
        face, corner = np.argwhere(wrong)[0]
        raise InputError(
            f"{name}: face {face} refers to vertex {array[face, corner]:g}; expected whole numbers from 0 to "
            f"{vertices - 1}"
        )
    return array.astype(np.int32)


def _require_three(array: NDArray[Any], what: str, remedy: str) -> None:
    if array.size and (array.ndim != 2 or array.shape[1] != 3):
        raise InputError(f"{what}: found shape {array.shape}, expected (count, 3){remedy}")


def trimesh_unit(units: str | None) -> float | None:
    """Millimetres per unit of a trimesh object; None if it states no unit.

    Raises
    ------
    InputError
        If trimesh does not know the unit.
    """
    if units in (None, "none"):  # trimesh turns None into "none"
        return None
    from trimesh.units import unit_conversion  # takes long to load

    try:
        return float(unit_conversion(units, "mm"))
    except (KeyError, ValueError):
        raise InputError(f"the trimesh mesh has the unknown unit {units!r}; give mm_per_unit") from None


def require_trimesh(value: Any) -> None:
    """Refuse anything but a single trimesh mesh.

    Raises
    ------
    UsageError
    """
    import trimesh  # takes long to load

    if isinstance(value, trimesh.Scene):
        raise UsageError("expected a trimesh.Trimesh, found a Scene; join its parts with scene.to_mesh()")
    if not isinstance(value, trimesh.Trimesh):
        raise UsageError(f"expected a trimesh.Trimesh, found {type(value).__name__}; use Mesh.from_arrays for arrays")
