"""Exact solve on a full rectangle with constant weights: the DCT-I diagonalises the operator."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from nmaptool.core.arrays import Float32, Float64
from nmaptool.core.parallel import cores, for_each_band
from nmaptool.solver.method import Report
from nmaptool.solver.operator import rows_at_once
from nmaptool.solver.system import QuadSystem


class DctMethod:
    """Diagonal solve in the cosine basis, in place: the first solve in float64, its corrections in float32.

    After division by the shares of the vertices (1, 1/2, 1/4), the eigenvalues of the operator are
    k ((1+cx)(1-cy) + (1-cx)(1+cy) + (1-cx)(1-cy)) + beta with cx = cos(pi j/W), cy = cos(pi i/H). With fx = 1 - cx and
    fy = 1 - cy, they are (2 k fy + beta) + k (2 - fy) fx. This computes them from two numbers per row and one per
    column, all non-negative, without cancellation and without storing them in an array.
    """

    name = "dct"
    precision = np.float32

    def __init__(self, system: QuadSystem) -> None:
        rows, cols = system.weight.shape
        weight = system.weight_range[1]
        beta = 4 * float(system.beta.flat[0])  # a corner has a quarter of it
        # 1 - cos x as 2 sin^2(x/2): no cancellation at low frequencies
        fall_x = 2 * np.sin(np.pi * np.arange(cols + 1) / (2 * cols)) ** 2
        fall_y = (2 * np.sin(np.pi * np.arange(rows + 1) / (2 * rows)) ** 2)[:, None]
        self._factors = 2 * weight * fall_y + beta, weight * (2 - fall_y), fall_x

    def answer(self, right_hand_side: Float64) -> None:
        """Solve in place; see `nmaptool.solver.method.DirectMethod`."""
        self._solve(right_hand_side)

    def improve(
        self, z: Float64, residual: Float32, reduction: float, max_iterations: int, report: Report | None
    ) -> tuple[float, ...]:
        """Correct by one solve in float32; see `nmaptool.solver.method.Method`."""
        self._solve(residual)

        def add(band: slice) -> None:
            z[band] += residual[band]

        for_each_band(len(z), rows_at_once(z.shape[1]), add)
        return (0.0,)

    def _solve(self, values: NDArray[Any]) -> None:
        values[[0, -1]] *= 2
        values[:, [0, -1]] *= 2
        spectrum = fft.dctn(values, type=1, workers=cores(), overwrite_x=True)
        offset, factor, fall_x = (part.astype(values.dtype, copy=False) for part in self._factors)

        def divide(band: slice) -> None:
            eigenvalues = factor[band] * fall_x
            eigenvalues += offset[band]
            if band.start == 0 and eigenvalues[0, 0] == 0:
                eigenvalues[0, 0] = np.inf  # beta = 0: the constant is free
            spectrum[band] /= eigenvalues

        for_each_band(len(spectrum), rows_at_once(spectrum.shape[1]), divide)
        heights = fft.idctn(spectrum, type=1, workers=cores(), overwrite_x=True)
        if not np.may_share_memory(heights, values):
            values[:] = heights
