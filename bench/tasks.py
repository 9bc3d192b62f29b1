"""Rivals of whole tasks: what other programs, or a plain copy, take for the same or for the least possible work."""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy import fft

from nmaptool.types.mesh import Mesh


def best_of_both(job: Callable[[], object], repeat: int) -> tuple[float, float]:
    """Shortest wall time and shortest CPU time of the same runs, in seconds."""
    walls, cpus = [], []
    for _ in range(repeat):
        wall, cpu = time.perf_counter(), time.process_time()
        job()
        walls.append(time.perf_counter() - wall)
        cpus.append(time.process_time() - cpu)
    return min(walls), min(cpus)


def transforms(rows: int, cols: int, repeat: int) -> float:
    """Seconds of SciPy's cosine transform of the corners of a picture and back, in float32, on all cores."""
    values = np.random.default_rng(0).standard_normal((rows + 1, cols + 1), np.float32)

    def there_and_back() -> None:
        fft.idctn(fft.dctn(values, type=1, workers=-1), type=1, workers=-1, overwrite_x=True)

    return best_of_both(there_and_back, repeat)[0]


def file_copy(path: Path, repeat: int) -> float:
    """CPU seconds of writing the bytes of a file to another."""
    held, other = path.read_bytes(), path.with_suffix(".copy")
    try:
        return best_of_both(lambda: other.write_bytes(held), repeat)[1]
    finally:
        other.unlink()


def meshlab_smooth(mesh: Mesh, repeat: int) -> float | None:
    """CPU seconds of MeshLab's two-step smoothing of normals, then vertices; None if pymeshlab is not installed."""
    if importlib.util.find_spec("pymeshlab") is None:
        return None
    import pymeshlab

    def smooth() -> None:
        meshes = pymeshlab.MeshSet()
        meshes.add_mesh(pymeshlab.Mesh(mesh.vertices, mesh.faces))
        meshes.apply_coord_two_steps_smoothing()

    return best_of_both(smooth, repeat)[1]
