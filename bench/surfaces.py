"""Height fields of any size to write and to triangulate."""

from __future__ import annotations

import numpy as np

import nmaptool as nm


def bumps(rows: int, cols: int) -> nm.Height:
    """Smooth bumps with a fine texture, 100 mm long and about 4 mm high."""
    y, x = np.mgrid[0 : 1 : (rows + 1) * 1j, 0 : 1 : (cols + 1) * 1j]
    z_mm = 2 + np.sin(9 * x) * np.cos(7 * y) + 0.9 * np.sin(2 * x + 1) + 0.05 * np.sin(90 * x) * np.sin(70 * y + 1)
    return nm.Height(z_mm, np.ones((rows, cols), bool), nm.Frame(rows, cols, pitch_mm=100 / max(cols, rows)))
