"""What numbers the levels hold: float32, or float64 for weights that span too much for it."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

# float32 or float64, all of one hierarchy alike
Values = NDArray[np.floating[Any]]


def add_product(out: Values, one: Values, *others: Values) -> None:
    """Add a product to ``out``, in one pass for two factors; all flat, contiguous and of one type."""
    for other in others[1:]:
        one = one * other
    cv2.accumulateProduct(one, others[0], out)


def add_scaled(out: Values, one: Values, factor: float) -> None:
    """Add ``factor`` times an array to ``out``, in one pass."""
    cv2.scaleAdd(one, factor, out, out)
