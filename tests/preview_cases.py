"""Reliefs to preview."""

import numpy as np

import nmaptool as nm

PITCH = 0.25


def cone(rows=80, cols=120, slope=0.5, top_mm=5.0):
    """A cone on a plate, its tip at (15, 10) mm."""
    y, x = np.mgrid[rows:-1:-1, 0 : cols + 1] * PITCH
    z = np.maximum(top_mm - slope * np.hypot(x - 15, y - 10), 0)
    return nm.Height(z, np.ones((rows, cols), bool), nm.Frame(rows, cols, PITCH))


def disc(side=80):
    z = cone(side, side).z_mm
    y, x = np.mgrid[0:side, 0:side] + 0.5
    inside = np.hypot(x - side / 2, y - side / 2) < side / 2 - 4
    return nm.Height(z, inside, nm.Frame(side, side, PITCH))
