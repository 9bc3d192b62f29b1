"""The interface of the methods that solve a system; the loop around them is in `nmaptool.solver.solve`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64

Report = Callable[[float], None]


class Method(Protocol):
    """Computes a correction of the heights from a residual.

    Attributes
    ----------
    name : str
    precision : type
        np.float32 or np.float64: the type of the residual that it accepts.
    """

    name: str

    @property
    def precision(self) -> type[np.floating[Any]]:
        """Type of the residual."""

    def improve(
        self, z: Float64, residual: NDArray[Any], reduction: float, max_iterations: int, report: Report | None
    ) -> tuple[float, ...]:
        """Add a correction to ``z``.

        Parameters
        ----------
        z : (H+1, W+1) float64
        residual : (H+1, W+1) of the method's precision
            0 at vertices that are not unknown; may be overwritten.
        reduction : float
            Norm of the residual to reach, relative to the given one. A method may stop earlier at the limit of its
            precision; it is then called again with a newly computed residual.
        max_iterations : int
        report : callable, optional
            Called with the relative residual after each iteration.

        Returns
        -------
        tuple of float
            Relative residual after each iteration; at least one value.
        """


@runtime_checkable
class DirectMethod(Method, Protocol):
    """A method that solves directly and in place; only for systems without held vertices."""

    def answer(self, right_hand_side: Float64) -> None:
        """Replace a right-hand side (H+1, W+1) float64 by the heights, in place."""
