"""First pass of a relief by tiles: the system of each tile, from windows of the maps."""

from __future__ import annotations

import dataclasses
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Float64
from nmaptool.core.errors import InputError
from nmaptool.core.grid import touching_vertices
from nmaptool.options import ReadOptions
from nmaptool.reliefs.inputs import ReliefMaps, check_weights
from nmaptool.reliefs.window import WindowSystem, window_system
from nmaptool.solver.system import QuadSystem
from nmaptool.solver.tiling.grid import Box, Tile, inside, of_vertices
from nmaptool.solver.tiling.islands import Labels, label_faces, label_vertices
from nmaptool.solver.tiling.tile import face_means, lines_of, restricted
from nmaptool.tiled.inputs import GREYS
from nmaptool.tiled.job import ReliefJob

# bits of the state of a vertex
UNKNOWN, SURFACE, MOTIF = 1, 2, 4
SIDES = ("top", "bottom", "left", "right")


@lru_cache(maxsize=8)
def _map(name: str, settled: ReadOptions) -> Any:
    from nmaptool.io.stores.normal_maps import reopen_normal_map

    return reopen_normal_map(name, settled)


@lru_cache(maxsize=8)
def _heights(name: str) -> Any:
    from nmaptool.io.stores.heights import open_heights

    return open_heights(name)


def base_of_window(job: ReliefJob, window: Box) -> Float64 | None:
    """(h+1, w+1) heights in px of the curved background in a window of faces; None without one.

    Raises
    ------
    InputError
        If it has holes.
    """
    name = job.files.surface
    if name is None:
        return None
    base = np.asarray(_heights(name).window(*of_vertices(window)), np.float64)
    if not np.isfinite(base).all():
        raise InputError(f"the curved background {name} has holes; it must be defined everywhere")
    return base / job.pitch_mm


def window_of_maps(job: ReliefJob, window: Box) -> ReliefMaps:
    """Read a window of all inputs."""
    files = job.files
    greys: dict[str, Float32 | None] = {}
    for name in GREYS:
        picture = job.greys.get(name)
        greys[name] = None if picture is None else picture.window(*window)
    factors = check_weights({name: greys[f"{name}_map"] for name in ("mu", "beta", "delta")})
    detail = None
    if files.detail is not None and job.detail_reading is not None:
        detail = _map(files.detail, job.detail_reading).window(*window)
    original = _map(job.original, job.reading).window(*window)
    return ReliefMaps(original, detail, greys["mask"], greys["wall_mask"], None, **factors)


def assemble(job: ReliefJob, tile: Tile) -> None:
    """Build the system of a tile, store it, and record its sums."""
    grid, folder = job.grid, job.folder
    window = grid.window(tile, job.margin)
    faces, vertices = grid.faces(tile), grid.vertices(tile)
    own, owned = inside(faces, window), inside(vertices, of_vertices(window))
    maps = window_of_maps(job, window)
    weights = dataclasses.replace(job.weights, mu_map=maps.mu, beta_map=maps.beta, delta_map=maps.delta)
    base = base_of_window(job, window)
    system = window_system(maps, job.options, weights, job.pitch_mm, own, base)
    unknown = touching_vertices(system.weight > 0)
    unknown |= system.beta > 0
    unknown &= ~system.held
    whole = QuadSystem(system.weight, system.beta, system.held) if system.weight.any() else None
    tie = np.zeros(unknown.shape) if whole is None else whole.apply(unknown.astype(np.float64))
    tie[~unknown] = 0
    load = system.load
    if job.loads == ("load",):
        load = load + job.weights.delta * system.pull.astype(np.float64)
    loads = {"load": np.where(unknown, load, 0.0)}
    if "pull" in job.loads:
        loads["pull"] = np.where(unknown, system.pull, 0).astype(np.float64)
    state = UNKNOWN * unknown.astype(np.uint8) + SURFACE * system.surface + MOTIF * touching_vertices(system.motif)
    folder.write("weight", faces, system.weight[own])
    folder.write("beta", vertices, system.beta[owned])
    folder.write("state", vertices, state[owned].astype(np.uint8))
    mean = face_means(system.weight[own], grid)
    blocks: dict[str, Any] = {
        "mean": mean,
        "tie": restricted(tie[owned], grid, tile),
        "reach": restricted(unknown[owned].astype(np.float64), grid, tile),
    }
    record: dict[str, Any] = {
        "counts": np.array(_counts(system, own, unknown[owned])),
        "most": np.array(system.weight[own].max()),
    }
    labels, vertex_labels, count = tile_labels(job, tile, system.weight, window)
    record["islands"] = np.array(count)
    record |= {f"faces_{side}": line for side, line in _outer(labels).items()}
    add_lines(record, "weight", system.weight[own], 2)
    add_lines(record, "beta", system.beta[owned], 1)
    add_lines(record, "unknown", unknown[owned], 1)
    add_lines(record, "labels", vertex_labels, 1)
    if base is not None:
        folder.write("base", vertices, base[owned])
        # what the held heights leave
        rest = np.zeros(load.shape)
        if whole is not None:
            whole.residual(loads["load"], np.where(unknown, 0.0, base), rest)
            rest[~unknown] = 0
    for name, stored in loads.items():
        folder.write(name, vertices, stored[owned])
        values = rest if job.base_of(name) else stored
        blocks[name] = restricted(values[owned], grid, tile)
        record[f"{name}_sums"] = _sums(vertex_labels, count, values[owned], system, owned)
        add_lines(record, name, stored[owned], 1)
    folder.put(f"assembled_blocks/{tile.row}_{tile.col}", blocks)
    folder.put(f"assembled/{tile.row}_{tile.col}", record)


