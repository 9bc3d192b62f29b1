"""Transfer between a level and the next coarser one: residuals are restricted, corrections are interpolated."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

import nmaptool.kernels.transfer_twins as transfer_twins
from nmaptool import kernels
from nmaptool.core.parallel import for_each_band
from nmaptool.kernels.coarsening import WEIGHTS
from nmaptool.kernels.grid_twins import Values
from nmaptool.solver.multigrid.level import Shape, rows_at_once
from nmaptool.solver.multigrid.off_grid import OffGridTransfer


@dataclass(eq=False)
class Transfer:
    """Interpolation from the next coarser level.

    Attributes
    ----------
    fine, coarse : (int, int)
        Shapes of the grids.
    weights : mapping of str to flat arrays with margins
        Weights in the layout of the coarse grid; see `interpolation.WEIGHTS`.
    off_grid : OffGridTransfer
    """

    fine: Shape
    coarse: Shape
    weights: dict[str, Values]
    off_grid: OffGridTransfer | None

    def __post_init__(self) -> None:
        self.dtype = self.weights[WEIGHTS[0]].dtype
        self._loops: Any = kernels if self.dtype == np.float32 else transfer_twins

    def restrict(self, fine: Values, out: Values) -> None:
        """Write the coarse residual to ``out``; both are flat."""
        rows, cols = self.coarse

        def band(part: slice) -> None:
            first, last = part.start, part.stop
            above = max(2 * first - 1, 0)
            below = min(2 * last, self.fine[0])
            self._loops.restrict_rows(
                *self.ordered,
                fine[above * self.fine[1] : below * self.fine[1]],
                out,
                self.fine[1],
                cols,
                above - 2 * first,
                first,
                last,
            )

        for_each_band(rows, rows_at_once(self.coarse), band)

    @property
    def ordered(self) -> tuple[Values, ...]:
        """The weights in the order of `WEIGHTS`."""
        return tuple(self.weights[name] for name in WEIGHTS)

    def prolong(self, coarse: Values, out: Values) -> None:
        """Add the interpolated coarse correction to ``out``; both fields have margins."""
        rows, cols = self.coarse

        def band(part: slice) -> None:
            self._loops.prolong_rows(
                *self.ordered, coarse, out, self.fine[1], cols, self.fine[0], part.start, part.stop
            )

        for_each_band(rows, rows_at_once(self.coarse), band)
