"""Rebuild a mesh to a field of normals: shape every face and stitch them, repeatedly (paper, Sec. 4.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float64, Mask
from nmaptool.core.progress import Progress
from nmaptool.options import ReconstructOptions
from nmaptool.reconstruction.boundary import boundary_vertices
from nmaptool.reconstruction.folds import relaxed
from nmaptool.reconstruction.shaping import is_opposed, normals_of, rotated, shapes_of, target_shapes
from nmaptool.reconstruction.stitching import Average, ShapeStitch, Stitch, gradient_stiffness
from nmaptool.types.mesh import Mesh

# factor on the closeness of vertices of folded faces, whose positions are a poor guide
_FOLDED = 1e-3
# relative residuals of a single solve, and of each of several
_EXACT, _ROUGH = 1e-10, 1e-2
# in steps
_UNFOLD_EVERY = 4


@dataclass(frozen=True, eq=False)
class Rebuilt:
    """The result of the steps.

    Attributes
    ----------
    vertices : (N, 3) float64
    folded_before, folded_after : int
        Number of faces whose normal is more than a right angle from its target.
    boundary : (N,) bool
        Vertices of open edges.
    moves : tuple of float
        Root mean square of the vertices' moves in each step, in mean edge lengths.
    """

    vertices: Float64
    folded_before: int
    folded_after: int
    boundary: Mask
    moves: tuple[float, ...]


def rebuild(mesh: Mesh, targets: Float64, options: ReconstructOptions, progress: Progress | None = None) -> Rebuilt:
    """Move the vertices so that the face normals approach their targets.

    All schemes repeat two steps. Local: each face separately gets its target shape; the "gsfg..." schemes project its
    corners onto the plane through its centroid (paper, Eq. 2), "poisson" rotates it by the smallest rotation. Global:
    the shapes are stitched, by the mean of each vertex's corners (Eq. 3; "gsfg"), or over the whole mesh at once with a
    pull to the given vertices. With projections, all schemes minimise the sum over faces of |h|^2, where h are the
    heights of a face's corners above its plane, relative to their mean ("gsfg", "gsfg-shape"), or of the integral of
    |grad h|^2 ("gsfg-gradient"), which does not depend on how finely the surface is divided. If the targets are not the
    normals of any surface, "gsfg" shrinks towards a point, and only the number of steps limits this.

    Faces far from their targets are rotated, too, since projections would crush them. A projection leaves faces that
    oppose their targets folded over: at the start and every few steps, their vertices are distributed between their
    neighbours (`relaxed`), and vertices of faces that were folded at the start are hardly pulled back. "poisson" only
    rotates, as its authors do.

    Parameters
    ----------
    mesh : Mesh
        A clean mesh.
    targets : (M, 3) float64
        Unit normals.
    options : ReconstructOptions
    progress : callable, optional
        Called with the stage and the share done, 0 to 1.
    """
    faces, start = mesh.faces, mesh.vertices
    boundary = boundary_vertices(faces, len(start))
    held = boundary if options.boundary == "hold" else np.zeros_like(boundary)
    shapes = shapes_of(start, faces)
    normals = normals_of(shapes)
    folded = is_opposed(normals, targets)
    if progress is not None:
        progress("setting up", 0.0)
    stitch = _stitch(mesh, options, shapes, folded, held)
    vertices = start
    moves = []
    for step in range(options.steps):
        if progress is not None:
            progress("rebuilding", step / options.steps)
        shapes = shapes_of(vertices, faces)
        normals = normals_of(shapes)
        if step % _UNFOLD_EVERY == 0 and options.scheme != "poisson":
            over = is_opposed(normals, targets)
            if over.any():
                vertices = relaxed(vertices, faces, over, held)
                shapes = shapes_of(vertices, faces)
                normals = normals_of(shapes)
        shaped = (rotated if options.scheme == "poisson" else target_shapes)(shapes, normals, targets)
        shaped -= shapes
        move = stitch.move(shaped, vertices - start)
        vertices = vertices + move
        moves.append(float(np.sqrt(np.einsum("ij,ij->i", move, move).mean())) / mesh.mean_edge)
    after = is_opposed(normals_of(shapes_of(vertices, faces)), targets)
    return Rebuilt(vertices, int(folded.sum()), int(after.sum()), boundary, tuple(moves))


def _stitch(mesh: Mesh, options: ReconstructOptions, shapes: Float64, folded: Mask, held: Mask) -> Stitch:
    if options.scheme == "gsfg":
        return Average(mesh.faces, held)
    closeness = np.full(len(mesh.vertices), options.closeness)
    stiffness = None if options.scheme == "gsfg-shape" else gradient_stiffness(shapes)
    if options.scheme == "poisson":
        residual = _EXACT if options.steps == 1 else _ROUGH
        return ShapeStitch(mesh.faces, stiffness, closeness, held, residual)
    touched = np.zeros(len(mesh.vertices), bool)
    touched[mesh.faces[folded]] = True
    closeness[touched] *= _FOLDED
    return ShapeStitch(mesh.faces, stiffness, closeness, held)
