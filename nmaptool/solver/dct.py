"""Exact solve on a full rectangle with constant weights: the DCT-I diagonalises the operator."""

from __future__ import annotations

import numpy as np
from scipy import fft

from nmaptool.arrays import Float64
from nmaptool.progress import Progress
from nmaptool.solver.system import QuadSystem, vertex_share


class DctMethod:
    """Diagonal solve in the cosine basis.

    After division by the vertices' shares (1, 1/2, 1/4) the operator's eigenvalues are
    k ((1+cx)(1-cy) + (1-cx)(1+cy) + (1-cx)(1-cy)) + beta with cx = cos(pi j/W), cy = cos(pi i/H).
    """

    name = "dct"

    def __init__(self, system: QuadSystem) -> None:
        rows, cols = system.weight.shape
        self._share = vertex_share((rows, cols))
        # 1 - cos x as 2 sin^2(x/2): no digits are lost at low frequencies
        fall_x = 2 * np.sin(np.pi * np.arange(cols + 1) / (2 * cols)) ** 2
        fall_y = (2 * np.sin(np.pi * np.arange(rows + 1) / (2 * rows)) ** 2)[:, None]
        shape = (2 - fall_x) * fall_y + fall_x * (2 - fall_y) + fall_x * fall_y
        eigenvalues = float(system.weight.flat[0]) * shape + float(system.beta.flat[0] / self._share.flat[0])
        with np.errstate(divide="ignore"):
            self._inverse = 1 / eigenvalues
        if not np.isfinite(self._inverse[0, 0]):
            self._inverse[0, 0] = 0  # beta = 0: the constant is free

    def correct(
        self, residual: Float64, tolerance: float, max_iterations: int, progress: Progress | None
    ) -> tuple[Float64, tuple[float, ...]]:
        """One exact solve; see `nmaptool.solver.prepare.Method`."""
        spectrum = fft.dctn(residual / self._share, type=1, workers=-1, overwrite_x=True)
        spectrum *= self._inverse
        step = fft.idctn(spectrum, type=1, workers=-1, overwrite_x=True)
        if progress is not None:
            progress("solving", 1.0)
        return step, (0.0,)
