"""Normal maps of analytic surfaces, to compose."""

import numpy as np

import nmaptool as nm

FLAT = np.array([0, 0, 1], np.float32)


def from_slopes(p, q):
    """Unit normals (y up) from slopes."""
    normals = np.dstack([-p, -q, np.ones_like(p)])
    return (normals / np.linalg.norm(normals, axis=-1, keepdims=True)).astype(np.float32)


def random_normals(rows=40, cols=50, seed=0, lowest=0.02):
    """Random unit normals that face the viewer."""
    vectors = np.random.default_rng(seed).normal(size=(rows, cols, 3))
    vectors[..., 2] = np.abs(vectors[..., 2]) + lowest
    return (vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)).astype(np.float32)


def as_map(normals, coverage=None, pitch_mm=None, foreground=None, name="map"):
    shape = normals.shape[:2]
    coverage = np.ones(shape, np.float32) if coverage is None else np.asarray(coverage, np.float32)
    normals = np.where((coverage > 0)[..., None], normals, FLAT)
    return nm.NormalMap(normals, coverage, nm.Frame(*shape, pitch_mm), foreground, name)


def flat_map(rows, cols, pitch_mm=None):
    """A plate: flat and covered everywhere, without a motif."""
    normals = np.broadcast_to(FLAT, (rows, cols, 3)).copy()
    return as_map(normals, pitch_mm=pitch_mm, foreground=np.zeros((rows, cols), bool), name="plate")


def bump_map(rows=200, cols=240, turned_deg=0.0, stretch=(1.0, 1.0), height=1.0):
    """A bumpy height field, rotated counter-clockwise, then stretched about its centre; heights times a factor."""
    y, x = np.mgrid[0:rows, 0:cols]
    x, y = (x + 0.5 - cols / 2) / stretch[0], -(y + 0.5 - rows / 2) / stretch[1]
    cos, sin = np.cos(np.radians(turned_deg)), np.sin(np.radians(turned_deg))
    u, v = cos * x + sin * y, cos * y - sin * x
    hill = 30 * np.exp(-((u / 45) ** 2) - (v / 25) ** 2)
    along = -hill * 2 * u / 45**2 + 5 / 10 * np.cos(u / 10) * np.cos(v / 15)
    across = -hill * 2 * v / 25**2 - 5 / 15 * np.sin(u / 10) * np.sin(v / 15)
    p, q = cos * along - sin * across, sin * along + cos * across
    return as_map(from_slopes(height * p / stretch[0], height * q / stretch[1]))


def angles_deg(first, second):
    """Angles in degrees between unit vectors, accurate for small angles."""
    chord = np.linalg.norm(first.astype(np.float64) - second, axis=-1)
    return np.degrees(2 * np.arcsin((chord / 2).clip(0, 1)))
