"""``nmap train``."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from nmaptool.core.errors import UsageError
from nmaptool.options import FilterOptions, MeshReadOptions, TrainOptions
from nmaptool.options.plain_values import plain_values
from nmaptool_cli.per_input import spread
from nmaptool_cli.session import FILTER, OUTPUTS, READING, RUN, STREAM, RunOptions, Session, refuse_inputs, size_of

if TYPE_CHECKING:
    import nmaptool as nm

# share of the work that the targets are, in the progress bar
_TARGETS = 0.1
_Words = Annotated[tuple[str, ...], Parameter(show_default=False)]
_Numbers = Annotated[tuple[float, ...], Parameter(show_default=False)]
_Counts = Annotated[tuple[int, ...], Parameter(show_default=False)]


@dataclass(frozen=True)
class TargetFilter:
    """The filter to be learned, as --filter grnf of nmap bake. Every flag holds for all meshes; given as often as there
    are meshes, for one each.

    Parameters
    ----------
    sigma_s:
        Size of what is detail in this mesh: in its mean edges, or 2% of its longest side, or 1.5mm. Default: 3.
    sigma_r:
        How sharp an edge must be to stay in the base. Default: 0.5.
    iterations:
        Passes of the filter. Default: 5.
    """

    sigma_s: _Words = ()
    sigma_r: _Numbers = ()
    iterations: _Counts = ()

    def of_each(self, count: int) -> list[FilterOptions]:
        """The filter of each of ``count`` meshes."""
        default = FilterOptions(filter="grnf")
        sizes = spread("sigma-s", [size_of(size) for size in self.sigma_s] or [default.sigma_s], count, "mesh meshes")
        ranges = spread("sigma-r", self.sigma_r or [default.sigma_r], count, "mesh meshes")
        passes = spread("iterations", self.iterations or [default.iterations], count, "mesh meshes")
        return [
            FilterOptions(filter="grnf", sigma_s=s, sigma_r=r, iterations=k)
            for s, r, k in zip(sizes, ranges, passes, strict=True)
        ]


@dataclass(frozen=True)
class TrainOutputs:
    """What is written.

    Parameters
    ----------
    output:
        The learned filter, .npz: for nmap bake --filter learned --model.
    state:
        File for what is finished, .npz: it is written after every network, and a run that finds it goes on from there,
        to the same result. Gone once the filter is written.
    report:
        Full account of the run as JSON; - for standard output.
    overwrite:
        Replace files that exist.
    """

    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None
    state: Path | None = None
    report: Path | None = None
    overwrite: bool = False


def train(
    *meshes: str,
    outputs: Annotated[TrainOutputs, Parameter(name="*", group=OUTPUTS)] = TrainOutputs(),
    targets: Annotated[TargetFilter, Parameter(name="*", group=FILTER)] = TargetFilter(),
    options: Annotated[TrainOptions, Parameter(name="*", group=FILTER)] = TrainOptions(),
    reading: Annotated[MeshReadOptions, Parameter(name="*", group=READING)] = MeshReadOptions(),
    run: Annotated[RunOptions, Parameter(name="*", group=RUN)] = RunOptions(),
) -> None:
    """Learn a filter from meshes of your own, whose detail you know how to tell from their forms.

    Give each mesh the parameters with which nmap bake --filter grnf shows the base you want; the learned filter then
    finds such bases in other meshes without any.

    Example: nmap train a.ply b.obj c.stl --sigma-s 3 --sigma-s 5 --sigma-s 4 -o mine.npz --state mine-state.npz

    Parameters
    ----------
    meshes:
        One or more: OBJ, PLY, STL, OFF, GLB or glTF.
    """
    from nmaptool.io.output.filter_models import TrainingFile, filter_outputs

    session = Session(run)
    if not meshes:
        raise UsageError("nothing to learn from: give one or more meshes, such as a.ply b.ply")
    if STREAM in meshes:
        raise UsageError("-: a mesh is read from a file, whose ending tells what it is")
    if outputs.output is None:
        raise UsageError("nothing to write: say where, such as -o filter.npz")
    to_stdout = str(outputs.report) == STREAM
    kept = TrainingFile(outputs.state)
    report = None if to_stdout else outputs.report
    files = filter_outputs(outputs.output, report=report, overwrite=outputs.overwrite, kept=kept)
    files.check()
    state = kept.begun()
    refuse_inputs(files.paths, meshes)
    filters = targets.of_each(len(meshes))
    import nmaptool as nm

    seconds = {}
    with session.progress() as progress:
        notify = progress or (lambda word, share: None)
        begun = time.perf_counter()
        examples = []
        for place, (name, target) in enumerate(zip(meshes, filters, strict=True)):
            notify("targets", _TARGETS * place / len(meshes))
            mesh = nm.read_mesh(name, unit=reading.unit, max_faces=reading.max_faces)
            examples.append(nm.training_example(mesh, target))
        seconds["targets"] = time.perf_counter() - begun
        model = nm.train(
            examples,
            options,
            state=state,
            keep=kept.keep,
            progress=lambda word, share: notify(word, _TARGETS + (1 - _TARGETS) * share),
        )
        seconds["training"] = time.perf_counter() - begun - seconds["targets"]
    metadata = {"version": nm.__version__, "filter": model.digest, "options": plain_values(options), **model.metadata}
    metadata["seconds"] = {stage: round(value, 4) for stage, value in seconds.items()}
    metadata["outputs"] = files.names
    files.write(model, metadata)
    kept.remove()
    if state is not None:
        session.say(f"  went on from {state.name}, where {len(state.losses)} networks were finished")
    _tell(session, examples, model)
    session.detail(f"  losses {' '.join(f'{loss:.2e}' for loss in model.metadata['losses'])}")
    session.detail(f"  seconds {', '.join(f'{stage} {value:.2f}' for stage, value in seconds.items())}")
    for name in files.names:
        session.say(f"  wrote {name}")
    if run.json or to_stdout:
        session.data(metadata)


def _tell(session: Session, examples: Sequence[nm.TrainingExample], model: nm.FilterModel) -> None:
    from nmaptool_cli.wording import describe_training

    for line in describe_training(examples, model):
        session.say(line)
