"""The learned filter compared with the surface filter, in one run: ``python -m bench.learned [--mesh FILE]``."""

from __future__ import annotations

import nmaptool as nm
from bench.bake_stages import best, load
from bench.report import MeshReport
from bench.table import line, table
from bench.tasks import best_of_both
from nmaptool.filters.decompose import decompose_clean
from nmaptool.filters.descriptor import Describer
from nmaptool.meshes.clean import clean_mesh
from nmaptool.types.mesh import Mesh

SIZES = (20_000, 75_000, 300_000)
SURFACE = "surface filter, sigma_s 3, 5 passes"
DESCRIBE = "15 filtered normals per face"
LEARNED = "learned filter, 3 stages"
LEARNED_CPU = "learned filter, 3 stages, CPU"
_MOST_SECONDS, _LARGE = 25.0, 250_000
_MOST_TIMES = 15.0


def measure(mesh: Mesh, repeat: int) -> dict[str, float]:
    """Seconds of each filter."""
    learned = nm.FilterOptions(filter="learned")

    def describe() -> None:
        Describer(mesh, nm.DescriptorOptions())()

    wall, cpu = best_of_both(lambda: decompose_clean(mesh, learned), repeat)
    return {
        SURFACE: best(lambda: decompose_clean(mesh, nm.FilterOptions()), repeat),
        DESCRIBE: best(describe, repeat),
        LEARNED: wall,
        LEARNED_CPU: cpu,
    }


def main() -> None:
    """Measure, print the results and, with --write, store them."""
    report = MeshReport("learned", __doc__)
    options = report.begin()
    decompose_clean(clean_mesh(load("2000"))[0], nm.FilterOptions(filter="learned"))  # loads modules before timing
    meshes = [clean_mesh(load(source))[0] for source in options.mesh or map(str, SIZES)]
    measured = [measure(mesh, options.repeat) for mesh in meshes]
    rows = []
    for name in measured[0]:
        cells = [
            cell for seconds in measured for cell in (f"{seconds[name]:.2f}", f"{seconds[name] / seconds[SURFACE]:.1f}")
        ]
        rows.append([name, *cells])
    header = ["", *(cell for mesh in meshes for cell in (f"{len(mesh.faces) / 1000:,.0f}k faces s", "x"))]
    goals = []
    for mesh, seconds in zip(meshes, measured, strict=True):
        faces = f"{len(mesh.faces)} faces"
        goals.append(
            line(f"{DESCRIBE}, {faces}, against one filter", seconds[DESCRIBE] / seconds[SURFACE], _MOST_TIMES, "x")
        )
        if len(mesh.faces) >= _LARGE:
            goals.append(line(f"{LEARNED_CPU}, {faces}", seconds[LEARNED_CPU], _MOST_SECONDS, "s"))
    report.end(
        f"Seconds are the best of {options.repeat}, including set-up; `x` is the ratio to the surface filter.",
        table(header, rows),
        *goals,
    )


if __name__ == "__main__":
    main()
