"""One edit of maps in its own process, for `bench.compose`: ``python -m bench.compose_jobs JOB SIZE REPEAT``.

Prints JSON: best and worst seconds of the job, best seconds of copying its maps, peak memory in images.
"""

from __future__ import annotations

import json
import resource
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import nmaptool as nm
from nmaptool.composition.blend_vectors import blend_normals as blend_vectors
from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.vectors import unit

_PEAK = 1 if sys.platform == "darwin" else 1024


@dataclass(frozen=True)
class Prepared:
    """A prepared job: the function to run and its input maps."""

    job: Callable[[], object]
    maps: tuple[NDArray[Any], ...]


def normals_of(size: int, turn: float) -> Float32:
    """(size, size, 3) float32 unit normals of waves with ripples; each turn gives a different surface."""
    along = (np.arange(size, dtype=np.float32) / size) * np.float32(2 * np.pi)
    x, y = along[None, :], along[:, None]
    normals = np.empty((size, size, 3), np.float32)
    normals[..., 0] = 0.6 * np.sin(3 * x + turn) * np.cos(2 * y) + 0.2 * np.sin(40 * x + turn)
    normals[..., 1] = 0.6 * np.cos(4 * y - turn) * np.sin(2 * x) + 0.2 * np.cos(37 * y + turn)
    normals[..., 2] = 1
    return unit(normals)


def map_of(size: int, turn: float, cover: Mask | None = None) -> nm.NormalMap:
    """A map of `normals_of`, covered everywhere or as given by ``cover``."""
    normals, coverage = normals_of(size, turn), np.ones((size, size), np.float32)
    if cover is not None:
        coverage[...] = cover
        normals[~cover] = (0, 0, 1)
    return nm.NormalMap(normals, coverage, nm.Frame(size, size), name=f"map {turn:g}")


def disc_of(size: int) -> Mask:
    """(size, size) bool: a disc with a margin."""
    at = np.arange(size) - (size - 1) / 2
    inside: Mask = np.hypot(at[None, :], at[:, None]) < 0.48 * size
    return inside


def _blend(words: list[str], size: int) -> Prepared:
    if words[0] == "blend":
        base, detail = map_of(size, 0), map_of(size, 1)
        return Prepared(lambda: nm.blend(base, detail), (base.normals, detail.normals))
    first, second = normals_of(size, 0), normals_of(size, 1)
    strength = np.linspace(0, 1, size * size, dtype=np.float32).reshape(size, size) if words[2:] else 1.0
    return Prepared(lambda: blend_vectors(first, second, words[1], strength), (first, second))


