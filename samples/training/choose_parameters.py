"""The parameters of each mesh: ``python samples/training/choose_parameters.py [training|held_out] [NAME ...]``.

Prints the sigma_s, sigma_r and number of passes whose GRNF base is closest to the form without its ornament; faces at
creases count double.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).parents[1]))
from meshes import TrainingMesh, held_out_meshes, training_meshes
from numpy.typing import NDArray
from surface import Array, Surface, angle_deg

import nmaptool as nm
from nmaptool.filters.rolling import rolling_guidance, split_residuals
from nmaptool.filters.surface import gather_surface

SIZES = (1.5, 2, 3, 4, 5, 6, 8, 10, 12)
COARSE = (1.5, 3, 5, 8, 12)
LIKENESSES = (0.2, 0.3, 0.4, 0.5, 0.7)
PASSES = (4, 5, 6, 8)
Tried = dict[tuple[float, float, int], tuple[float, float, float]]


def crease_faces(mesh: TrainingMesh) -> NDArray[np.bool_]:
    """Faces with a corner on a crease of the form without its ornament."""
    from surface import neighbours

    assert mesh.clean_normals is not None
    pairs, ends = neighbours(mesh.faces)
    cosine = (mesh.clean_normals[pairs[:, 0]] * mesh.clean_normals[pairs[:, 1]]).sum(axis=1)
    on_crease = np.zeros(len(mesh.vertices), bool)
    on_crease[ends[cosine < np.cos(np.radians(25))]] = True
    return on_crease[mesh.faces].any(axis=1)


def angles(mesh: TrainingMesh, given: nm.Mesh, size: float, likeness: float, weights: Array) -> Tried:
    """For each number of passes: the score of the GRNF base, and mean angles of the GRNF and RNF bases."""
    assert mesh.clean_normals is not None
    geometry, areas = given.geometry, given.geometry.areas
    gather = gather_surface(given, size * given.mean_edge, likeness)
    found: Tried = {}
    guides: list[Array] = []

    def kept(guide: Array | None) -> Array:
        if guide is not None:
            guides.append(guide.copy())
        return np.asarray(gather(guide))

    guides_last = rolling_guidance(geometry.normals, kept, max(PASSES))
    for passes in PASSES:
        filtered = guides_last if passes == max(PASSES) else guides[passes - 1]
        base = split_residuals(geometry.normals, filtered, areas).base
        off = angle_deg(base / np.linalg.norm(base, axis=1, keepdims=True), mesh.clean_normals)
        rnf = float(np.average(angle_deg(filtered, mesh.clean_normals), weights=areas))
        score = float(np.average(off, weights=weights))
        found[size, likeness, passes] = (score, float(np.average(off, weights=areas)), rnf)
    return found


def chosen(mesh: TrainingMesh) -> tuple[tuple[float, float, int], Tried]:
    """The best parameters: sigma_s is varied first, then sigma_r, then sigma_s again next to its best value."""
    given = nm.Mesh(mesh.vertices, mesh.faces)
    weights = given.geometry.areas * (1 + crease_faces(mesh))
    tried: Tried = {}

    def best() -> tuple[float, float, int]:
        return min(tried, key=lambda k: (round(tried[k][0], 2), k[2], k[0]))

    def attempt(size: float, likeness: float) -> None:
        if (size, likeness, PASSES[0]) not in tried:
            tried.update(angles(mesh, given, size, likeness, weights))

    for size in COARSE:
        attempt(size, 0.4)
    for likeness in LIKENESSES:
        attempt(best()[0], likeness)
    at = SIZES.index(best()[0])
    for size in SIZES[max(0, at - 1) : at + 2]:
        attempt(size, best()[1])
    return best(), tried


def main() -> None:
    words = sys.argv[1:] or ["training"]
    meshes = {"training": training_meshes, "held_out": held_out_meshes}[words[0]](0)
    for mesh in meshes:
        if len(words) > 1 and not any(word in mesh.name for word in words[1:]):
            continue
        best, tried = chosen(mesh)
        assert mesh.clean_normals is not None
        geometry = Surface(mesh.vertices, mesh.faces)
        areas = np.linalg.norm(geometry.crosses, axis=1)
        before = float(np.average(angle_deg(geometry.face_normals, mesh.clean_normals), weights=areas))
        _, grnf, rnf = tried[best]
        size, likeness, passes = best
        print(
            f"{mesh.name:24} {mesh.group:9} {len(mesh.faces):6}"
            f" original {before:5.1f}  grnf {grnf:5.1f}  rnf {rnf:5.1f}  ({size:g}, {likeness:g}, {passes})",
            flush=True,
        )


if __name__ == "__main__":
    main()
