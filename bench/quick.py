"""The figures that matter most, with their rivals, in less than two minutes: ``python -m bench.quick``.

Heavy imports are inside the functions: a child inherits the peak memory that its parent had when it started.
"""

from __future__ import annotations

import importlib.util
import os
import sys
import tempfile
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING

from bench.checks import MEANING, line
from bench.relief import MOST_BYTES, Job, make_maps, run, run_command
from bench.report import Report

if TYPE_CHECKING:
    from bench.runs import Outcome

_TOLERANCE = 1e-6
_FACES = "75000"
_LIMIT, _SPEND = 60.0, 1.0


def _total(outcome: Outcome) -> float | None:
    return outcome.total(0)


def _peak(outcome: Outcome) -> int | None:
    return None if not outcome.answers or outcome.answers[0] is None else outcome.answers[0].peak


def solves() -> list[str]:
    """The linear systems: multigrid beside pyamg and PARDISO, the cosine transform beside SciPy's transforms."""
    from bench.runs import Job as Solve
    from bench.runs import measure
    from bench.systems import Case
    from bench.tasks import transforms

    motif, full = Case(900, 1000), Case(900, 1000, "full")
    names = ("multigrid", "aggregation", "pardiso")
    ours, pyamg, pardiso = measure([Solve(motif, name, (_TOLERANCE,)) for name in names], 3 * _LIMIT, _SPEND)
    (cosine,) = measure([Solve(full, "dct", (_TOLERANCE,))], _LIMIT, _SPEND)
    what = "solve of a motif, 1000x900 px, to 1e-6"
    lines = [line(what, _total(ours), 0.12, "s", rival=("pyamg", _total(pyamg)), peak=_peak(ours))]
    if _total(pardiso) is not None:
        lines.append(line(f"{what}, beside PARDISO", _total(ours), None, "s", rival=("PARDISO", _total(pardiso))))
    both = ("SciPy's transforms", transforms(full.rows, full.cols, 20))
    lines.append(line("solve of a full frame, 1000x900 px", _total(cosine), None, "s", rival=both, peak=_peak(cosine)))
    return lines


def meshes() -> list[str]:
    """The surface filter, and smoothing beside MeshLab."""
    import nmaptool as nm
    from bench.bake_stages import load
    from bench.tasks import best_of_both, meshlab_smooth
    from nmaptool.filters.decompose import decompose_clean
    from nmaptool.meshes.clean import clean_mesh

    mesh = clean_mesh(load(_FACES))[0]
    filtered = best_of_both(lambda: decompose_clean(mesh, nm.FilterOptions()), 3)[1]
    lines = [line("surface filter, 75k faces, CPU", filtered, None, "s")]  # no library has one
    smoothed = best_of_both(lambda: nm.smooth(mesh), 2)[1]
    rival = ("MeshLab's two-step smoothing", meshlab_smooth(mesh, 3))
    lines.append(line("smooth, 75k faces, CPU", smoothed, None, "s", rival=rival))
    return lines


def sliders(side: int = 512) -> list[str]:
    """Moves of sliders beside a relief from the start."""
    import nmaptool as nm
    from bench import session

    measured = session.measure(session.maps_of("statue", side), nm.ReliefOptions(background="cut"))
    first = ("the first relief", measured.seconds["first"][0])
    lines = []
    for slider in ("mu", "beta", "delta", "height"):
        most = session.most_seconds(slider, side)
        found = median(measured.seconds[slider])
        lines.append(line(f"new {slider}, {side} px", found, most, "s", rival=first))
    lines.append(line(f"error of previews, {side} px, of the range", measured.error, session.MOST_ERROR, ""))
    return lines


def commands(folder: Path) -> list[str]:
    """Starts of the command beside a bare interpreter, and one relief."""
    bare = min(run_command([sys.executable, "-I", "-c", "pass"], 5).cpu_seconds)
    lines = []
    for words, most in (("--help", 0.25), ("relief --help", 0.35)):
        runs = run(Job(words, tuple(words.split()), 5))
        lines.append(
            line(f"nmap {words}, CPU", min(runs.cpu_seconds), most, "s", rival=("python -c pass", bare), peak=runs.peak)
        )
    words = ("relief", str(folder / "motif.png"), "-o", str(folder / "motif.exr"), "--overwrite", "--quiet")
    runs = run(Job("relief", words, 3))
    lines.append(line("nmap relief of a motif to EXR, CPU", min(runs.cpu_seconds), 1.0, "s", peak=runs.peak))
    lines.append(line("nmap relief of a motif to EXR, peak", runs.peak / 1e9, MOST_BYTES / 1e9, "GB"))
    return lines


def files(folder: Path) -> list[str]:
    """Reading a map and a mesh, and writing a relief."""
    import cv2

    import nmaptool as nm
    from bench.bake_stages import load, write_ply
    from bench.tasks import best_of_both, file_copy

    picture, scan, solid = folder / "full.png", folder / "scan.ply", folder / "relief.stl"
    decoded = ("OpenCV, decoding alone", best_of_both(lambda: cv2.imread(str(picture), cv2.IMREAD_UNCHANGED), 5)[1])
    options = nm.ReadOptions(background_color="none")
    read = best_of_both(lambda: nm.read_normal_map(picture, options), 3)[1]
    lines = [line("reading a map, 1000x900 px, 16-bit PNG, CPU", read, None, "s", rival=decoded)]
    write_ply(scan, load(_FACES))
    plain = ("a plain copy of the file", file_copy(scan, 20))
    read = best_of_both(lambda: nm.read_mesh(scan), 3)[1]
    lines.append(line("reading a mesh, 75k faces, PLY, CPU", read, None, "s", rival=plain))
    relief = nm.relief(nm.read_normal_map(picture, options))
    written = best_of_both(lambda: nm.write_relief(relief, solid, overwrite=True), 3)[1]
    plain = ("a plain copy of the file", file_copy(solid, 5))
    lines.append(line("writing a relief, 1000x900 px, STL, CPU", written, None, "s", rival=plain))
    return lines


def main() -> None:
    """Measure, print the results and, with --write, store them."""
    report = Report("quick", __doc__)
    report.begin()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command does
    lines: list[str] = []

    def add(found: list[str]) -> None:
        print("\n".join(found), flush=True)
        lines.extend(found)

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        make_maps("1000x900", folder / "motif.png", folder / "thin.png", folder / "full.png")
        add(commands(folder))
        add(solves())
        add(meshes())
        add(sliders())
        add(files(folder))
    absent = [name for name in ("pypardiso", "pymeshlab") if importlib.util.find_spec(name) is None]
    preface = (
        f"Seconds are the best of several runs; the peak is that of the process, of a solve what it adds. {MEANING}"
    )
    missing = [f"Not installed here: {', '.join(absent)}."] if absent else []
    print("\n".join((report.surroundings(), *missing)))
    report.write("\n\n".join([report.surroundings(), preface, *missing, "\n".join(lines)]))


if __name__ == "__main__":
    main()
