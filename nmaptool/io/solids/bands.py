"""Bands of triangles as the readers of written files find them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


class UnreadableError(Exception):
    """The file does not have the form in which it was written; the message says how."""


@dataclass(frozen=True, eq=False)
class Triangles:
    """Some triangles of a file.

    Attributes
    ----------
    points : (n, 3) float32 or float64
        Vertices; none if the records hold coordinates.
    records : (m, stride) uint8
        At ``offset``, the three int32 rows or the nine float32 coordinates of the corners of each triangle. They are
        overwritten by the triangles that follow.
    offset : int
        Bytes.
    unit_mm : float
        Size of the unit of the coordinates.
    """

    points: NDArray[Any]
    records: NDArray[np.uint8]
    offset: int = 0
    unit_mm: float = 1.0
