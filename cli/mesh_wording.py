"""Reports on rebuilt meshes as sentences for a designer."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from nmaptool import ReconstructReport


def describe_reconstruction(report: ReconstructReport, gain: float) -> Iterator[str]:
    """How a mesh was rebuilt, a line each."""
    o, size = report.options, report.diagonal_mm or 1.0
    pull = "" if o.scheme == "gsfg" else f", closeness {o.closeness:g}"
    yield f"  detail times {gain:g}, by {o.scheme}: {o.steps} steps{pull}, {report.seconds:.2f} s"
    folded = ""
    if report.folded_before or report.folded_after:
        folded = f"; faces folded over {report.folded_before} before, {report.folded_after} after"
    yield (
        f"  normals {report.normal_deviation_before_deg:.2f} degrees from what they should be before, "
        f"{report.normal_deviation_deg:.2f} after{folded}"
    )
    yield (
        f"  vertices moved {report.moved_rms_mm:.3g} mm (rms, {report.moved_rms_mm / size:.3%} of the diagonal), "
        f"{report.moved_max_mm:.3g} mm at most{_volume(report)}"
    )
    if report.boundary_vertices:
        what = "held" if o.boundary == "hold" else "free"
        yield f"  {report.boundary_vertices} vertices on open edges, {what}"


def _volume(report: ReconstructReport) -> str:
    if report.volume_share is not None:
        return f"; volume {report.volume_share:+.3%}"
    if report.mean_offset_mm is not None:
        return f"; surface {report.mean_offset_mm:+.2g} mm outwards on average"
    return ""
