"""The results of rebuilding and smoothing a mesh: the mesh and a report."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.options import FilterOptions, ReconstructOptions
from nmaptool.options.plain_values import filter_values
from nmaptool.types.mesh import Mesh
from nmaptool.types.mesh_findings import MeshFindings
from nmaptool.types.mixture import Mixture
from nmaptool.types.report import Report
from nmaptool.types.shown import OneLine


@dataclass(frozen=True, repr=False)
class ReconstructReport(Report):
    """How a mesh was rebuilt.

    Attributes
    ----------
    options : ReconstructOptions
        The options given, including the scheme and the steps.
    vertices, faces : int
    boundary_vertices : int
        Vertices on open edges.
    normal_deviation_before_deg, normal_deviation_deg : float
        Mean angle between face normals and their targets, before and after, weighted by the areas of the given mesh.
    normal_deviation_p95_deg : float
        Angle that 95 % of the faces stay below, after.
    folded_before, folded_after : int
        Faces whose normal is more than a right angle from its target.
    moved_rms_mm, moved_max_mm : float
        Root mean square and maximum of the distances that vertices moved.
    diagonal_mm : float
        Diagonal of the given mesh's bounding box, for comparison with these distances.
    volume_share : float or None
        Volume gained by a closed mesh, as a share of its volume; None for an open mesh.
    volume_change_mm3 : float or None
        Volume gained by the mesh. For an open mesh with a held boundary, the volume between the two surfaces; None if
        the boundary moved.
    mean_offset_mm : float or None
        The volume gained divided by the area: the mean outward offset of the surface.
    moves : tuple of float
        Root mean square of the vertices' moves in each step, in mean edge lengths.
    seconds : float
    """

    options: ReconstructOptions
    vertices: int
    faces: int
    boundary_vertices: int
    normal_deviation_before_deg: float
    normal_deviation_deg: float
    normal_deviation_p95_deg: float
    folded_before: int
    folded_after: int
    moved_rms_mm: float
    moved_max_mm: float
    diagonal_mm: float
    volume_share: float | None
    volume_change_mm3: float | None
    mean_offset_mm: float | None
    moves: tuple[float, ...]
    seconds: float


@dataclass(frozen=True, eq=False, repr=False)
class Reconstruction(OneLine):
    """A mesh rebuilt to match given normals.

    Attributes
    ----------
    mesh : Mesh
        The rebuilt mesh; faces and their order are unchanged.
    report : ReconstructReport
    """

    mesh: Mesh
    report: ReconstructReport

    @property
    def vertices(self) -> NDArray[np.float64]:
        """(N, 3) float64 in units of the mesh."""
        return self.mesh.vertices

    def _line(self) -> str:
        return f"{self.mesh._line()}, moved by {self.report.moved_rms_mm:.3g} mm rms"


@dataclass(frozen=True, repr=False)
class SmoothReport(Report):
    """How a mesh was smoothed or exaggerated.

    Attributes
    ----------
    detail_gain : float
    filter : FilterOptions
    findings : MeshFindings
        What cleaning the mesh changed before.
    mixture : Mixture
        Residuals of the filter, and the threshold found in them.
    reconstruction : ReconstructReport
    seconds : mapping of str to float
        Time by stage: ``clean``, ``filter``, ``rebuild``.
    warnings : tuple of str
    """

    detail_gain: float
    filter: FilterOptions
    findings: MeshFindings
    mixture: Mixture
    reconstruction: ReconstructReport
    seconds: Mapping[str, float] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return {
            "detail_gain": self.detail_gain,
            "filter": filter_values(self.filter),
            "findings": dataclasses.asdict(self.findings),
            "mixture": self.mixture.to_dict(),
            "reconstruction": self.reconstruction.to_dict(),
            "seconds": dict(self.seconds),
            "warnings": list(self.warnings),
        }


@dataclass(frozen=True, eq=False, repr=False)
class SmoothResult(OneLine):
    """A mesh with less or more of its detail.

    Attributes
    ----------
    mesh : Mesh
        The cleaned and smoothed mesh, in the units of the given mesh.
    source_faces : (M,) int64
        Index in the given mesh of each face; the order is kept.
    report : SmoothReport
    """

    mesh: Mesh
    source_faces: NDArray[np.int64]
    report: SmoothReport

    def _line(self) -> str:
        moved = self.report.reconstruction.moved_rms_mm
        return f"{self.mesh._line()}, detail gain {self.report.detail_gain:g}, moved by {moved:.3g} mm rms"
