"""Prepare a mesh for a filter of its face normals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.progress import Progress
from nmaptool.filters.decompose import decompose_clean, model_of
from nmaptool.filters.detail_size import long_edges, sigma_s_of
from nmaptool.filters.learned.model import FilterModel
from nmaptool.filters.rolling import Decomposition
from nmaptool.meshes.clean import clean_mesh
from nmaptool.options import FilterOptions
from nmaptool.types.mesh import Mesh
from nmaptool.types.mesh_findings import MeshFindings


@dataclass(frozen=True, eq=False)
class PreparedMesh:
    """A clean mesh, what was dropped from it, and the filter that splits its normals.

    Attributes
    ----------
    mesh : Mesh
        The clean mesh.
    source_faces : (M,) int64
        Index of each face in the given mesh.
    findings : MeshFindings
    filter : FilterOptions
    model : FilterModel or None
        Model of the filter ``learned``; None for the others.
    """

    mesh: Mesh
    source_faces: NDArray[np.int64]
    findings: MeshFindings
    filter: FilterOptions
    model: FilterModel | None

    @property
    def sigma_s(self) -> float:
        """sigma_s in units of the mesh; 0 for a learned filter, which has none."""
        return 0.0 if self.model is not None else sigma_s_of(self.mesh, self.filter)

    @property
    def warnings(self) -> list[str]:
        """What was ignored or assumed when the mesh was read, and effects of the filter that may be unintended."""
        return [*self.mesh.notes, *long_edges(self.mesh, self.filter)]

    def decompose(self, progress: Progress | None = None) -> Decomposition:
        """Split the normals into base and detail."""
        return decompose_clean(self.mesh, self.filter, progress, self.model)


def prepare_mesh(mesh: Mesh, filter: FilterOptions | None = None, model: FilterModel | None = None) -> PreparedMesh:
    """Clean a mesh and choose its filter; raises the errors of `nmaptool.decompose_normals`."""
    chosen = filter or FilterOptions()
    model = model_of(chosen, model)
    return PreparedMesh(*clean_mesh(mesh), chosen, model)
