"""Analytic surfaces to cut into parts, and how parts are compared with the whole."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy import ndimage
from solid_cases import PLATE, random_blobs

import nmaptool as nm
from nmaptool.core.grid import touching_vertices

PITCH_MM = 0.25


def grid(rows: int, cols: int) -> tuple[np.ndarray, np.ndarray]:
    """(rows + 1, cols + 1) x and y of vertices in mm, y up."""
    x, y = np.meshgrid(np.arange(cols + 1) * PITCH_MM, (rows - np.arange(rows + 1)) * PITCH_MM)
    return x, y


def height_of(z_mm: np.ndarray, domain: np.ndarray | None = None, raised: np.ndarray | None = None) -> nm.Height:
    """Heights at vertices, 0 where there is no surface."""
    rows, cols = z_mm.shape[0] - 1, z_mm.shape[1] - 1
    domain = np.ones((rows, cols), bool) if domain is None else domain
    z_mm = np.where(touching_vertices(domain), z_mm, 0.0)
    return nm.Height(z_mm, domain, nm.Frame(rows, cols, pitch_mm=PITCH_MM), raised)


def plane(rows: int = 30, cols: int = 44) -> nm.Height:
    """A plane that rises by 0.1 across and 0.05 up."""
    x, y = grid(rows, cols)
    return height_of(0.1 * x + 0.05 * y)


def cap(rows: int = 50, cols: int = 50) -> nm.Height:
    """A spherical cap with a radius of 12 mm that is cut off at a circle of 5.5 mm."""
    x, y = grid(rows, cols)
    from_middle = np.hypot(x - x.mean(), y - y.mean())
    centre = (from_middle[:-1, :-1] + from_middle[1:, 1:]) / 2
    return height_of(np.sqrt(144 - np.minimum(from_middle, 6.5) ** 2) - 10, centre < 5.5)


def ramp_with_holes(rows: int = 41, cols: int = 53) -> nm.Height:
    """A ramp with round holes, and pixels that touch only at corners on the lines between parts."""
    x, _ = grid(rows, cols)
    domain = np.ones((rows, cols), bool)
    for row, col, radius in ((10, 12, 6), (20, 26, 7), (33, 44, 5)):
        r, c = np.ogrid[:rows, :cols]
        domain &= np.hypot(r - row, c - col) > radius
    domain[30:34, 8:12] = np.indices((4, 4)).sum(axis=0) % 2 == 0
    return height_of(0.2 * x, domain)


def relief_of(height: nm.Height, coverage: np.ndarray | None = None) -> nm.Relief:
    """The height field as a relief on a plate."""
    return nm.Relief(height, height.domain, PLATE, coverage)  # type: ignore[arg-type]


def random_height(seed: int) -> nm.Height:
    """Random heights: cut out, with a raised motif, or over the whole picture."""
    rng = np.random.default_rng([seed, 3])
    mask, _ = random_blobs(rng, 6, 45)
    rows, cols = mask.shape
    z_mm = ndimage.gaussian_filter(rng.standard_normal((rows + 1, cols + 1)), 1.5)
    if seed % 3 == 0:
        return height_of(z_mm, mask)
    if seed % 3 == 1:
        raised = ndimage.binary_opening(
            ndimage.gaussian_filter(rng.standard_normal((rows, cols)), 3) > 0, np.ones((3, 3))
        )
        raised = ndimage.binary_closing(raised, np.ones((3, 3)))
        on = touching_vertices(raised)
        falling = raised[:-1, :-1] & raised[1:, 1:] & ~raised[:-1, 1:] & ~raised[1:, :-1]
        rising = raised[:-1, 1:] & raised[1:, :-1] & ~raised[:-1, :-1] & ~raised[1:, 1:]
        if raised.any() and not raised.all() and not (falling | rising).any():
            return height_of(np.where(on, 1.5 + 0.2 * z_mm, 0.1 * z_mm), None, raised)
    return height_of(z_mm)


def random_counts(seed: int, height: nm.Height) -> str:
    """Up to five parts across and down."""
    rng = np.random.default_rng([seed, 4])
    rows, cols = height.frame.shape
    return f"{rng.integers(1, min(cols, 5) + 1)}x{rng.integers(1, min(rows, 5) + 1)}"


def triangles(solids: Iterable[nm.Solid]) -> set[tuple[tuple[float, ...], ...]]:
    """The triangles that face up, with their corners in mm to 1e-9, from the least corner on."""
    found = set()
    for solid in solids:
        mesh = solid.to_mesh()
        corners = mesh.vertices[mesh.faces].round(9) + 0.0
        up = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] > 1e-12
        for triangle in corners[up].tolist():
            rows = [tuple(corner) for corner in triangle]
            first = rows.index(min(rows))
            found.add((*rows[first:], *rows[:first]))
    return found


def area(solids: Iterable[nm.Solid]) -> float:
    """Of the triangles that face up, in mm2."""
    total = 0.0
    for solid in solids:
        mesh = solid.to_mesh()
        corners = mesh.vertices[mesh.faces]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
        total += float(np.linalg.norm(normal[normal[:, 2] > 1e-12], axis=1).sum())
    return total


def along(solid: nm.Solid, axis: int, at_mm: float) -> set[tuple[float, ...]]:
    """The vertices on a line between parts, bit by bit."""
    vertices = solid.to_mesh().vertices
    return {tuple(vertex) for vertex in vertices[vertices[:, axis] == at_mm].tolist()}