def _paste(words: list[str], size: int) -> Prepared:
    ground, motif = map_of(size, 0), map_of(size // 2, 1, disc_of(size // 2))
    detail = {"feather": "24px", "mode": "rnm"} if "rnm" in words else {}
    layers = [nm.Layer(motif, nm.LayerOptions(rotate=float(words[1].split()[2]), **detail))]  # type: ignore[arg-type]
    return Prepared(lambda: nm.paste(ground, layers), (ground.normals, motif.normals))


def _transform(words: list[str], size: int) -> Prepared:
    options = {
        "turned by 30 degrees": nm.TransformOptions(rotate=30),
        "turned by 90 degrees": nm.TransformOptions(rotate=90),
        "resized to 3/4": nm.TransformOptions(resize=f"{size * 3 // 4}x{size * 3 // 4}"),
        "stretched to half its height": nm.TransformOptions(resize=f"{size}x{size // 2}"),
    }[words[1]]
    source = map_of(size, 0)
    return Prepared(lambda: nm.transform(source, options), (source.normals,))


def _stack(words: list[str], size: int) -> Prepared:
    ground, motif, detail = map_of(size, 0), map_of(size // 2, 1, disc_of(size // 2)), map_of(size // 2, 2)
    layers = [
        nm.Layer(ground),
        nm.Layer(motif, nm.LayerOptions(at="30%,30%", rotate=20, feather="12px")),
        nm.Layer(motif, nm.LayerOptions(at="70%,70%", scale="0.8", flip_h=True)),
        nm.Layer(detail, nm.LayerOptions(at="25%,75%", mode="rnm", strength=0.5)),
        nm.Layer(detail, nm.LayerOptions(at="75%,25%", mode="pd", rotate=90)),
    ]
    return Prepared(lambda: nm.compose(layers), tuple(layer.normal_map.normals for layer in layers))


def depths_of(size: int) -> Float32:
    """(size, size) float32 from 0 to 1: overlapping half ellipsoids on rolling ground."""
    along = np.arange(size, dtype=np.float32) / size
    x, y = along[None, :], along[:, None]
    heights = (0.05 * np.sin(9 * x) * np.cos(7 * y) + 0.1).astype(np.float32)
    for across, down, large, up in np.random.default_rng(3).random((30, 4)):
        radius = 0.04 + 0.12 * large
        rows, cols = (slice(max(int((at - radius) * size), 0), int((at + radius) * size) + 1) for at in (down, across))
        inside = 1 - ((x[:, cols] - across) ** 2 + (y[rows] - down) ** 2) / radius**2
        ball = np.where(inside > 0, 0.1 + 0.4 * up + radius * np.sqrt(np.maximum(inside, 0)), 0).astype(np.float32)
        np.maximum(heights[rows, cols], ball, out=heights[rows, cols])
    heights -= heights.min()
    heights /= heights.max()
    return heights


def _depth(words: list[str], size: int) -> Prepared:
    depths = depths_of(size)
    bits = {"8 bit": 8, "16 bit": 16, "float": 32}[words[1]]
    if bits < 32:
        depths *= 2**bits - 1
        depths = np.rint(depths).astype(np.uint8 if bits == 8 else np.uint16)
    image = nm.RasterImage(depths[..., None], ("Y",), bits=bits)
    return Prepared(lambda: nm.depth_to_normals(image), (image.pixels,))


def _split(words: list[str], size: int) -> Prepared:
    source = map_of(size // 4, 0)
    return Prepared(lambda: nm.split(source, nm.SplitOptions(sigma_s="8px")), (source.normals,))  # type: ignore[arg-type]


# jobs by the first word of their name, up to a comma
PREPARE: dict[str, Callable[[list[str], int], Prepared]] = {
    "blend": _blend,
    "blend vectors": _blend,
    "paste": _paste,
    "transform": _transform,
    "stack of 5 layers": _stack,
    "depth": _depth,
    "split": _split,
}


def _seconds(job: Callable[[], object]) -> float:
    start = time.perf_counter()
    result = job()
    taken = time.perf_counter() - start
    del result
    return taken


def _resident() -> int:
    """Bytes of memory in use by the process; the peak so far if the system does not report it."""
    status = Path("/proc/self/statm")
    if status.exists():
        return int(status.read_text(encoding="utf-8").split()[1]) * resource.getpagesize()
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * _PEAK


def peak_of(job: Callable[[], object]) -> int:
    """Largest growth of the process in bytes during the job, sampled every millisecond."""
    before, most = _resident(), 0
    done = threading.Event()

    def watch() -> None:
        nonlocal most
        while not done.wait(1e-3):
            most = max(most, _resident())

    watcher = threading.Thread(target=watch)
    watcher.start()
    result = job()
    done.set()
    watcher.join()
    most = max(most, _resident())
    del result
    return most - before


def main() -> None:
    name, size, repeat = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    words = name.split(", ")
    prepared = PREPARE[words[0]](words, size)
    small = PREPARE[words[0]](words, 64)
    small.job()  # keeps lazy imports out of the job
    peak = peak_of(prepared.job)
    jobs, copies = [], []
    for _ in range(repeat):
        copies.append(_seconds(lambda: [each.copy() for each in prepared.maps]))
        jobs.append(_seconds(prepared.job))
    images = peak / (size * size * 3 * 4)
    print(json.dumps({"seconds": min(jobs), "slowest": max(jobs), "copy": min(copies), "images": images}))


if __name__ == "__main__":
    main()
