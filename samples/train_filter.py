"""Train the filter that comes with the package: ``python samples/train_filter.py [FILE.npz]``.

The recipe: the meshes of ``samples/training`` (the script makes them), seed 0; their GRNF bases with the parameters in
the catalogue; the default options of `nmaptool.TrainOptions` and `nmaptool.DescriptorOptions`.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import nmaptool as nm

sys.path.insert(0, str(Path(__file__).parent / "training"))
from meshes import TrainingMesh, training_meshes

MESH_SEED = 0
HOME = Path(__file__).parents[1] / "nmaptool" / "learned" / "filter.npz"


def example(made: TrainingMesh) -> nm.TrainingExample:
    """A training mesh with its GRNF base."""
    options = nm.FilterOptions(filter="grnf", sigma_s=made.sigma_s, sigma_r=made.sigma_r, iterations=made.iterations)
    return nm.training_example(nm.Mesh(made.vertices, made.faces, name=made.name), options)


def main() -> None:
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else HOME
    started = time.perf_counter()
    examples = [example(made) for made in training_meshes(MESH_SEED)]
    made_s = time.perf_counter() - started
    model = nm.train(examples, progress=lambda word, share: print(f"\r{share:4.0%} {word:24}", end="", file=sys.stderr))
    print(file=sys.stderr)
    nm.write_filter_model(model, target, overwrite=True)
    faces = sum(len(each.mesh.faces) for each in examples)
    print(f"{len(examples)} meshes, {faces} faces, made in {made_s:.0f} s; trained in", end=" ")
    print(
        f"{time.perf_counter() - started - made_s:.0f} s: filter {model.digest}, {target.stat().st_size / 1e3:.0f} kB"
    )
    print(
        "mean angle to the targets, degrees:", ", ".join(f"{angle:.2f}" for angle in model.metadata["mean_angle_deg"])
    )


if __name__ == "__main__":
    main()
