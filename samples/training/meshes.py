"""Meshes to train and evaluate a learned mesh filter, each with suitable parameters.

    sys.path[:0] = ["samples", "samples/training"]
    from meshes import held_out_meshes, training_meshes

A mesh is a base form with an ornament and in some cases scanner noise. The form without the ornament gives the normals
that a filter should give: ``clean_normals``.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np
from catalogue import TRAINING
from catalogue_more import MORE
from entry import Entry
from held_out import HELD_OUT
from numpy.typing import NDArray
from ornament import Rng
from surface import Array, Faces, Surface, angle_deg
from tessellation import halved


@dataclass(frozen=True, eq=False)
class TrainingMesh:
    """A mesh and the GRNF parameters that remove its ornament.

    Attributes
    ----------
    name : str
        Ends with ``+`` if each face of another mesh was cut into four.
    vertices : (N, 3) float64
    faces : (M, 3) int32
    sigma_s : float
        In mean edges of this mesh.
    sigma_r : float
    iterations : int
    group : str
        ``creased``, ``organic``, ``ornament`` or ``plain``, which has no ornament.
    clean_normals : (M, 3) float64
        Normals of the faces before ornament and noise.
    """

    name: str
    vertices: Array
    faces: Faces
    sigma_s: float
    sigma_r: float
    iterations: int
    group: str
    clean_normals: NDArray[np.float64] | None = None


def heights_of(entry: Entry, surface: Surface, rng: Rng) -> Array:
    """The ornament's height at each vertex."""
    if entry.ornament is None:
        return np.zeros(len(surface.vertices))
    heights = entry.ornament(surface, rng) + np.zeros(len(surface.vertices))
    heights = heights - np.median(heights)
    if entry.where is not None:
        heights = heights * entry.where(surface.vertices)
    if entry.rim is not None:
        heights = heights * surface.away_from_creases(*entry.rim)
    slopes = surface.slopes(heights)[surface.thinness > 0.25]
    return heights * (entry.slope / np.percentile(slopes[slopes > 0.1 * np.percentile(slopes, 98)], 90))


def calmed(surface: Surface, heights: Array, steepest: float = 70.0) -> Array:
    """Heights smoothed where they would rotate a face by more than an angle, as in narrow parts of the form."""
    for _ in range(12):
        turned = angle_deg(Surface(surface.raised(heights), surface.faces).face_normals, surface.face_normals)
        bad = surface.faces[turned > steepest]
        if not len(bad):
            break
        count = np.bincount(bad.ravel(), minlength=len(heights))
        total = np.bincount(bad.ravel(), np.repeat(heights[bad].mean(axis=1), 3), len(heights))
        heights = np.where(count > 0, 0.9 * total / count.clip(1, None), heights)
    return heights


def made(entry: Entry, seed: int) -> list[TrainingMesh]:
    """The mesh of an entry, and its finer version if it has one."""
    rng = np.random.default_rng([seed, zlib.crc32(entry.name.encode())])
    surface = entry.form(rng)
    heights = heights_of(entry, surface, rng)
    off = rng.normal(size=(len(heights), 4)) * entry.noise * surface.edge
    vertices = surface.raised(calmed(surface, heights + off[:, 0])) + 0.2 * off[:, 1:]
    one = TrainingMesh(entry.name, vertices, surface.faces, *entry.filter, entry.group, surface.face_normals)
    if entry.finer is None:
        return [one]
    points, faces, source = halved(vertices, surface.faces)
    two = TrainingMesh(f"{entry.name}+", points, faces, *entry.finer, entry.group, surface.face_normals[source])
    return [one, two]


def training_meshes(seed: int) -> list[TrainingMesh]:
    """Training meshes, the same for the same seed."""
    return [mesh for entry in (*TRAINING, *MORE) for mesh in made(entry, seed)]


def held_out_meshes(seed: int) -> list[TrainingMesh]:
    """Held-out meshes: other combinations of forms, ornaments and tessellations than in training."""
    return [mesh for entry in HELD_OUT for mesh in made(entry, seed)]
