"""A turned vase with chased ornament: leaves, a flowering scroll, a rope, flutes and beads on a smooth body."""

from __future__ import annotations

import numpy as np
from mesh_parts import Array, Mesh, between, bump, smooth_step, strip_faces
from scipy.interpolate import CubicSpline

COLUMNS = 160  # whole numbers per leaf, bay of the scroll, flute and strand of the rope
# radius and height in mm along the section, then the rows up to the next point
SECTION = (
    (7.0, 0.0, 1),
    (15.6, 0.0, 1),
    (16.6, 0.8, 1),
    (16.8, 2.2, 1),
    (15.4, 3.8, 2),
    (10.0, 6.5, 2),
    (8.0, 9.4, 5),
    (8.6, 12.6, 1),
    (10.5, 14.2, 1),
    (12.0, 15.0, 9),
    (21.5, 22.5, 11),
    (27.3, 33.0, 5),
    (29.0, 43.5, 2),
    (28.3, 48.5, 13),
    (23.0, 57.5, 1),
    (21.0, 59.5, 7),
    (17.0, 62.6, 2),
    (13.6, 65.2, 3),
    (11.2, 69.2, 3),
    (10.6, 77.0, 3),
    (12.6, 83.5, 2),
    (15.2, 87.0, 2),
    (17.8, 89.4, 1),
    (18.2, 90.4, 1),
    (17.4, 91.0, 1),
    (16.0, 90.4, 1),
    (13.2, 87.6, 1),
    (10.4, 83.5, 1),
    (8.6, 77.0, 1),
    (7.8, 58.0, 1),
    (6.4, 49.0, 1),
    (3.0, 48.0, 0),
)
BELLY = (14.6, 37.5)  # height range of each ornament
SCROLL = (48.0, 58.0)
ROPE = (59.4, 63.4)
NECK = (65.4, 85.6)
COLLAR = (9.4, 12.6)


def section_rows() -> tuple[Array, Array]:
    """Radius and height of each row, on a smooth curve through the section's points."""
    points = np.array(SECTION)
    at = np.concatenate([k + np.arange(int(n)) / n for k, n in enumerate(points[:-1, 2])] + [[len(points) - 1.0]])
    reach = np.concatenate([[0], np.hypot(*np.diff(points[:, :2], axis=0).T).cumsum()])
    arc = np.interp(at, np.arange(len(points)), reach)
    return CubicSpline(reach, points[:, 0])(arc), CubicSpline(reach, points[:, 1])(arc)


def leaf(across: Array, along: Array) -> Array:
    """Height of a leaf; along is 0 at its root and 1 at its tip, across is -1 to 1 between neighbours."""
    width = 0.96 * (1 - along.clip(0, 1) ** 3)
    share = np.abs(across) / np.maximum(width, 1e-3)
    edge = smooth_step(1.1 - share, 0, 0.35) * smooth_step(1 - along, 0, 0.1)
    hollow = 0.55 * bump((share - 0.45) / 0.42)
    midrib = 0.35 * bump(across / 0.2)
    return edge * (0.95 - hollow + midrib)


def leaves(turn: Array, y: Array) -> Array:
    """Eight leaves, and the tips of eight more behind them."""
    along = (y - BELLY[0]) / (BELLY[1] - BELLY[0])
    near = 1.5 * leaf((8 * turn) % 1 * 2 - 1, along / 0.86)
    far = 1.0 * leaf((8 * turn + 0.5) % 1 * 2 - 1, along)
    return np.where((along > 0) & (along < 1), np.maximum(near, far), 0) * smooth_step(along, 0, 0.05)


def scroll(turn: Array, y: Array) -> Array:
    """A stem that waves around the shoulder with a flower in each bay, between two fillets."""
    middle, half = sum(SCROLL) / 2, (SCROLL[1] - SCROLL[0]) / 2
    q = (y - middle) / half * 6.2  # mm on the slanting shoulder
    wave = 3.4 * np.sin(8 * np.pi * turn)
    slope = np.hypot(1, 3.4 * np.cos(8 * np.pi * turn) * 4 / 26)
    stem = 0.9 * bump((q - wave) / slope / 1.2)
    side = np.where((8 * turn) % 2 < 1, -1.0, 1.0)  # a flower per half wave, on the concave side of the stem
    dx, dy = ((8 * turn) % 1 - 0.5) * 2 * np.pi * 26 / 8, q - side * 1.7
    r, angle = np.hypot(dx, dy), np.arctan2(dx, side * dy)
    petals = 1.1 * bump(r / (3.3 + 0.9 * np.cos(5 * angle)) - 0.35) * (0.6 + 0.4 * np.cos(5 * angle))
    berry = 0.8 * bump(np.hypot(np.abs(dx) - 6.4, q - side * 3.0) / 1.3)
    flower = np.maximum(np.maximum(petals, 1.3 * bump(r / 1.5)), berry)
    fillets = 0.75 * bump((np.abs(q) - 5.8) / 0.75)
    return np.maximum(np.maximum(stem, flower), fillets)


def rope(turn: Array, y: Array, band: tuple[float, float], height: float, strands: int) -> Array:
    """A half-round rope of slanting strands."""
    share = (2 * y - sum(band)) / (band[1] - band[0])
    return height * bump(share) * (0.72 + 0.28 * np.abs(np.cos(np.pi * strands * turn + 1.1 * share)) * 1.4)


def flutes(turn: Array, y: Array) -> Array:
    """Flutes around the neck with round ends."""
    across = (20 * turn) % 1 * 2 - 1
    ends = np.minimum(y - NECK[0], NECK[1] - y)
    depth = bump(across / 0.86) * smooth_step(ends - 1.6 * (1 - bump(across)), 0.4, 2.4)
    return -0.95 * depth


def ornament(turn: Array, y: Array) -> Array:
    """Height of all ornament above the turned body."""
    total = leaves(turn, y) + scroll(turn, y) * between(y, *SCROLL, 0.01) + flutes(turn, y)
    total = total + rope(turn, y, ROPE, 2.3, 40) + rope(turn, y, COLLAR, 1.7, 20)
    return total + 0.4 * between(y, 87.6, 90.0, 0.4) * np.cos(2 * np.pi * 40 * turn)


def vase() -> Mesh:
    """Rows along the section, columns around it; ornament is added along the section's normal."""
    radius, height = section_rows()
    turn, outside = np.arange(COLUMNS) / COLUMNS, (np.arange(len(height)) <= np.argmax(height))[:, None]
    raised = ornament(turn, height[:, None]) * outside
    between_rows = (height + np.roll(height, -1))[:, None] / 2
    faces = strip_faces(raised, ornament(turn + 0.5 / COLUMNS, between_rows) * outside)
    dr, dy = np.gradient(radius), np.gradient(height)
    length = np.hypot(dr, dy)
    r, y = radius[:, None] + (dy / length)[:, None] * raised, height[:, None] - (dr / length)[:, None] * raised
    side = np.stack([r * np.sin(2 * np.pi * turn), y, r * np.cos(2 * np.pi * turn)], -1).reshape(-1, 3)
    ring, top = np.arange(COLUMNS), len(side) - COLUMNS
    following = (ring + 1) % COLUMNS
    foot = np.stack([np.full(COLUMNS, len(side)), following, ring], 1)
    well = np.stack([np.full(COLUMNS, len(side) + 1), top + ring, top + following], 1)
    poles = [(0, height[0], 0), (0, height[-1], 0)]
    return np.vstack([side, poles]), np.vstack([faces, foot, well]).astype(np.int32)
