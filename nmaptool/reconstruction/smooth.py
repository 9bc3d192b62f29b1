"""Reduce or exaggerate the detail of a mesh: split its normals, mix them again, and rebuild the mesh to them."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float64
from nmaptool.core.progress import Progress, Stages, part
from nmaptool.filters.learned.model import FilterModel
from nmaptool.filters.prepared import prepare_mesh
from nmaptool.filters.rolling import Decomposition
from nmaptool.options import FilterOptions, ReconstructOptions, SmoothOptions
from nmaptool.reconstruction.reconstruct import reconstruct
from nmaptool.types.mesh import Mesh
from nmaptool.types.mesh_findings import MeshFindings
from nmaptool.types.reconstruction import ReconstructReport, SmoothReport, SmoothResult
from nmaptool.types.shown import counted

# share of folded faces above which there is a warning
_FEW_FOLDED = 0.001
# share of the volume; a larger change gives a warning
_DRIFT = 0.02


def smooth(
    mesh: Mesh,
    options: SmoothOptions | None = None,
    filter: FilterOptions | None = None,
    reconstruct_options: ReconstructOptions | None = None,
    *,
    model: FilterModel | None = None,
    progress: Progress | None = None,
) -> SmoothResult:
    """Smooth or exaggerate a mesh: rebuild it to the normals unit(N_B + gain N_D) (paper, Sec. 3 and 4.1).

    The mesh is cleaned as by `clean_mesh`, `decompose_normals` splits its face normals into base and detail, and
    `reconstruct` moves its vertices until the faces have the mixed normals.

    Parameters
    ----------
    mesh : Mesh
        Need not be clean: unusable faces are dropped and reported, and vertices at the same position are welded.
    options : SmoothOptions, optional
        Detail gain: 0 removes the detail, 1 keeps it, more exaggerates it.
    filter : FilterOptions, optional
        What counts as detail.
    reconstruct_options : ReconstructOptions, optional
        Scheme, steps and closeness.
    model : FilterModel, optional
        Model for the filter ``learned``. Default: the one that comes with the package.
    progress : callable, optional
        Called with the stage, "filtering" up to 0.5 and "rebuilding" from there, and the share done, 0 to 1.

    Returns
    -------
    SmoothResult
        The mesh, the source of each face, and the report.

    Raises
    ------
    InputError, UsageError
        As for `decompose_normals`.
    ConvergenceError
        If the system of scheme "poisson" cannot be solved.

    Examples
    --------
    >>> import trimesh
    >>> box = nm.Mesh.from_trimesh(trimesh.creation.box().subdivide().subdivide())
    >>> nm.smooth(box, nm.SmoothOptions(detail_gain=2)).mesh
    <Mesh mesh: 98 vertices, 192 faces, 1 mm per unit (assumed)>
    """
    options = options or SmoothOptions()
    stages = Stages()
    with stages.stage("clean"):
        prepared = prepare_mesh(mesh, filter, model)
    with stages.stage("filter"):
        split = prepared.decompose(part(progress, 0.0, 0.5))
    with stages.stage("rebuild"):
        targets = target_normals(split, options.detail_gain)
        rebuilt = reconstruct(prepared.mesh, targets, reconstruct_options, progress=part(progress, 0.5, 1.0))
    report = SmoothReport(
        detail_gain=options.detail_gain,
        filter=prepared.filter,
        findings=prepared.findings,
        mixture=split.mixture,
        reconstruction=rebuilt.report,
        seconds=stages.seconds(),
        warnings=(*_dropped(prepared.findings), *prepared.warnings, *_warnings(rebuilt.report)),
    )
    return SmoothResult(rebuilt.mesh, prepared.source_faces, report)


def target_normals(split: Decomposition, gain: float) -> Float64:
    """Return unit(N_B + gain N_D) as (M, 3) float64; the base where the two cancel out."""
    out = split.base + gain * split.residual
    length = np.sqrt(np.einsum("ij,ij->i", out, out))
    lost = ~(length > 1e-6)
    out[lost] = split.base[lost]
    length[lost] = np.sqrt(np.einsum("ij,ij->i", split.base[lost], split.base[lost]))
    return np.asarray(out / length[:, None])


def _dropped(findings: MeshFindings) -> tuple[str, ...]:
    count = findings.degenerate_faces + findings.nonfinite_faces + findings.repeated_faces
    return (f"dropped {counted(count, 'face')} (without area, with NaN, or duplicate)",) if count else ()


def _warnings(report: ReconstructReport) -> tuple[str, ...]:
    found = []
    if report.folded_after > _FEW_FOLDED * report.faces:
        found.append(
            f"folded faces in the result: {report.folded_after} of {report.faces}; use a smaller `sigma_s`, a "
            "`detail_gain` closer to 1 or a larger `closeness`"
        )
    if report.volume_share is not None and abs(report.volume_share) > _DRIFT:
        found.append(f"the volume changed by {report.volume_share:+.1%}; a larger `closeness` preserves it")
    return tuple(found)
