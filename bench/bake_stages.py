"""One process of ``bench.bake``: ``python -m bench.bake_stages stages|peak|file FACES-OR-FILE``."""

from __future__ import annotations

import argparse
import functools
import json
import os
import time
from collections.abc import Callable
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before NumPy: as the command does

import matplotlib.figure  # noqa: F401 - loaded here so that no measured stage includes the import
import numpy as np
import pyrender  # noqa: F401
import scipy.sparse.csgraph  # noqa: F401

from bench.tasks import best_of_both
from nmaptool.baking.bake import bake
from nmaptool.filters.decompose import decompose_clean
from nmaptool.io.meshes.reader import read_mesh
from nmaptool.meshes.clean import clean_mesh
from nmaptool.options import BakeOptions, FilterOptions
from nmaptool.render import gl, numpy_raster
from nmaptool.render.camera import frame_camera
from nmaptool.render.face_buffer import Draw, supersampled_camera
from nmaptool.types.mesh import Mesh

_LARGEST_FOR_NUMPY = 400_000
RING = FilterOptions(neighborhood="ring", sigma_s=8.0)


def knobbly_sphere(count: int) -> Mesh:
    """A sphere of 100 mm and about this many faces, with knobs and bumps a few edges wide."""
    rows = max(4, round((count / 4) ** 0.5))
    cols = 2 * rows
    polar, around = np.meshgrid(
        np.linspace(0, np.pi, rows + 1)[1:-1], np.arange(cols) * 2 * np.pi / cols, indexing="ij"
    )
    knobs = 0.12 * np.sin(3 * polar) * np.cos(4 * around)
    fine = rows / 12  # twelve rows of faces per bump
    bumps = 0.5 / fine * np.sin(2 * fine * polar) * np.sin(np.round(2 * fine) * around) * np.sin(polar)
    radius = 50 * (1 + knobs + 0.3 * bumps)
    across = radius * np.sin(polar)
    ring = np.stack([across * np.cos(around), radius * np.cos(polar), across * np.sin(around)], axis=-1)
    vertices = np.concatenate([ring.reshape(-1, 3), [[0, 50.0, 0], [0, -50.0, 0]]])
    number = np.arange((rows - 1) * cols).reshape(rows - 1, cols)
    right = np.roll(number, -1, axis=1)
    above, below, beside, across_ = number[:-1], number[1:], right[:-1], right[1:]
    top, bottom = (np.full(cols, len(vertices) - k) for k in (2, 1))
    corners = (
        (above, across_, below),
        (above, beside, across_),
        (top, right[0], number[0]),
        (bottom, number[-1], right[-1]),
    )
    faces = np.concatenate([np.stack(three, axis=-1).reshape(-1, 3) for three in corners])
    return Mesh(vertices, faces.astype(np.int32), name=f"{len(faces) / 1000:,.0f}k faces")


def load(source: str) -> Mesh:
    """Read a mesh, or make one of this many faces."""
    return knobbly_sphere(int(source)) if source.isdecimal() else read_mesh(source)


def best(job: Callable[[], object], repeat: int, clock: Callable[[], float] = time.perf_counter) -> float:
    """Shortest time of several runs in seconds; with ``time.process_time``, CPU time of all threads."""
    seconds = []
    for _ in range(repeat):
        started = clock()
        job()
        seconds.append(clock() - started)
    return min(seconds)


def stages(mesh: Mesh, repeat: int) -> dict[str, float]:
    """Seconds of each stage."""

    def fresh() -> Mesh:  # a mesh without cached results
        return Mesh(clean.vertices, clean.faces)

    def draw_with(draw: Draw, supersample: int) -> Callable[[], object]:
        samples = supersampled_camera(camera, supersample)
        return lambda: draw(samples.project(clean.vertices), clean.faces, samples.rows, samples.cols)

    clean = clean_mesh(mesh)[0]
    camera = frame_camera(clean, BakeOptions(), 0.0, 0.0)
    seconds = {
        "copy": best(lambda: (mesh.vertices.copy(), mesh.faces.copy()), 10 * repeat),
        "clean": best(lambda: clean_mesh(mesh), repeat),
        "filter ring": best(lambda: decompose_clean(fresh(), RING), repeat),
    }
    for sigma_s in (3.0, 8.0):
        surface = FilterOptions(neighborhood="surface", sigma_s=sigma_s)
        name = f"filter surface, sigma_s {sigma_s:g}"
        filtered = functools.partial(lambda chosen: decompose_clean(fresh(), chosen), surface)
        seconds[name], cpu = best_of_both(filtered, repeat)
        if sigma_s == 3:
            seconds[f"{name}, CPU"] = cpu
    with gl.drawing("egl") as (draw, _):
        for supersample in (1, 2):
            seconds[f"drawing, supersample {supersample}"] = best(draw_with(draw, supersample), repeat)
    if len(mesh.faces) <= _LARGEST_FOR_NUMPY:
        seconds["drawing by NumPy, supersample 1"] = best(draw_with(numpy_raster.visible_faces, 1), repeat)
    plain = BakeOptions(supersample=1, renderer="egl")
    seconds["all layers, ring, supersample 1"] = best(lambda: bake(mesh, plain, RING), repeat)
    default = BakeOptions(renderer="egl")
    seconds["all layers, surface, sigma_s 3, supersample 2"] = best(lambda: bake(mesh, default), repeat)
    return seconds


def write_ply(path: Path, mesh: Mesh) -> None:
    """A binary PLY file of float vertices."""
    faces = np.empty(len(mesh.faces), [("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, mesh.faces
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(mesh.vertices)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(mesh.faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    path.write_bytes(header.encode() + mesh.vertices.astype("<f4").tobytes() + faces.tobytes())


def write_stl(path: Path, mesh: Mesh) -> None:
    """A binary STL file: every triangle has its own corners."""
    faces = np.zeros(len(mesh.faces), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("colour", "<u2")])
    faces["corners"] = mesh.corners
    path.write_bytes(bytes(80) + np.uint32(len(faces)).tobytes() + faces.tobytes())


def main() -> None:
    """Run one part and print its results as JSON."""
    parser = argparse.ArgumentParser(prog="python -m bench.bake_stages", description=__doc__)
    parser.add_argument("part", choices=("stages", "peak", "file"))
    parser.add_argument("source", help="a file, or the approximate number of faces of a generated mesh")
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--output", type=Path, help="where `file` writes")
    options = parser.parse_args()
    mesh = load(options.source)
    stated: dict[str, object] = {"name": mesh.name, "faces": len(mesh.faces)}
    if options.part == "stages":
        stated["seconds"] = stages(mesh, options.repeat)
    elif options.part == "peak":
        bake(mesh, BakeOptions(renderer="egl"))
    else:
        (write_stl if options.output.suffix == ".stl" else write_ply)(options.output, mesh)
    print(json.dumps(stated))


if __name__ == "__main__":
    main()
