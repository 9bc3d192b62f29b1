"""The number type of the levels: float32, or float64 if the weights span too wide a range."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

# float32 or float64, the same throughout a hierarchy
Values = NDArray[np.floating[Any]]


def add_product(out: Values, one: Values, *others: Values) -> None:
    """Add a product to ``out``, in one pass for two factors; all arrays are flat, contiguous and of the same type."""
    for other in others[1:]:
        one = one * other
    cv2.accumulateProduct(one, others[0], out)


def add_scaled(out: Values, one: Values, factor: float) -> None:
    """Add ``factor`` times an array to ``out``, in one pass."""
    cv2.scaleAdd(one, factor, out, out)
