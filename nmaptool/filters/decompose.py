"""Split the face normals of a mesh into base and detail."""

from __future__ import annotations

from nmaptool.core.errors import UsageError
from nmaptool.core.progress import Progress
from nmaptool.filters.descriptor import Describer
from nmaptool.filters.detail_size import sigma_s_of
from nmaptool.filters.learned.cascade import refine
from nmaptool.filters.learned.model import FilterModel
from nmaptool.filters.learned.shipped import shipped_filter
from nmaptool.filters.ring import gather_ring
from nmaptool.filters.rolling import Decomposition, GatherMaker, rolling_guidance, split_residuals
from nmaptool.filters.surface import gather_surface
from nmaptool.meshes.clean import clean_mesh
from nmaptool.options import FilterOptions
from nmaptool.types.mesh import Mesh

# neighbourhoods by name
_GATHER: dict[str, GatherMaker] = {"ring": gather_ring, "surface": gather_surface}


def decompose_normals(
    mesh: Mesh,
    options: FilterOptions | None = None,
    *,
    model: FilterModel | None = None,
    progress: Progress | None = None,
) -> Decomposition:
    """Split the face normals of a mesh into base and detail (GRNF: paper, Sec. 3.1; DRNF: Sec. 3.2).

    The base normals are those of the form, and the detail is the rest of the original normals. `smooth` rebuilds a mesh
    from a mixture of both, `bake` renders them.

    Parameters
    ----------
    mesh : Mesh
        It is cleaned first; the result has the faces that `nmaptool.clean_mesh` returns.
    options : FilterOptions, optional
        The filter and its parameters.
    model : FilterModel, optional
        Model for the filter ``learned``. Default: the one that comes with the package.
    progress : callable, optional
        Called with the stage, such as "filtering", and the share done, 0 to 1.

    Returns
    -------
    Decomposition
        Face normals, base and residual as (M, 3) float64, where base + residual equals the normals exactly; the mixture
        and its threshold.

    Raises
    ------
    InputError
        If no face of the mesh is usable.
    UsageError
        If a model is given, but the filter is not ``learned``.

    Examples
    --------
    >>> import trimesh
    >>> sphere = nm.Mesh.from_trimesh(trimesh.creation.icosphere(subdivisions=1))
    >>> split = nm.decompose_normals(sphere)
    >>> bool(np.all(split.base + split.residual == split.normals))
    True
    """
    clean, _, _ = clean_mesh(mesh)
    return decompose_clean(clean, options or FilterOptions(), progress, model)


def decompose_clean(
    mesh: Mesh, options: FilterOptions, progress: Progress | None = None, model: FilterModel | None = None
) -> Decomposition:
    """Do the same as `decompose_normals` for a mesh that is already clean."""
    geometry = mesh.geometry
    model = model_of(options, model)
    if model is not None:
        learned = refine(model, geometry.normals, Describer(mesh, model.descriptor), progress)
        return split_residuals(geometry.normals, learned, geometry.areas)
    gather = _GATHER[options.neighborhood](mesh, sigma_s_of(mesh, options), options.sigma_r)
    filtered = rolling_guidance(geometry.normals, gather, options.iterations, progress)
    return split_residuals(geometry.normals, filtered, geometry.areas, keep_small=options.filter == "grnf")


def model_of(options: FilterOptions, model: FilterModel | None) -> FilterModel | None:
    """Return the model that a filter uses, or None if it uses none.

    Raises
    ------
    UsageError
        If a model is given for a filter that is not learned.
    """
    if options.filter == "learned":
        return model or shipped_filter()
    if model is not None:
        raise UsageError(f"`model`: only applies to `filter='learned'`, found {options.filter}")
    return None
