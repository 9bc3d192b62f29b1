"""Turn meshes whose file says which axis points up, so that y does."""

from __future__ import annotations

from nmaptool.core.arrays import Float64

_AXES = {"X": ((1, -1), (0, 1), (2, 1)), "Z": ((0, 1), (2, 1), (1, -1))}


def turned_y_up(points: Float64, up: str) -> Float64:
    """(N, 3) float64: points of a file whose axis ``up`` (X, Y or Z) points up, turned so that y does.

    >>> turned_y_up(np.array([[1.0, 2.0, 3.0]]), "Z").tolist()
    [[1.0, 3.0, -2.0]]
    """
    axes = _AXES.get(up)
    if axes is None:
        return points
    out = points[:, [axis for axis, _ in axes]]
    return out * [float(sign) for _, sign in axes]
