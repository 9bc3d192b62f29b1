"""Accuracy of the learned filter on held-out meshes: ``python docs/learned_filter.py [--model FILE.npz]``.

The reference for each held-out mesh of ``samples/training`` is its GRNF base with its own parameters. Prints mean
angles from it to the learned base and to the best RNF base of a grid of common parameters; also the change of the
learned base when the mesh is rotated, and when each of its faces is divided into four.
"""

from __future__ import annotations

import argparse
import itertools
import sys
from pathlib import Path

import numpy as np

import nmaptool as nm
from nmaptool.core.arrays import Float64

sys.path.insert(0, str(Path(__file__).parents[1] / "samples"))
sys.path.insert(0, str(Path(__file__).parents[1] / "samples" / "training"))
from meshes import TrainingMesh, held_out_meshes

SIZES = (1.5, 2.0, 2.5, 3.0, 3.5, 4.0)
RANGES = (0.2, 0.25, 0.3, 0.35, 0.4, 0.5)
SEED = 0


def mean_angle(one: Float64, other: Float64) -> float:
    """Mean angle between directions over all faces, in degrees."""
    chord = np.linalg.norm(directions(one) - directions(other), axis=1)
    return float(np.degrees(2 * np.arcsin((chord / 2).clip(0, 1))).mean())


def directions(vectors: Float64) -> Float64:
    """Unit vectors."""
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def divided(mesh: nm.Mesh) -> nm.Mesh:
    """Divide each face into four; the four parts of a face are consecutive."""
    corners = mesh.corners
    a, b, c = (corners[:, k] for k in range(3))
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    fine = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], axis=1).reshape(-1, 3)
    return nm.clean_mesh(nm.Mesh(fine, np.arange(len(fine), dtype=np.int32).reshape(-1, 3)))[0]


def target(made: TrainingMesh, mesh: nm.Mesh) -> Float64:
    """The GRNF base with the mesh's own parameters."""
    options = nm.FilterOptions(filter="grnf", sigma_s=made.sigma_s, sigma_r=made.sigma_r, iterations=made.iterations)
    return nm.decompose_normals(mesh, options).base


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--model", type=Path)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--quick", action="store_true", help="skip the rotated and divided meshes")
    given = parser.parse_args()
    model = nm.shipped_filter() if given.model is None else nm.read_filter_model(given.model)
    learned = nm.FilterOptions(filter="learned")
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    fixed: dict[tuple[float, float], list[float]] = {pair: [] for pair in itertools.product(SIZES, RANGES)}
    rows = []
    print(f"filter {model.digest}; degrees\n{'':24} original  learned  network   turned  divided  to clean (target)")
    for made in held_out_meshes(given.seed):
        mesh = nm.clean_mesh(nm.Mesh(made.vertices, made.faces, name=made.name))[0]
        wanted = target(made, mesh)
        found = nm.decompose_normals(mesh, learned, model=model)
        for size, likeness in fixed:
            options = nm.FilterOptions(filter="rnf", sigma_s=size, sigma_r=likeness)
            fixed[size, likeness].append(mean_angle(nm.decompose_normals(mesh, options).base, wanted))
        row = [mean_angle(v, wanted) for v in (found.normals, found.base, found.filtered)]
        turned, finer = float("nan"), float("nan")
        if not given.quick:
            other = nm.decompose_normals(nm.Mesh(mesh.vertices @ turn.T, mesh.faces), learned, model=model)
            turned = mean_angle(found.base @ turn.T, other.base)
            fine = nm.decompose_normals(divided(mesh), learned, model=model)
            finer = mean_angle(np.repeat(found.base, 4, axis=0), fine.base)
        row += [turned, finer, mean_angle(found.base, made.clean_normals), mean_angle(wanted, made.clean_normals)]
        rows.append(row)
        print(f"{made.name:24}" + "".join(f"{value:9.2f}" for value in row), flush=True)
    print(f"{'mean':24}" + "".join(f"{value:9.2f}" for value in np.mean(rows, axis=0)))
    means = {pair: float(np.mean(angles)) for pair, angles in fixed.items()}
    best = min(means, key=lambda pair: means[pair])
    print(f"best single RNF: sigma_s {best[0]:g}, sigma_r {best[1]:g}: {means[best]:.2f}")


if __name__ == "__main__":
    main()
