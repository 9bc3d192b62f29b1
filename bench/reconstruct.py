"""Time to rebuild meshes to their base normals, as ratios in one run: ``python -m bench.reconstruct [--mesh FILE]``."""

from __future__ import annotations

import time

import nmaptool as nm
from bench.bake_stages import RING, best, load
from bench.report import MeshReport
from bench.table import line, table
from nmaptool.core.arrays import Float64
from nmaptool.filters.decompose import decompose_clean
from nmaptool.meshes.clean import clean_mesh
from nmaptool.reconstruction.smooth import target_normals
from nmaptool.types.mesh import Mesh

SIZES = (20_000, 75_000, 300_000)
SCHEMES = (("gsfg-gradient", 20), ("gsfg-shape", 20), ("gsfg", 20), ("poisson", 1), ("poisson", 20))
_MOST_SECONDS, _LARGE = 10.0, 250_000
SMOOTH, _MOST_SMOOTH = "smooth, default options, CPU", 6.0


def measure(mesh: Mesh, repeat: int) -> tuple[dict[str, float], dict[str, float]]:
    """Seconds of the ring filter and of each scheme; their normal deviations in degrees."""
    seconds = {"filter ring": best(lambda: decompose_clean(mesh, RING), repeat)}
    targets = target_normals(decompose_clean(mesh, nm.FilterOptions()), 0.0)
    degrees = {"filter ring": 0.0}
    for scheme, steps in SCHEMES:
        name = f"{scheme}, {steps} steps"
        options = nm.ReconstructOptions(scheme=scheme, steps=steps)
        kept: list[nm.Reconstruction] = []
        seconds[name] = best(lambda o=options, k=kept: k.append(nm.reconstruct(mesh, targets, o)), repeat)
        degrees[name] = kept[-1].report.normal_deviation_deg
    smoothed: list[nm.SmoothResult] = []
    seconds[SMOOTH] = best(lambda: smoothed.append(nm.smooth(mesh)), repeat, time.process_time)
    degrees[SMOOTH] = smoothed[-1].report.reconstruction.normal_deviation_deg
    return seconds, degrees


def main() -> None:
    """Measure, print the results and, with --write, store them."""
    report = MeshReport("reconstruct", __doc__)
    options = report.begin()
    nm.reconstruct(*_small())  # loads modules before timing
    meshes = [clean_mesh(load(source))[0] for source in options.mesh or map(str, SIZES)]
    measured = [measure(mesh, options.repeat) for mesh in meshes]
    rows = []
    for name in measured[0][0]:
        cells = []
        for seconds, degrees in measured:
            cells += [f"{seconds[name]:.2f}", f"{seconds[name] / seconds['filter ring']:.1f}", f"{degrees[name]:.2f}"]
        rows.append([name, *cells])
    header = ["", *(c for m in meshes for c in (f"{len(m.faces) / 1000:,.0f}k faces s", "x", "degrees"))]
    shape = f"{SCHEMES[0][0]}, {SCHEMES[0][1]} steps"
    goals = [
        line(f"{name}, {len(mesh.faces)} faces", seconds[name], most, "s")
        for mesh, (seconds, _) in zip(meshes, measured, strict=True)
        if len(mesh.faces) >= _LARGE
        for name, most in ((shape, _MOST_SECONDS), (SMOOTH, _MOST_SMOOTH))
    ]
    report.end(
        (
            f"Meshes rebuilt to their base normals (surface, sigma_s 3). Seconds are the best of {options.repeat}, "
            "including set-up; `x` is the ratio to\nthe five passes of the ring filter; degrees are the remaining "
            "deviation of the normals, averaged over the surface."
        ),
        table(header, rows),
        *goals,
    )


def _small() -> tuple[Mesh, Float64, nm.ReconstructOptions]:
    mesh = clean_mesh(load("60000"))[0]
    return mesh, mesh.geometry.normals, nm.ReconstructOptions(steps=1)


if __name__ == "__main__":
    main()
