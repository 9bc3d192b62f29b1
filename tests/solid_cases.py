"""Masks and heights for solids, and what is checked of their triangles."""

from __future__ import annotations

from types import SimpleNamespace

import manifold3d
import numpy as np
import trimesh
from matplotlib.path import Path
from scipy import ndimage

import nmaptool as nm
from nmaptool.types.contours import Contours

PLATE = SimpleNamespace(options=nm.ReliefOptions())  # stands for a report: all that a solid asks of it

# masks with what is hard: islands, holes, corners that touch, bridges of one pixel
HARD_MASKS = {
    "one pixel": ["#"],
    "corner": ["#.", ".#"],
    "other corner": [".#", "#."],
    "ring of corners": [".#.", "#.#", ".#."],
    "hole that touches the outside": ["####", "#.##", "##.#", "####"],
    "hole and island": ["#####", "#...#", "#.#.#", "#...#", "#####"],
    "bridge": ["##...##", "#######", "##...##"],
    "checkerboard": ["#.#.#", ".#.#.", "#.#.#", ".#.#."],
    "comb": ["#.#.#.#", "#######"],
    "stairs": ["#....", "##...", ".##..", "..##.", "...##"],
}


def mask_of(rows: list[str]) -> np.ndarray:
    """(H, W) bool of a drawing."""
    return np.array([[char == "#" for char in row] for row in rows])


def random_blobs(rng: np.random.Generator, smallest: int, largest: int) -> tuple[np.ndarray, np.ndarray]:
    """(H, W) bool a mask from noise to blobs, of random sides, and (H, W) float32 a coverage."""
    rows, cols = (int(side) for side in rng.integers(smallest, largest, 2))
    blur = rng.choice([0.0, 0.7, 1.5, 3.0])
    noise = rng.standard_normal((rows, cols))
    field = ndimage.gaussian_filter(noise, blur) if blur else noise
    field /= field.std() + 1e-9
    mask = field > rng.choice([-0.5, 0.0, 0.5])
    mask.flat[int(np.argmax(field))] = True
    return mask, np.clip(field * rng.choice([0.3, 1.0, 5.0]) + 0.5, 0, 1).astype(np.float32)


def random_relief(seed: int) -> nm.Relief:
    """A random mask from noise to blobs, random heights, and for every second seed a coverage."""
    rng = np.random.default_rng(seed)
    mask, coverage = random_blobs(rng, 1, 40)
    rows, cols = mask.shape
    z_mm = ndimage.gaussian_filter(rng.standard_normal((rows + 1, cols + 1)), 1) * rng.choice([0.1, 1.0])
    height = nm.Height(z_mm, mask, nm.Frame(rows, cols, pitch_mm=0.1))
    return nm.Relief(height, mask, PLATE, coverage if seed % 2 else None)  # type: ignore[arg-type]


def random_options(seed: int) -> nm.SolidOptions:
    """One of the backs, one of the outlines."""
    rng = np.random.default_rng([seed, 1])
    backs = ({"base": "3mm"}, {"base": "3mm", "hollow": "0.5mm"}, {"shell": "0.4mm"})
    back = {name: nm.length(text) for name, text in backs[rng.integers(3)].items()}
    return nm.SolidOptions(outline=str(rng.choice(["auto", "exact", "smooth"])), **back)  # type: ignore[arg-type]


def options(**values: str) -> nm.SolidOptions:
    """Options with lengths as text."""
    lengths = ("base", "shell", "hollow", "max_error")
    return nm.SolidOptions(**{name: nm.length(v) if name in lengths else v for name, v in values.items()})  # type: ignore[arg-type]


def circle(x: float, y: float, radius: float, corners: int, *, is_hole: bool = False) -> np.ndarray:
    """(n, 2) corners on a circle in mm."""
    angle = np.linspace(0, 2 * np.pi, corners, endpoint=False)
    ring = np.column_stack([x + radius * np.cos(angle), y + radius * np.sin(angle)])
    return ring[::-1].copy() if is_hole else ring


def plate(rings, z, rows: int, cols: int, pitch_mm: float = 0.1, raised=None, tolerance_mm: float = 0.0) -> nm.Height:
    """A plate with an exact outline; ``z`` are heights, or a function of x and y in mm, y up."""
    x, y = np.meshgrid(np.arange(cols + 1) * pitch_mm, (rows - np.arange(rows + 1)) * pitch_mm)
    z_mm = np.asarray(z(x, y) if callable(z) else z, np.float64) + np.zeros(x.shape)
    centres = np.column_stack([each.ravel() + 0.5 * pitch_mm for each in (x[:-1, :-1], y[1:, :-1])])
    inside = np.zeros(rows * cols, bool)
    for ring in rings:
        inside ^= Path(np.concatenate([ring, ring[:1]])).contains_points(centres)
    domain = inside.reshape(rows, cols)
    outline = Contours(tuple(np.asarray(ring, np.float64) for ring in rings), tolerance_mm)
    return nm.Height(z_mm, domain, nm.Frame(rows, cols, pitch_mm=pitch_mm), raised, outline)


