"""Names for the array types that travel through the package."""

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]
Mask = NDArray[np.bool_]
# (h, w, 3): a picture for looking at
Srgb = NDArray[np.uint8]
_Array = TypeVar("_Array", bound=NDArray[Any])


def read_only(array: _Array) -> _Array:
    """A view that cannot be written through: values that were checked once stay as they were."""
    view = array.view()
    view.flags.writeable = False
    return view
