"""Transfer between a level and the next coarser one: residuals are restricted, corrections are interpolated."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from nmaptool.core.parallel import for_each_band
from nmaptool.solver.multigrid.level import Shape, inner, margin, rows_at_once
from nmaptool.solver.multigrid.off_grid import OffGridTransfer
from nmaptool.solver.multigrid.values import Values, add_product


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

    def restrict(self, rows_of: Callable[[int, int], Values], out: Values) -> None:
        """Write the coarse residual to ``out`` (flat); ``rows_of(first, last)`` gives (n, cols) fine rows."""
        rows, cols = self.coarse

        def band(part: slice) -> None:
            first, last = part.start, part.stop
            above = max(2 * first - 1, 0)
            fine = rows_of(above, min(2 * last, self.fine[0]))
            out[first * cols : last * cols] = self._restricted(fine, above - 2 * first, first, last)

        for_each_band(rows, rows_at_once(self.coarse), band)

    def _restricted(self, fine: Values, top: int, first: int, last: int) -> Values:
        """Return coarse rows ``first`` to ``last``; ``fine`` starts ``top`` (-1 or 0) rows from row 2 * first."""
        cols = self.coarse[1]
        start, stop = margin(self.coarse) + first * cols, margin(self.coarse) + last * cols
        weight = self.weights

        lead = -top

        def part(down: int, across: int) -> Values:
            """Return the rows of a kind, flat, after one zero; kinds below start one row higher."""
            kind = np.zeros(1 + (down + last - first) * cols, fine.dtype)
            skip = down * (1 - lead)
            found = fine[(1 - lead if down else lead) :: 2, across::2][: down + last - first - skip]
            kind[1:].reshape(-1, cols)[skip : skip + found.shape[0], : found.shape[1]] = found
            return kind

        beside, under, diagonal = part(0, 1), part(1, 0), part(1, 1)
        out = fine[lead::2, ::2][: last - first].ravel()
        for name, step, values in (
            ("b_w", 0, beside[1:]),
            ("b_e", 1, beside[:-1]),
            ("u_n", 0, under[1 + cols :]),
            ("u_s", cols, under[1:-cols]),
            ("d_nw", 0, diagonal[1 + cols :]),
            ("d_ne", 1, diagonal[cols:-1]),
            ("d_sw", cols, diagonal[1:-cols]),
            ("d_se", cols + 1, diagonal[: -cols - 1]),
        ):
            add_product(out, weight[name][start - step : stop - step], values)
        return out

    def prolong(self, coarse: Values, out: Values) -> None:
        """Add the interpolated coarse correction to ``out``; both fields have margins."""
        rows, cols = self.coarse
        grid, edge, weight = inner(out, self.fine), margin(self.coarse), self.weights

        def band(part: slice) -> None:
            first, last = part.start, part.stop
            start, stop = edge + first * cols, edge + last * cols

            def add(down: int, across: int, *parts: tuple[str, int]) -> None:
                where = grid[2 * first + down : 2 * last : 2, across::2]
                total = weight[parts[0][0]][start:stop] * coarse[start + parts[0][1] : stop + parts[0][1]]
                for name, step in parts[1:]:
                    add_product(total, weight[name][start:stop], coarse[start + step : stop + step])
                where += total.reshape(-1, cols)[: where.shape[0], : where.shape[1]]

            grid[2 * first : 2 * last : 2, ::2] += coarse[start:stop].reshape(-1, cols)
            add(0, 1, ("b_w", 0), ("b_e", 1))
            add(1, 0, ("u_n", 0), ("u_s", cols))
            add(1, 1, ("d_nw", 0), ("d_ne", 1), ("d_sw", cols), ("d_se", cols + 1))

        for_each_band(rows, rows_at_once(self.coarse), band)
