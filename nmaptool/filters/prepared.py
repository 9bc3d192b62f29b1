"""A mesh made ready for a filter of its face normals."""

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
    """A clean mesh, what was dropped from it, and the filter that is to split its normals.

    Attributes
    ----------
    mesh : Mesh
        Clean.
    source_faces : (M,) int64
        Index in the given mesh of each face.
    findings : MeshFindings
    filter : FilterOptions
    model : FilterModel or None
        Of the filter ``learned``; None of the others.
    """

    mesh: Mesh
    source_faces: NDArray[np.int64]
    findings: MeshFindings
    filter: FilterOptions
    model: FilterModel | None

    @property
    def sigma_s(self) -> float:
        """In units of the mesh; 0 of a learned filter, which has none."""
        return 0.0 if self.model is not None else sigma_s_of(self.mesh, self.filter)

    @property
    def warnings(self) -> list[str]:
        """What the filter may not be meant to do to this mesh."""
        return long_edges(self.mesh, self.filter)

    def decompose(self, progress: Progress | None = None) -> Decomposition:
        """The normals split into base and detail."""
        return decompose_clean(self.mesh, self.filter, progress, self.model)


def prepare_mesh(mesh: Mesh, filter: FilterOptions | None = None, model: FilterModel | None = None) -> PreparedMesh:
    """Clean a mesh and settle its filter; raises as `nmaptool.decompose_normals` does."""
    chosen = filter or FilterOptions()
    model = model_of(chosen, model)
    return PreparedMesh(*clean_mesh(mesh), chosen, model)