def _counts(system: WindowSystem, own: Box, unknown: NDArray[Any]) -> tuple[int, ...]:
    """Counts of a tile: motif, selected, steep, acting, flat, motif without height term, unknown vertices, any held."""
    motif = system.motif[own]
    acts = system.foreground[own]
    return (
        int(np.count_nonzero(motif)),
        int(system.selected),
        system.steep,
        system.acting,
        system.flat,
        int(np.count_nonzero(motif & ~acts)),
        int(np.count_nonzero(unknown)),
        int(bool(system.held[own].any())),
    )


def _sums(labels: Labels, count: int, load: NDArray[Any], system: WindowSystem, owned: Box) -> NDArray[Any]:
    """(count+1, 7): sums over each island of load^2, load, beta, load beta, beta^2, of held vertices and of all."""
    beta = system.beta[owned].astype(np.float64)
    inside_any = labels > 0
    held = system.held[owned] & inside_any
    if count == 1:
        flat = load.ravel(), beta.ravel()
        sums = flat[0] @ flat[0], load.sum(), beta.sum(), flat[0] @ flat[1], flat[1] @ flat[1]
        return np.array([[0.0] * 7, [*sums, np.count_nonzero(held), np.count_nonzero(inside_any)]])
    columns = (load * load, load, beta, load * beta, beta * beta, held, inside_any)
    return np.column_stack([sum_by_label(labels, count, values) for values in columns])


def sum_by_label(labels: Labels, count: int, values: NDArray[Any]) -> NDArray[Any]:
    """(count+1,) float64: sums of values by label; the values must be 0 where the label is 0."""
    if count == 1:
        return np.array([0.0, values.sum(dtype=np.float64)])
    return np.bincount(labels.ravel(), values.ravel(), count + 1)


def tile_labels(job: ReliefJob, tile: Tile, weight: Float32, window: Box) -> tuple[Labels, Labels, int]:
    """Islands of the faces that touch a tile's vertices, those of its vertices, and their number.

    Parameters
    ----------
    job : ReliefJob
    tile : Tile
    weight : float32
        Weights of the faces of a window.
    window : pair of slices
    """
    grid = job.grid
    rows, cols = grid.faces(tile)
    around = slice(max(rows.start - 1, 0), rows.stop), slice(max(cols.start - 1, 0), cols.stop)
    labels, count = label_faces(np.ascontiguousarray(weight[inside(around, window)]))
    of_corners = label_vertices(labels)[inside(grid.vertices(tile), of_vertices(around))]
    return labels, np.ascontiguousarray(of_corners), count


def _outer(values: NDArray[Any]) -> dict[str, NDArray[Any]]:
    return {"top": values[0], "bottom": values[-1], "left": values[:, 0], "right": values[:, -1]}


def add_lines(record: dict[str, Any], name: str, values: NDArray[Any], width: int) -> None:
    """Add the outermost lines of an array to a record."""
    lines = lines_of(values, width)
    record |= {f"{name}_{side}": getattr(lines, side) for side in SIDES}
