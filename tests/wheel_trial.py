"""Try an installed wheel: ``python tests/wheel_trial.py compiled``, or ``numpy``.

Exits with 1 if the inner loops are not run by what is named, or a surface of known heights is not solved for.
"""

import sys

import numpy as np

import nmaptool as nm
from nmaptool import kernels
from nmaptool.core.grid import height_slopes

SIDE, MOST_ERROR_PX = 300, 1e-2


def error_px():
    """Largest error of the heights of a saddle on a disc, solved from its normals."""
    y, x = np.mgrid[: SIDE + 1, : SIDE + 1] - SIDE / 2
    z = (2 * x * x - y * y + x * y) / (2 * SIDE)
    p, q = height_slopes(z)
    inside = np.hypot(x[1:, 1:] - 0.5, y[1:, 1:] - 0.5) < 0.48 * SIDE
    solved = nm.integrate(np.dstack([-p, -q, np.ones_like(p)]), inside)
    return float(np.ptp((solved - z)[1:, 1:][inside]))


if __name__ == "__main__":
    found, error = "compiled" if kernels.IS_COMPILED else "numpy", error_px()
    sys.stdout.write(f"{nm.__file__}\n{found} kernels; the heights are right to {error:.0e} px\n")
    sys.exit(found != sys.argv[1] or error > MOST_ERROR_PX)
