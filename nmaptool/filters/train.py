"""Train a learned filter on meshes."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from nmaptool._version import __version__
from nmaptool.core.arrays import Float32, Float64
from nmaptool.core.errors import InputError
from nmaptool.core.progress import Progress
from nmaptool.core.vectors import mean_angle_deg
from nmaptool.filters.descriptor import Describer
from nmaptool.filters.learned.canonical import in_canonical_frame
from nmaptool.filters.learned.cascade import apply_stage
from nmaptool.filters.learned.fitting import find_clusters, fit_network, nearest_cluster
from nmaptool.filters.learned.model import FilterModel, Stage, TrainingState
from nmaptool.filters.prepared import prepare_mesh
from nmaptool.options import DescriptorOptions, FilterOptions, TrainOptions
from nmaptool.options.plain_values import plain_values
from nmaptool.types.mesh import Mesh
from nmaptool.types.shown import OneLine, counted

# fewer faces are not enough to train a network
_LEAST_FACES = 500


@dataclass(frozen=True, eq=False, repr=False)
class TrainingExample(OneLine):
    """A mesh and the base normals that a learned filter should give it.

    Parameters
    ----------
    mesh : Mesh
        Clean, see `nmaptool.clean_mesh`.
    targets : (M, 3) float64
        Unit normals of its faces.
    metadata : mapping
        How the targets were computed, as plain values.
    """

    mesh: Mesh
    targets: Float64
    metadata: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.targets.shape != (len(self.mesh.faces), 3):
            raise InputError(
                f"{self.mesh.name}: targets must have shape ({len(self.mesh.faces)}, 3); found {self.targets.shape}"
            )
        if not (np.abs(np.einsum("ij,ij->i", self.targets, self.targets) - 1) <= 1e-6).all():
            raise InputError(f"{self.mesh.name}: targets must be finite and of unit length")

    def _line(self) -> str:
        return f"of {self.mesh._line()}"


def training_example(mesh: Mesh, filter: FilterOptions | None = None) -> TrainingExample:
    """Pair a mesh with the base normals of the GMM-based filter, the targets of training (paper, Sec. 3.2).

    Parameters
    ----------
    mesh : Mesh
        It is cleaned first.
    filter : FilterOptions, optional
        Parameters that suit this mesh. Default: those of ``FilterOptions(filter="grnf")``.

    Returns
    -------
    TrainingExample
        The clean mesh and (M, 3) float64 target normals.

    Raises
    ------
    InputError
        If no face of the mesh is usable.

    Examples
    --------
    >>> import trimesh
    >>> nm.training_example(nm.Mesh.from_trimesh(trimesh.creation.icosphere(subdivisions=1)))
    <TrainingExample of mesh: 42 vertices, 80 faces, 1 mm per unit (assumed)>
    """
    prepared = prepare_mesh(mesh, filter or FilterOptions(filter="grnf"))
    metadata = {"name": mesh.name, **plain_values(prepared.filter)}
    return TrainingExample(prepared.mesh, prepared.decompose().base, metadata)


def train(
    examples: Sequence[TrainingExample],
    options: TrainOptions | None = None,
    *,
    descriptor: DescriptorOptions | None = None,
    state: TrainingState | None = None,
    keep: Callable[[TrainingState], None] | None = None,
    progress: Progress | None = None,
) -> FilterModel:
    """Learn a filter of face normals from examples (paper, Sec. 3.2: DRNF).

    Each stage describes every face by filtered normals in a local frame, clusters the faces, and fits one network per
    cluster to the target normals. Its output guides the filters of the next stage.

    Parameters
    ----------
    examples : sequence of TrainingExample
        At least 500 faces in all.
    options : TrainOptions, optional
        Stages, number and size of the networks, steps and seed.
    descriptor : DescriptorOptions, optional
        Input of the networks.
    state : TrainingState, optional
        State of an unfinished run with the same examples and options, to continue it; the result is the same as without
        the interruption.
    keep : callable, optional
        Called with the TrainingState after each network.
    progress : callable, optional
        Called with the name of the stage and the share done, 0 to 1.

    Returns
    -------
    FilterModel
        Pass it as ``model`` to `nmaptool.bake` and others.

    Raises
    ------
    InputError
        If there are fewer than 500 faces, or the state belongs to another training.

    Examples
    --------
    >>> import trimesh
    >>> mesh = nm.Mesh.from_trimesh(trimesh.creation.icosphere(subdivisions=3))
    >>> quick = nm.TrainOptions(stages=1, clusters=1, hidden=2, steps=1)
    >>> model = nm.train([nm.training_example(mesh)], quick, descriptor=nm.DescriptorOptions((3.0,), (0.5,), 1))
    >>> len(model.stages)
    1
    """
    options, descriptor = options or TrainOptions(), descriptor or DescriptorOptions()
    faces = sum(len(example.mesh.faces) for example in examples)
    if faces < _LEAST_FACES:
        raise InputError(
            f"the meshes have only {counted(faces, 'face')} in total, but training needs at least {_LEAST_FACES}; give "
            "more meshes, or denser ones"
        )
    name = fingerprint(examples, options, descriptor)
    state = state or TrainingState(name)
    if state.fingerprint != name:
        raise InputError(
            f"{state.name}: belongs to a training with other meshes or options; use the same ones, or another `state`"
        )
    normals = [example.mesh.geometry.normals for example in examples]
    angles = [_mean_angle(examples, normals)]
    for number in range(options.stages):
        work = _Work(examples, options, descriptor, number, progress)
        faces_described = work.describe(normals)
        if number >= len(state.stages):
            state = work.fit(faces_described, state, keep)
        normals = [apply_stage(state.stages[number], *described) for described in faces_described]
        angles.append(_mean_angle(examples, normals))
    metadata = {
        "version": __version__,
        "options": plain_values(options),
        "meshes": [{"faces": len(e.mesh.faces), **e.metadata} for e in examples],
        "losses": [round(loss, 8) for loss in state.losses],
        "mean_angle_deg": [round(angle, 4) for angle in angles],
    }
    return FilterModel(descriptor, state.stages, metadata)


def fingerprint(examples: Sequence[TrainingExample], options: TrainOptions, descriptor: DescriptorOptions) -> str:
    """Return an identifier of a training, the same for the same meshes, targets and options."""
    seen = hashlib.sha256(json.dumps([plain_values(options), dataclasses.asdict(descriptor)]).encode())
    for example in examples:
        for array in (example.mesh.vertices, example.mesh.faces, example.targets):
            seen.update(np.ascontiguousarray(array).tobytes())
    return seen.hexdigest()[:16]


def _mean_angle(examples: Sequence[TrainingExample], normals: Sequence[Float64]) -> float:
    """Return the mean angle between normals and targets in degrees, with equal weights for all meshes."""
    each = (mean_angle_deg(found, example.targets) for example, found in zip(examples, normals, strict=True))
    return float(np.mean(list(each)))


class _Work:
    """One stage of a training."""

    def __init__(
        self,
        examples: Sequence[TrainingExample],
        options: TrainOptions,
        descriptor: DescriptorOptions,
        number: int,
        progress: Progress | None,
    ) -> None:
        self.examples, self.options, self.descriptor, self.number = examples, options, descriptor, number
        self._progress = progress

    def notify(self, word: str, share: float) -> None:
        """Report the share done of the whole training."""
        if self._progress is not None:
            self._progress(f"stage {self.number + 1}, {word}", (self.number + share) / self.options.stages)

    def describe(self, normals: Sequence[Float64]) -> list[tuple[Float32, Float32]]:
        """Return the frames and inputs of every face of every mesh."""
        out = []
        for place, (example, field_) in enumerate(zip(self.examples, normals, strict=True)):
            self.notify("describing", 0.4 * place / len(self.examples))
            descriptors = Describer(example.mesh, self.descriptor)(field_ if self.number else None)
            out.append(in_canonical_frame(field_, descriptors))
        return out

    def fit(
        self,
        described: Sequence[tuple[Float32, Float32]],
        state: TrainingState,
        keep: Callable[[TrainingState], None] | None,
    ) -> TrainingState:
        """Return the state with this stage finished."""
        options = self.options
        inputs, targets = self._drawn(described)
        centers = state.centers
        if centers is None:
            # clusters depend on the normals only
            normals = np.ascontiguousarray(inputs[:, : 3 * (1 + self.descriptor.size)])
            centers = find_clusters(normals, options.clusters, np.random.default_rng([options.seed, self.number, 1]))
        clusters = nearest_cluster(inputs, centers)
        for kind in range(len(state.networks), options.clusters):
            begun = 0.4 + 0.6 * kind / options.clusters

            def notify(done: float, begun: float = begun) -> None:
                self.notify("fitting", begun + 0.6 * done / options.clusters)

            network, loss = fit_network(
                inputs[clusters == kind],
                targets[clusters == kind],
                mixed=1 + self.descriptor.size,
                hidden=options.hidden,
                steps=options.steps,
                weight_decay=options.weight_decay,
                rng=np.random.default_rng([options.seed, self.number, 2, kind]),
                step_done=notify,
            )
            networks, losses = (*state.networks, network), (*state.losses, loss)
            state = dataclasses.replace(state, centers=centers, networks=networks, losses=losses)
            if keep is not None and kind < options.clusters - 1:
                keep(state)
        stages = (*state.stages, Stage(centers, state.networks))
        state = dataclasses.replace(state, stages=stages, centers=None, networks=())
        if keep is not None:
            keep(state)
        return state

    def _drawn(self, described: Sequence[tuple[Float32, Float32]]) -> tuple[Float32, Float32]:
        """Return the inputs and targets of a random sample of faces."""
        rng = np.random.default_rng([self.options.seed, self.number, 0])
        each = -(-self.options.samples // len(self.examples))
        inputs, targets = [], []
        for example, (frames, all_inputs) in zip(self.examples, described, strict=True):
            count = len(all_inputs)
            chosen = rng.permutation(count)[: min(each, count)]
            inputs.append(all_inputs[chosen])
            targets.append(np.einsum("mij,mj->mi", frames[chosen], example.targets[chosen].astype(np.float32)))
        return np.concatenate(inputs), np.concatenate(targets)
