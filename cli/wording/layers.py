"""Messages about base and detail: how they were split and rendered."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from nmaptool import LayerReport, LayerSet, Mesh, MeshFindings
    from nmaptool_cli.run import Run


def describe_layers(run: Run, source: Mesh, layer_sets: Sequence[LayerSet]) -> None:
    """How a mesh was read, split and rendered, with warnings."""
    first = layer_sets[0].report
    assert first.findings is not None  # every rendering has them
    run.say(describe_findings(source, first.findings), *describe_split(first))
    run.say(*(describe_view(layers) for layers in layer_sets))
    warnings = dict.fromkeys(warning for layers in layer_sets for warning in layers.report.warnings)
    run.warn(*(f"{source.name}: {warning}" for warning in warnings))
    run.seconds(first.seconds)


def describe_findings(mesh: Mesh, found: MeshFindings) -> str:
    """A mesh as it was read and cleaned, in one line."""
    return f"{mesh.name}: {found.summary()}"


def describe_split(report: LayerReport) -> Iterator[str]:
    """How base and detail were separated."""
    yield f"  {_describe_filter(report)}"
    m = report.mixture
    if report.curl:
        yield f"  mean |curl| {', '.join(f'{name} {size:.4f}' for name, size in report.curl.items())} slope per px"
    if m.form == "none":
        yield "  no detail finer than that: the filter changes every normal by less than half a degree"
        return
    whole = "the surface" if report.faces else "the picture"
    threshold = f"theta {m.theta:.4f} ({m.form}{'' if m.form == 'midpoint' else ' crossing'})"
    yield (
        f"  residuals: base {m.low.mean:.4f} +- {m.low.sigma:.4f} ({m.low.weight:.0%}), detail {m.high.mean:.4f} +- "
        f"{m.high.sigma:.4f} ({m.high.weight:.0%}); {threshold}; {report.detail_share:.0%} of {whole} above it"
    )


def _describe_filter(report: LayerReport) -> str:
    o = report.options
    if report.model:
        return f"learned filter {report.model}"
    where = f", {o['neighborhood']}" if "neighborhood" in o else ""
    size = str(o["sigma_s"]) if isinstance(o["sigma_s"], str) else f"{o['sigma_s']:g} edges"
    return (
        f"{o['filter']}{where}: sigma_s {size} = {report.sigma_s_px:.1f} px, sigma_r {o['sigma_r']:g}, "
        f"{o['iterations']} passes"
    )


def describe_view(layers: LayerSet) -> str:
    """One view, in one line."""
    report, frame = layers.report, layers.frame
    pitch = frame.pitch_mm or 0.0
    size = f"{frame.cols * pitch:.4g} x {frame.rows * pitch:.4g} mm"
    unit = {"assumed": "units taken as mm", "file": "units of the file", "given": "as given"}[report.pitch_from]
    angles = {name: report.options[name] for name in ("azimuth", "elevation", "roll")}
    turned = [f" {name} {value:g}" for name, value in angles.items() if value is not None and (value or name != "roll")]
    covered = float((layers.coverage > 0).mean())
    return (
        f"  {report.view}{''.join(turned)}: {frame}, {size} ({unit}), mesh covers {covered:.0%}, rendered by "
        f"{report.renderer}"
    )
