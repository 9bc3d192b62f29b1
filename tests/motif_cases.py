"""Small motifs for plates: domes, rings, letters, and pictures without background."""

import numpy as np

import nmaptool as nm
from nmaptool.core.vectors import unit

SIDE = 96


def _map(z, inside, name):
    """The normal map of heights in px, y up."""
    rows, cols = np.gradient(z)
    normals = unit(np.dstack([-cols, rows, np.ones_like(z)]))
    normals[~inside] = (0, 0, 1)
    return nm.NormalMap(normals.astype(np.float32), inside.astype(np.float32), nm.Frame(*z.shape, 0.2), name=name)


def _grid(side=SIDE):
    y, x = np.mgrid[1 : -1 : side * 1j, -1 : 1 : side * 1j]
    return x, y


def _hills(*centres):
    x, y = _grid()
    return sum(9 * np.exp(-8 * ((x - a) ** 2 + (y - b) ** 2)) for a, b in centres)


def dome():
    """Half a ball."""
    x, y = _grid()
    return _map(12 * np.sqrt(np.maximum(0.8 - x**2 - y**2, 0.02)), np.hypot(x, y) < 0.8, "dome")


def ring():
    """A ring with a hole."""
    x, y = _grid()
    away = np.hypot(x, y)
    return _map(8 * np.cos(8 * (away - 0.6)), np.abs(away - 0.6) < 0.18, "ring")


def star():
    """A star with five rays."""
    x, y = _grid()
    reach = 0.5 + 0.35 * np.cos(5 * np.arctan2(x, y))
    return _map(10 * (1 - np.hypot(x, y)), np.hypot(x, y) < reach, "star")


def two_parts():
    """Two hills apart from each other."""
    x, y = _grid()
    inside = (np.hypot(x - 0.45, y - 0.2) < 0.3) | (np.hypot(x + 0.45, y + 0.2) < 0.35)
    return _map(_hills((0.45, 0.2), (-0.45, -0.2)), inside, "two parts")


def letter():
    """An E, with sharp corners."""
    x, y = _grid()
    inside = (np.abs(y) < 0.75) & (x > -0.5) & (x < 0.55)
    inside &= (x < -0.15) | (np.abs(np.abs(y) - 0.62) < 0.14) | (np.abs(y) < 0.12)
    return _map(2 * np.sin(9 * x) + 2 * np.cos(7 * y), inside, "letter")


def at_the_border():
    """A hill that the border of the picture cuts."""
    x, y = _grid()
    return _map(_hills((-0.9, -0.7), (0.1, 0.0)), np.hypot(x + 0.5, y + 0.4) < 0.9, "at the border")


def picture():
    """A picture without background."""
    x, y = _grid()
    return _map(3 * np.sin(5 * x + 1) * np.cos(6 * y), np.ones_like(x, bool), "picture")


def cross():
    """A cross of thin bars, three pixels wide."""
    x, y = _grid()
    inside = (np.minimum(np.abs(x), np.abs(y)) < 0.035) & (np.maximum(np.abs(x), np.abs(y)) < 0.85)
    return _map(1.0 - np.minimum(np.abs(x), np.abs(y)), inside, "cross")


MOTIFS = {
    each.__name__.replace("_", " "): each
    for each in (dome, ring, star, two_parts, letter, at_the_border, picture, cross)
}
