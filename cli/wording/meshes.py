"""Messages about rebuilding, comparing and training on meshes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from nmaptool.types.shown import counted
from nmaptool_cli.wording.layers import describe_findings

if TYPE_CHECKING:
    from nmaptool import Comparison, FilterModel, Mesh, ReconstructReport, SmoothResult, TrainingExample
    from nmaptool_cli.run import Run


def describe_smoothing(run: Run, source: Mesh, result: SmoothResult) -> None:
    """How a mesh was smoothed or exaggerated, with warnings."""
    report = result.report
    run.say(describe_findings(source, report.findings))
    run.say(*describe_reconstruction(report.reconstruction, report.detail_gain))
    run.warn(*(f"{source.name}: {warning}" for warning in report.warnings))
    moves = " ".join(f"{move:.1e}" for move in report.reconstruction.moves)
    run.detail(f"  rms move per step, in mean edge lengths: {moves}")
    run.seconds(report.seconds)


def describe_notes(run: Run, source: Mesh) -> None:
    """What was ignored or assumed when a mesh was read, for commands whose reports do not say it."""
    run.warn(*(f"{source.name}: {note}" for note in source.notes))


def describe_reconstruction(report: ReconstructReport, gain: float) -> Iterator[str]:
    """How a mesh was rebuilt, one line each."""
    o, size = report.options, report.diagonal_mm or 1.0
    pull = "" if o.scheme == "gsfg" else f", closeness {o.closeness:g}"
    yield f"  detail gain {gain:g}, scheme {o.scheme}: {counted(o.steps, 'step')}{pull}, {report.seconds:.2f} s"
    folded = ""
    if report.folded_before or report.folded_after:
        folded = f"; {counted(report.folded_before, 'folded face')} before, {report.folded_after} after"
    yield (
        f"  normals {report.normal_deviation_before_deg:.2f} degrees from their targets before, "
        f"{report.normal_deviation_deg:.2f} after{folded}"
    )
    yield (
        f"  vertices moved {report.moved_rms_mm:.3g} mm (rms, {report.moved_rms_mm / size:.3%} of the diagonal), "
        f"{report.moved_max_mm:.3g} mm at most{_volume(report)}"
    )
    if report.boundary_vertices:
        what = "held" if o.boundary == "hold" else "free"
        yield f"  {counted(report.boundary_vertices, 'vertex')} on open edges, {what}"


def _volume(report: ReconstructReport) -> str:
    if report.volume_share is not None:
        return f"; volume {report.volume_share:+.3%}"
    if report.mean_offset_mm is not None:
        return f"; surface {report.mean_offset_mm:+.2g} mm outwards on average"
    return ""


def describe_comparison(comparison: Comparison) -> Iterator[str]:
    """Two schemes, one line each, and the verdict."""
    before = f"normals {comparison.normal_before_deg:.2f} degrees from the base"
    yield f"{comparison.name}: {counted(comparison.faces, 'face')}, {before}"
    for each in comparison.contenders.values():
        o, share = each.options, 100 / comparison.diagonal_mm
        pull = "" if o.scheme == "gsfg" else f", closeness {o.closeness:g}"
        yield (
            f"  {o.scheme}, {counted(o.steps, 'step')}{pull}: normals {each.normal_mean_deg:.3f} degrees off, vertices "
            f"rms {each.rms_mm:.4g} mm ({each.rms_mm * share:.3f}%), largest {each.max_mm:.4g} mm, Hausdorff "
            f"{each.hausdorff_mm:.4g} mm ({each.hausdorff_mm * share:.3f}%)"
        )
    for verdict in comparison.verdicts:
        yield f"  the paper's claim {verdict.summary}"


def describe_curves(comparison: Comparison) -> Iterator[str]:
    """The sweeps, one line per point."""
    for name, points in comparison.curves.items():
        for p in points:
            pull = "" if p.closeness is None else f", closeness {p.closeness:g}"
            steps = f"{counted(p.steps, 'step')}{pull}"
            yield f"  {name}: {steps}: {p.normal_deg:.3f} degrees, {p.rms_mm:.4g} mm, {p.folded} folded"


def describe_training(run: Run, examples: Sequence[TrainingExample], model: FilterModel) -> None:
    """A filter that was trained, one line each."""
    faces = sum(len(example.mesh.faces) for example in examples)
    meshes = f"{len(examples)} {'mesh' if len(examples) == 1 else 'meshes'}"
    run.say(f"trained on {meshes}, {counted(faces, 'face')}: filter {model.digest}")
    before, *after = model.metadata["mean_angle_deg"]
    stages = ", ".join(f"{angle:.2f}" for angle in after)
    run.say(f"  mean angle to the targets: {before:.2f} degrees before, {stages} after each stage")
    run.detail(f"  loss of each network: {' '.join(f'{loss:.2e}' for loss in model.metadata['losses'])}")
