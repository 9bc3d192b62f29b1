"""What rebuilding a mesh returns: the mesh, and the account of how it came about."""

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
        As given; the scheme and the steps among them.
    vertices, faces : int
    boundary_vertices : int
        On open edges.
    normal_deviation_before_deg, normal_deviation_deg : float
        Angle between face normals and their targets, mean over the area of the mesh that was given.
    normal_deviation_p95_deg : float
        The angle that 95 of 100 faces stay below, after.
    folded_before, folded_after : int
        Faces whose normal is more than a right angle from its target.
    moved_rms_mm, moved_max_mm : float
        How far vertices went.
    diagonal_mm : float
        Of the given mesh's bounding box, to judge them by.
    volume_share : float or None
        What a closed mesh gained, as a share of its volume; None of an open one.
    volume_change_mm3 : float or None
        What the mesh gained: of an open one with a held boundary, what lies between the surfaces; None where the
        boundary moved.
    mean_offset_mm : float or None
        That over the area: how far the surface went outwards on average.
    moves : tuple of float
        Root mean square of the vertices' moves in each step, in mean edges.
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
    """A mesh rebuilt to a field of normals.

    Attributes
    ----------
    mesh : Mesh
        Faces and their order as given; vertices moved.
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
        What was dropped before.
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
        Clean; units as given.
    source_faces : (M,) int64
        Which face of the given mesh each face is; they keep their order.
    report : SmoothReport
    """

    mesh: Mesh
    source_faces: NDArray[np.int64]
    report: SmoothReport

    def _line(self) -> str:
        moved = self.report.reconstruction.moved_rms_mm
        return f"{self.mesh._line()}, detail gain {self.report.detail_gain:g}, moved by {moved:.3g} mm rms"