def random_plate(seed: int) -> nm.Height:
    """A star with random corners, for most seeds with a hole, on a grid from 4 to 60 px; random heights."""
    rng = np.random.default_rng([seed, 2])
    rows, cols = (int(side) for side in rng.integers(4, 60, 2))
    pitch_mm = float(rng.choice([0.05, 0.1, 0.5]))
    middle = np.array([cols, rows]) / 2 * pitch_mm
    reach = middle.min() * 0.99
    least = max(rng.uniform(0.1, 0.95), 1.8 * pitch_mm / reach)  # the middle of a pixel lies inside
    rings = [_star(rng, middle, least * reach, reach, int(rng.integers(5, 40)))]
    if rng.random() < 0.6:
        rings.append(_star(rng, middle, 0.05 * least * reach, 0.2 * least * reach, int(rng.integers(5, 20)))[::-1])
    noise = ndimage.gaussian_filter(rng.standard_normal((rows + 1, cols + 1)), rng.choice([0.3, 1, 3]))
    return plate(rings, np.maximum(noise * rng.choice([0.4, 4.0, 12.0]) * pitch_mm, -2.9), rows, cols, pitch_mm)


def _star(rng: np.random.Generator, middle: np.ndarray, least: float, most: float, corners: int) -> np.ndarray:
    """(n, 2) corners around a point, at random distances and angles."""
    angle = (np.arange(corners) + rng.uniform(0.0, 0.8, corners)) * 2 * np.pi / corners
    away = rng.uniform(least, most, corners)[:, None]
    return middle + away * np.column_stack([np.cos(angle), np.sin(angle)])


def check_solid(solid: nm.Solid) -> None:
    """Closed, consistently wound, outward, a manifold also in single precision, and as large as it says."""
    mesh = solid.to_mesh()
    assert len(mesh.faces) == solid.face_count
    shape = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    assert shape.is_watertight
    assert shape.is_winding_consistent
    assert np.abs(shape.bounds - solid.bounds_mm).max() < 1e-9
    assert shape.volume > 0
    assert abs(shape.volume / solid.volume_mm3 - 1) < 1e-9
    assert trimesh.triangles.area(shape.triangles).min() > 1e-9
    single = mesh.vertices.astype(np.float32)
    assert (
        manifold3d.Manifold(manifold3d.Mesh(single, mesh.faces.astype(np.uint32))).status() == manifold3d.Error.NoError
    )
    merged = trimesh.Trimesh(single, mesh.faces, process=True)  # as a file without shared vertices is read
    assert merged.is_watertight
    assert len(merged.faces) == solid.face_count


def crossings(vertices: np.ndarray, faces: np.ndarray) -> int:
    """Number of pairs of triangles whose insides have points in common, by separating axes.

    Two triangles are apart if along some axis they share no more than a touch. The axes are both normals, the cross
    products of their edges, and the directions across edges within each plane.
    """
    corners = vertices[faces]
    low, high = corners.min(axis=1), corners.max(axis=1)
    touch = 1e-9 * float(np.ptp(vertices))
    found = 0
    for one in range(len(faces) - 1):
        others = np.arange(one + 1, len(faces))
        near = (low[others] < high[one] + touch).all(axis=1) & (high[others] > low[one] - touch).all(axis=1)
        second = corners[others[near]]
        if len(second):
            first = np.broadcast_to(corners[one], second.shape)
            found += int(np.count_nonzero(~_apart(first, second, touch)))
    return found


def _apart(first: np.ndarray, second: np.ndarray, touch: float) -> np.ndarray:
    """(n,) bool: whether an axis separates each pair of triangles."""
    edges = [np.roll(each, -1, axis=1) - each for each in (first, second)]
    normals = [np.cross(each[:, 0], each[:, 1]) for each in edges]
    axes = [*normals]
    axes += [np.cross(edges[0][:, i], edges[1][:, j]) for i in range(3) for j in range(3)]
    axes += [np.cross(normal, each[:, i]) for normal, each in zip(normals, edges, strict=True) for i in range(3)]
    apart = np.zeros(len(first), bool)
    for axis in axes:
        length = np.linalg.norm(axis, axis=1)
        usable = length > 1e-12
        unit = axis / np.where(usable, length, 1.0)[:, None]
        a, b = (np.einsum("nkc,nc->nk", each, unit) for each in (first, second))
        low, high = (np.stack([pick(a), pick(b)]) for pick in (lambda v: v.min(axis=1), lambda v: v.max(axis=1)))
        apart |= usable & ((high[0] < low[1] - touch) | (high[1] < low[0] - touch))
        usable &= ((high - low) > touch).any(axis=0)  # both lie in one plane: this axis says nothing
        apart |= usable & ((high[0] <= low[1] + touch) | (high[1] <= low[0] + touch))
    return apart
