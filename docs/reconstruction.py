"""The table of docs/decisions/0016-reconstruction.md: ``python docs/reconstruction.py [--figures FOLDER] [MESH ...]``.

Without arguments it uses the sample meshes. It sweeps both schemes on each mesh's base normals, like ``nmap compare``,
compares other settings with the default, and rebuilds a noisy sphere to its true normals.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import nmaptool as nm

SAMPLES = Path(__file__).parents[1] / "samples"
HEAD = "| mesh | scheme | normals off | vertices rms | Hausdorff | folded | volume | seconds |"


def rows(name: str, comparison: nm.Comparison) -> list[str]:
    """One row per contender."""
    share = 100 / comparison.diagonal_mm
    out = []
    for each in comparison.contenders.values():
        o = each.options
        stated = f"{o.scheme}, {o.steps} x, closeness {o.closeness:g}"
        volume = "" if each.volume_share is None else f"{each.volume_share:+.2%}"
        cells = (
            f"{each.normal_mean_deg:.2f}",
            f"{each.rms_mm * share:.3f}%",
            f"{each.hausdorff_mm * share:.2f}%",
            str(each.folded),
            volume,
            f"{each.seconds:.1f}",
        )
        out.append(f"| {name} | {stated} | {' | '.join(cells)} |")
    return out


def curves(name: str, comparison: nm.Comparison) -> list[str]:
    """The sweeps, one row per point."""
    share = 100 / comparison.diagonal_mm
    return [
        f"| {name} | {curve} | {p.steps} | {'' if p.closeness is None else f'{p.closeness:g}'} | {p.normal_deg:.2f} | "
        f"{p.rms_mm * share:.4f}% | {p.folded} |"
        for curve, points in comparison.curves.items()
        for p in points
    ]


def geometry(name: str, mesh: nm.Mesh) -> str:
    """Changes by ``nmap bake --geometry updated`` in the base map of the front view."""
    from nmaptool.core.vectors import mean_angle_deg

    original, updated = (nm.bake(mesh, nm.BakeOptions(geometry=g)) for g in ("original", "updated"))
    both = (original.coverage == 1) & (updated.coverage == 1)
    either = (original.coverage > 0) | (updated.coverage > 0)
    one = (original.coverage > 0) ^ (updated.coverage > 0)
    turned = mean_angle_deg(original.base.normals[both], updated.base.normals[both])
    return f"{name}: base turned by {turned:.2f} degrees, outline moved on {one.sum() / either.sum():.2%} of the mesh"


TRIALS = (
    ({}, 0.0),
    ({}, 2.0),
    ({"steps": 40}, 0.0),
    ({"scheme": "gsfg-shape"}, 0.0),
    ({"closeness": 1e-4}, 0.0),
    ({"closeness": 1e-4}, 2.0),
)
SPHERE = (("gsfg-gradient", 20), ("gsfg", 20), ("gsfg", 100), ("poisson", 1), ("poisson", 20))


def trials(name: str, mesh: nm.Mesh) -> list[str]:
    """Results of other settings and of the default ones."""
    clean = nm.clean_mesh(mesh)[0]
    split = nm.decompose_normals(clean)
    out = []
    for changes, gain in TRIALS:
        options = nm.ReconstructOptions(**changes)
        targets = split.base + gain * split.residual
        targets /= np.linalg.norm(targets, axis=1, keepdims=True)
        report = nm.reconstruct(clean, targets, options).report
        volume = "open" if report.volume_share is None else f"{report.volume_share:+.2%}"
        stated = f"{options.scheme}, {options.steps} x, closeness {options.closeness:g}, gain {gain:g}"
        angle = f"{report.normal_deviation_deg:.3f}"
        out.append(f"| {name} | {stated} | {angle} | {report.folded_before} | {report.folded_after} | {volume} |")
    return out


def sphere() -> list[str]:
    """Remaining share of the noise on a sphere rebuilt to its true normals (root mean squares)."""
    import trimesh

    ball = trimesh.creation.icosphere(5)
    true = nm.Mesh(np.array(ball.vertices, np.float64), np.array(ball.faces, np.int32))
    out = []
    for noise in (0.1, 0.3):
        shift = np.random.default_rng(0).normal(0, noise * true.mean_edge, len(true.vertices))
        rough = nm.Mesh(true.vertices * (1 + shift[:, None]), true.faces)
        for scheme, steps in SPHERE:
            done = nm.reconstruct(rough, true.geometry.normals, nm.ReconstructOptions(scheme=scheme, steps=steps))
            left = np.linalg.norm(done.mesh.vertices, axis=1)
            share = np.sqrt(((left - left.mean()) ** 2).mean() / (shift**2).mean())
            out.append(
                f"| sphere, noise {noise:g} edges | {scheme}, {steps} x | {share:.3f} | {left.mean() - 1:+.2%} |"
            )
    return out


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("meshes", nargs="*", type=Path, default=sorted(SAMPLES.glob("*.ply")))
    parser.add_argument("--figures", type=Path, help="a folder for the figures")
    arguments = parser.parse_args()
    table, sweeps, verdicts, tried = [], [], [], []
    for path in arguments.meshes:
        mesh = nm.read_mesh(path)
        comparison = nm.compare(mesh)
        if arguments.figures is not None:
            nm.write_comparison(comparison, arguments.figures / f"{path.stem}.png", overwrite=True)
        table += rows(path.stem, comparison)
        sweeps += curves(path.stem, comparison)
        verdicts += [f"- {path.stem}: the paper's claim {verdict.summary}" for verdict in comparison.verdicts]
        verdicts.append(f"- {geometry(path.stem, mesh)}")
        tried += trials(path.stem, mesh)
    print(HEAD, "| --- " * HEAD.count(" |") + "|", *table, "", *verdicts, "", sep="\n")
    print("| mesh | curve | steps | closeness | normals off | vertices rms | folded |", "| --- " * 7 + "|", sep="\n")
    print(*sweeps, "", sep="\n")
    print(
        "| mesh | setting | normals off | folded before | folded | volume |", "| --- " * 6 + "|", *tried, "", sep="\n"
    )
    print("| mesh | setting | noise left | radius |", "| --- " * 4 + "|", *sphere(), sep="\n")


if __name__ == "__main__":
    main()
