"""The inner loops that are compiled if a C compiler was there when the package was built.

Every compiled function has a twin in NumPy with the same signature; without a compiler the twins are used. Callers
split the work into parts that do not depend on the number of threads, so results do not either.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

_FORBIDDEN = os.environ.get("NMAPTOOL_KERNELS") == "numpy"

if TYPE_CHECKING:
    from nmaptool.kernels.pair_twins import at_faces, pair_sums

    IS_COMPILED: bool
else:
    try:
        if _FORBIDDEN:
            raise ImportError
        from nmaptool.kernels._compiled import at_faces, pair_sums

        IS_COMPILED = True
    except ImportError:
        from nmaptool.kernels.pair_twins import at_faces, pair_sums

        IS_COMPILED = False

__all__ = ["IS_COMPILED", "at_faces", "pair_sums"]
