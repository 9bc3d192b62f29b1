"""Apply the stages of a learned filter to a field of normals."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from nmaptool.core.arrays import Float32, Float64
from nmaptool.core.progress import Progress
from nmaptool.filters.learned.canonical import in_canonical_frame
from nmaptool.filters.learned.fitting import nearest_cluster
from nmaptool.filters.learned.model import FilterModel, Stage

# guide (M, 3) float64 or None -> (M, K, 4) float32 filtered normals and their agreement
Describe = Callable[[Float64 | None, Progress | None], Float32]


def apply_stage(stage: Stage, frames: Float32, inputs: Float32) -> Float64:
    """Return the normals that one stage computes.

    Parameters
    ----------
    stage : Stage
    frames : (M, 3, 3) float32
    inputs : (M, D) float32

    Returns
    -------
    (M, 3) float64
        Unit normals.
    """
    clusters = nearest_cluster(inputs, stage.centers)
    own = np.empty((len(inputs), 3), np.float32)
    for number, network in enumerate(stage.networks):
        those = np.flatnonzero(clusters == number)
        own[those] = network(inputs.take(those, axis=0))
    normals = np.einsum("mij,mi->mj", frames, own, dtype=np.float64)
    return np.asarray(normals / np.sqrt(np.einsum("ij,ij->i", normals, normals))[:, None])


def refine(model: FilterModel, normals: Float64, describe: Describe, progress: Progress | None = None) -> Float64:
    """Filter normals by a learned model (paper, Sec. 3.2).

    Parameters
    ----------
    model : FilterModel
    normals : (M, 3) float64
        Unit normals of the faces.
    describe : callable
        Returns the filtered normals of the mesh for a guide, with the options ``model.descriptor``.
    progress : callable, optional

    Returns
    -------
    (M, 3) float64
        Unit normals.
    """
    count = len(model.stages)
    for number, stage in enumerate(model.stages):

        def notify(_: str, share: float, number: int = number) -> None:
            if progress is not None:
                progress("filtering", (number + share) / count)

        # the first stage has no guide, as in rolling guidance; the guide of the others is the previous result
        descriptors = describe(normals if number else None, notify)
        normals = apply_stage(stage, *in_canonical_frame(normals, descriptors))
    return normals
