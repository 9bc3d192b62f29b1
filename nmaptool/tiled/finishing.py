"""Last passes of a relief by tiles: exact millimetres, and the heights in their store."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.core.grid import corner_mean
from nmaptool.core.progress import Progress
from nmaptool.io.stores.height_output import write_heights
from nmaptool.solver.tiling.grid import Tile, inside, of_vertices
from nmaptool.tiled.assembly import MOTIF, SURFACE, sum_by_label, tile_labels
from nmaptool.tiled.job import ReliefJob
from nmaptool.tiled.solving import Pool, Swept, run_step, teller

# the height term hardly ties an island below this share of its weights
_WEAK_TIE = 1e-6


@dataclass(frozen=True, eq=False)
class Shifts:
    """Constants to add to the islands of each tile, in px, for one load.

    Attributes
    ----------
    of_islands : (count+1,) float64
    numbers : dict of Tile to (count+1,) int32
        See `nmaptool.tiled.solving.Islands`.
    """

    of_islands: Float64
    numbers: Mapping[Tile, NDArray[np.int32]]

    def of(self, tile: Tile) -> Float64:
        """(count+1,) constants of the islands of a tile."""
        return np.asarray(self.of_islands[self.numbers[tile]])


@dataclass(frozen=True)
class Sum:
    """Heights above the background as a sum of solved arrays, and the factor to mm.

    Attributes
    ----------
    arrays : tuple of str
    factors : tuple of float
        Of each array.
    pitch_mm : float
    base : bool
        Whether there is a curved background, which is added and was solved with the first array.
    """

    arrays: tuple[str, ...]
    factors: tuple[float, ...]
    pitch_mm: float
    base: bool = False


def weak_islands(swept: Swept, most_weight: float) -> NDArray[np.bool_]:
    """(count+1,) bool: islands whose constant the residual hardly determines."""
    islands = swept.islands
    stiffness = 4 * most_weight * np.maximum(islands.sizes, 1)
    weak: NDArray[np.bool_] = islands.loose & (islands.ties < _WEAK_TIE * stiffness)
    return weak


def measure(job: ReliefJob, array: str, tile: Tile) -> None:
    """Record sums and extremes of the heights on each island of a tile."""
    from scipy import ndimage  # takes long to load

    grid, folder = job.grid, job.folder
    window = grid.window(tile, 1)
    vertices = grid.vertices(tile)
    _, labels, count = tile_labels(job, tile, folder.read("weight", window), window)
    z, beta = folder.read(array, vertices), folder.read("beta", vertices)
    numbers = np.arange(1, count + 1)
    extremes = [np.asarray(look(z, labels, numbers)) for look in (ndimage.minimum, ndimage.maximum)] if count else []
    folder.put(
        f"{array}_levels/{tile.row}_{tile.col}",
        {
            "pulled": sum_by_label(labels, count, beta * z),
            "sum": sum_by_label(labels, count, np.where(labels > 0, z, 0)),
            "low": np.append(np.inf, extremes[0]) if count else np.array([np.inf]),
            "high": np.append(-np.inf, extremes[1]) if count else np.array([-np.inf]),
        },
    )


def level_islands(
    job: ReliefJob, pool: Pool, swept: Swept, most_weight: float, progress: Progress | None
) -> tuple[Shifts | None, tuple[float, float]]:
    """Return the constants that satisfy the height term in sum, or mean 0 without one, and the range of the heights."""
    weak = weak_islands(swept, most_weight)
    if not weak.any():
        ranges = np.array([record["range"] for record in swept.records.values()])
        return None, (float(ranges[:, 0].min()), float(ranges[:, 1].max()))
    islands = swept.islands
    work = partial(measure, job, swept.array)
    records = run_step(job, pool, f"{swept.array}_levels", work, teller(progress, "levelling"))
    pulled, sums = np.zeros(islands.count + 1), np.zeros(islands.count + 1)
    low, high = np.full(islands.count + 1, np.inf), np.full(islands.count + 1, -np.inf)
    for tile in job.grid:
        at, record = islands.numbers[tile], records[tile]
        np.add.at(pulled, at, record["pulled"])
        np.add.at(sums, at, record["sum"])
        np.minimum.at(low, at, record["low"])
        np.maximum.at(high, at, record["high"])
    tied = islands.ties > 0
    by_term = islands.level - pulled / np.where(tied, islands.ties, 1)
    by_mean = -sums / np.maximum(islands.sizes, 1)
    shift = np.where(weak, np.where(tied, by_term, by_mean), 0.0)
    return Shifts(shift, islands.numbers), (float((low + shift)[1:].min()), float((high + shift)[1:].max()))


def hull(job: ReliefJob, arrays: tuple[str, str], shifts: tuple[Shifts | None, Shifts | None], tile: Tile) -> None:
    """Record the corners of the convex hull of the pairs of heights of a tile: no other vertex is ever an extreme."""
    grid, folder = job.grid, job.folder
    vertices = grid.vertices(tile)
    state = folder.read("state", vertices)
    inner = (state & SURFACE) > 0
    pair = [folder.read(array, vertices) for array in arrays]
    if any(shift is not None for shift in shifts):
        window = grid.window(tile, 1)
        _, labels, _ = tile_labels(job, tile, folder.read("weight", window), window)
        for values, shift in zip(pair, shifts, strict=True):
            if shift is not None:
                np.add(values, shift.of(tile)[labels], out=values)
    points = np.column_stack([values[inner] for values in pair])
    folder.put(f"hull/{tile.row}_{tile.col}", {"points": hull_points(points)})


def hull_points(points: Float64) -> Float64:
    """(m, 2) corners of the convex hull of (n, 2) points; a few others may be among them."""
    turns = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    ways = np.column_stack([np.cos(turns), np.sin(turns)])
    size = np.ptp(points, axis=0) if len(points) else np.ones(2)
    scaled = points / np.where(size > 0, size, 1)
    if len(points) < 128:
        return points
    # points inside the polygon of the extremes in 64 directions are inside the hull
    outer = scaled[[int(np.argmax(scaled @ way)) for way in ways]]
    near = np.zeros(len(points), bool)
    for first, second in zip(outer, np.roll(outer, -1, axis=0), strict=True):
        edge = second - first
        if edge.any():
            offset = (scaled[:, 0] - first[0]) * edge[1] - (scaled[:, 1] - first[1]) * edge[0]
            near |= offset >= -1e-12
    return np.asarray(points[near])


def write(job: ReliefJob, total: Sum, shifts: tuple[Shifts | None, ...], output: str, at: str, tile: Tile) -> None:
    """Write the finished heights of a tile, in mm."""
    grid, folder = job.grid, job.folder
    faces = grid.faces(tile)
    box = of_vertices(faces) if at == "centers" else grid.vertices(tile)
    base = folder.read("base", box) if total.base else None
    z = np.zeros((box[0].stop - box[0].start, box[1].stop - box[1].start))
    for number, (array, factor) in enumerate(zip(total.arrays, total.factors, strict=True)):
        part = folder.read(array, box)
        if base is not None and number == 0:
            part -= base
        part *= factor
        z += part
    below = _count_below(job, tile, z, box)
    if base is not None:
        z += base
    window = grid.window(tile, 1)
    weight = folder.read("weight", window)
    labels, of_corners, _ = tile_labels(job, tile, weight, window)
    if at == "centers":
        z = corner_mean(z)
        rows, cols = faces
        of_corners = labels[labels.shape[0] - (rows.stop - rows.start) :, labels.shape[1] - (cols.stop - cols.start) :]
    for factor, shift in zip(total.factors, shifts, strict=True):
        if shift is not None:
            z += factor * shift.of(tile)[of_corners]
    z *= total.pitch_mm
    if job.options.background in ("free", "cut"):
        z[of_corners == 0] = np.nan
    write_heights(output, box[0].start, box[1].start, z)
    extent = np.array([np.nanmin(z, initial=np.inf), np.nanmax(z, initial=-np.inf)])
    folder.put(f"written/{tile.row}_{tile.col}", {"below": np.array(below), "range": extent})


def _count_below(job: ReliefJob, tile: Tile, above: Float64, box: tuple[slice, slice]) -> tuple[int, int]:
    """Vertices of the motif below the background, and vertices of the motif, of those that a tile owns."""
    vertices = job.grid.vertices(tile)
    motif = (job.folder.read("state", vertices) & MOTIF) > 0
    own = above[inside(vertices, box)]
    return int(np.count_nonzero((own < 0) & motif)), int(np.count_nonzero(motif))
