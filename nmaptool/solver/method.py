"""What a way to solve a system offers; the loop around it is in `nmaptool.solver.solve`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64

Report = Callable[[float], None]


class Method(Protocol):
    """Corrects heights, given a residual.

    Attributes
    ----------
    name : str
    precision : type
        np.float32 or np.float64: of the residual that it takes.
    """

    name: str

    @property
    def precision(self) -> type[np.floating[Any]]:
        """Of the residual."""

    def improve(
        self, z: Float64, residual: NDArray[Any], reduction: float, max_iterations: int, report: Report | None
    ) -> tuple[float, ...]:
        """Add a correction to ``z``.

        Parameters
        ----------
        z : (H+1, W+1) float64
        residual : (H+1, W+1) of the method's precision
            0 where nothing is to be solved; may be overwritten.
        reduction : float
            |residual| that is asked for, relative to that given. A method may stop where its precision ends; it is
            called again with a fresh residual.
        max_iterations : int
        report : callable, optional
            Called with the relative residual after each iteration.

        Returns
        -------
        tuple of float
            Relative residual after each iteration, at least one.
        """


@runtime_checkable
class DirectMethod(Method, Protocol):
    """A method that answers at once and in place; only for systems where nothing is held."""

    def answer(self, right_hand_side: Float64) -> None:
        """Turn a right-hand side (H+1, W+1) float64 into heights, in place."""
