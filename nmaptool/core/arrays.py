"""Array types used throughout the package."""

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]
Mask = NDArray[np.bool_]
# (h, w, 3): a picture for display
Srgb = NDArray[np.uint8]
_Array = TypeVar("_Array", bound=NDArray[Any])


def read_only(array: _Array) -> _Array:
    """Return a read-only view, so that values checked once cannot change afterwards."""
    view = array.view()
    view.flags.writeable = False
    return view
