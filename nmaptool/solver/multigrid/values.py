"""What numbers the levels hold: float32, or float64 for weights that span too much for it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

# float32 or float64, all of one hierarchy alike
Values = NDArray[np.floating[Any]]
