"""Rebuild a mesh to given face normals."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError
from nmaptool.core.progress import Progress
from nmaptool.core.vectors import angles_deg
from nmaptool.options import ReconstructOptions
from nmaptool.reconstruction.measures import volume, volume_between
from nmaptool.reconstruction.rebuild import Rebuilt, rebuild
from nmaptool.reconstruction.shaping import normals_of, shapes_of
from nmaptool.types.mesh import Mesh
from nmaptool.types.reconstruction import Reconstruction, ReconstructReport

# tolerance of the length of unit normals; enough for float32
_OFF_LENGTH = 1e-3


def reconstruct(
    mesh: Mesh,
    normals: NDArray[np.floating[Any]],
    options: ReconstructOptions | None = None,
    *,
    progress: Progress | None = None,
) -> Reconstruction:
    """Move the vertices of a mesh so that its face normals become the given ones (gSfG: paper, Sec. 4.1, Eq. 2 and 3).

    Each step rotates the faces towards their normals and finds the vertices that fit them best; ``closeness`` pulls the
    vertices to their original positions.

    Parameters
    ----------
    mesh : Mesh
        A clean mesh; see `nmaptool.clean_mesh`.
    normals : (M, 3) float of any type
        Target normals of the faces, unit vectors.
    options : ReconstructOptions, optional
        Scheme, steps and closeness.
    progress : callable, optional
        Called with the stage, "setting up" or "rebuilding", and the share of the steps done, 0 to 1.

    Returns
    -------
    Reconstruction
        The same faces with moved vertices, in the same units. With the mesh's own normals, no vertex moves by more than
        1e-9 of the size of the mesh.

    Raises
    ------
    InputError
        If the mesh is not clean, the normals are not one finite unit vector per face, or most of them point inwards.
    ConvergenceError
        If the system of scheme "poisson" cannot be solved.

    Examples
    --------
    With its own normals, a mesh stays the same:

    >>> import trimesh
    >>> sphere = nm.Mesh.from_trimesh(trimesh.creation.icosphere(subdivisions=1))
    >>> rebuilt = nm.reconstruct(sphere, sphere.geometry.normals)
    >>> bool(np.allclose(rebuilt.vertices, sphere.vertices))
    True
    """
    options = options or ReconstructOptions()
    _check_mesh(mesh)
    targets = _checked(mesh, normals)
    begun = time.perf_counter()
    rebuilt = rebuild(mesh, targets, options, progress)
    report = _report(mesh, targets, options, rebuilt, time.perf_counter() - begun)
    after = replace(mesh, vertices=rebuilt.vertices)
    return Reconstruction(after, report)


def _check_mesh(mesh: Mesh) -> None:
    remedy = "clean it first: nm.clean_mesh(mesh)[0]"
    if not len(mesh.faces):
        raise InputError(f"{mesh.name}: has no faces, so there is no surface to rebuild")
    if not np.isfinite(mesh.vertices).all():
        raise InputError(f"{mesh.name}: has NaN or infinite vertices; {remedy}")
    flat = int((~(mesh.geometry.areas > 0)).sum())
    if flat:
        raise InputError(f"{mesh.name}: has faces without area ({flat}), which have no normal; {remedy}")


def _checked(mesh: Mesh, normals: NDArray[np.floating]) -> Float64:
    """Check the target normals and return them as exact unit vectors."""
    given = np.asarray(normals)
    if given.shape != (len(mesh.faces), 3) or given.dtype.kind != "f":
        raise InputError(
            f"the normals are {given.dtype} {given.shape}, expected float ({len(mesh.faces)}, 3): one per face of "
            f"{mesh.name}"
        )
    targets = given.astype(np.float64)
    length = np.sqrt(np.einsum("ij,ij->i", targets, targets))
    if not np.isfinite(length).all():
        raise InputError(f"the normals must be finite; NaN or infinite: {int((~np.isfinite(length)).sum())}")
    off = np.abs(length - 1)
    if off.max() > _OFF_LENGTH:
        worst = int(off.argmax())
        raise InputError(
            f"the normal of face {worst} has length {length[worst]:.4g}, expected 1; normalise the normals"
        )
    targets /= length[:, None]
    areas = mesh.geometry.areas
    away = float(areas[np.einsum("ij,ij->i", targets, mesh.geometry.normals) < 0].sum() / areas.sum())
    if away > 0.5:
        raise InputError(
            f"the normals would flip {away:.0%} of the area of {mesh.name}; check that they belong to this mesh, and "
            "negate them if they point inwards"
        )
    return targets


def _report(
    mesh: Mesh, targets: Float64, options: ReconstructOptions, rebuilt: Rebuilt, seconds: float
) -> ReconstructReport:
    mm, areas = mesh.mm_per_unit, mesh.geometry.areas
    weights = areas / areas.sum()
    before = angles_deg(mesh.geometry.normals, targets)
    after = angles_deg(normals_of(shapes_of(rebuilt.vertices, mesh.faces)), targets)
    moved = rebuilt.vertices - mesh.vertices
    moved2 = np.einsum("ij,ij->i", moved, moved)
    closed = not rebuilt.boundary.any()
    share = change = None
    if closed or options.boundary == "hold":
        change = volume_between(mesh.vertices, rebuilt.vertices, mesh.faces)
    held = volume(mesh.vertices, mesh.faces)
    if closed and change is not None and abs(held) > 0:
        share = change / abs(held)
    return ReconstructReport(
        options=options,
        vertices=len(mesh.vertices),
        faces=len(mesh.faces),
        boundary_vertices=int(rebuilt.boundary.sum()),
        normal_deviation_before_deg=float(before @ weights),
        normal_deviation_deg=float(after @ weights),
        normal_deviation_p95_deg=float(np.percentile(after, 95)),
        folded_before=rebuilt.folded_before,
        folded_after=rebuilt.folded_after,
        moved_rms_mm=float(np.sqrt(moved2.mean())) * mm,
        moved_max_mm=float(np.sqrt(moved2.max())) * mm,
        diagonal_mm=float(np.linalg.norm(np.ptp(mesh.vertices, axis=0))) * mm,
        volume_share=share,
        volume_change_mm3=None if change is None else change * mm**3,
        mean_offset_mm=None if change is None else change / float(areas.sum()) * mm,
        moves=rebuilt.moves,
        seconds=round(seconds, 4),
    )
