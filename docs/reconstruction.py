"""The table of docs/decisions/0016-reconstruction.md: ``python docs/reconstruction.py [--figures FOLDER] [MESH ...]``.

Without meshes, the shipped ones. Both schemes are swept on each mesh's own base normals, as by ``nmap compare``.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import nmaptool as nm

SAMPLES = Path(__file__).parents[1] / "samples"
HEAD = "| mesh | scheme | normals off | vertices rms | Hausdorff | folded | volume | seconds |"


def rows(name: str, comparison: nm.Comparison) -> list[str]:
    """A row a contender."""
    share = 100 / comparison.diagonal_mm
    out = []
    for each in comparison.contenders.values():
        o = each.options
        said = f"{o.scheme}, {o.steps} x, closeness {o.closeness:g}"
        volume = "" if each.volume_share is None else f"{each.volume_share:+.2%}"
        cells = (
            f"{each.normal_mean_deg:.2f}",
            f"{each.rms_mm * share:.3f}%",
            f"{each.hausdorff_mm * share:.2f}%",
            str(each.folded),
            volume,
            f"{each.seconds:.1f}",
        )
        out.append(f"| {name} | {said} | {' | '.join(cells)} |")
    return out


def curves(name: str, comparison: nm.Comparison) -> list[str]:
    """The sweeps, a row a point."""
    share = 100 / comparison.diagonal_mm
    return [
        f"| {name} | {curve} | {p.steps} | {'' if p.closeness is None else f'{p.closeness:g}'} | {p.normal_deg:.2f} | "
        f"{p.rms_mm * share:.4f}% | {p.folded} |"
        for curve, points in comparison.curves.items()
        for p in points
    ]


def geometry(name: str, mesh: nm.Mesh) -> str:
    """What ``nmap bake --geometry updated`` changes in the base map of the front view."""
    from nmaptool.vectors import mean_angle_deg

    original, updated = (nm.bake(mesh, nm.BakeOptions(geometry=g)) for g in ("original", "updated"))
    both = (original.coverage == 1) & (updated.coverage == 1)
    either = (original.coverage > 0) | (updated.coverage > 0)
    one = (original.coverage > 0) ^ (updated.coverage > 0)
    turned = mean_angle_deg(original.base.normals[both], updated.base.normals[both])
    return f"{name}: base turned by {turned:.2f} degrees, outline moved on {one.sum() / either.sum():.2%} of the mesh"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("meshes", nargs="*", type=Path, default=sorted(SAMPLES.glob("*.ply")))
    parser.add_argument("--figures", type=Path, help="a folder for the figures")
    arguments = parser.parse_args()
    table, sweeps, verdicts = [], [], []
    for path in arguments.meshes:
        mesh = nm.read_mesh(path)
        comparison = nm.compare(mesh)
        if arguments.figures is not None:
            nm.write_comparison(comparison, arguments.figures / f"{path.stem}.png", overwrite=True)
        table += rows(path.stem, comparison)
        sweeps += curves(path.stem, comparison)
        verdicts += [f"- {path.stem}: the paper's claim {verdict.words}" for verdict in comparison.verdicts]
        verdicts.append(f"- {geometry(path.stem, mesh)}")
    print(HEAD, "| --- " * HEAD.count(" |") + "|", *table, "", *verdicts, "", sep="\n")
    print("| mesh | curve | steps | closeness | normals off | vertices rms | folded |", "| --- " * 7 + "|", sep="\n")
    print(*sweeps, sep="\n")


if __name__ == "__main__":
    main()
