"""The number type of the levels: float32, or float64 if the weights span too wide a range."""

from __future__ import annotations

from nmaptool.kernels.grid_twins import Values as Values
from nmaptool.kernels.grid_twins import accumulate


def add_product(out: Values, one: Values, *others: Values) -> None:
    """Add a product to ``out``, in one pass for two factors; all arrays are flat, contiguous and of the same type."""
    for other in others[1:]:
        one = one * other
    accumulate(one, others[0], out)
