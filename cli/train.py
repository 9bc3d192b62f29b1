"""``nmap train``."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from nmaptool.core.errors import UsageError
from nmaptool.options import FilterOptions, MeshReadOptions, TrainOptions
from nmaptool.options.fields import option
from nmaptool.options.plain_values import plain_values
from nmaptool.types.shown import counted
from nmaptool_cli.command import command
from nmaptool_cli.inputs import ONLY_FILES, read_mesh
from nmaptool_cli.outputs import ReportOutputs
from nmaptool_cli.per_input import PerInput
from nmaptool_cli.run import Run
from nmaptool_cli.streams import refuse_stream

if TYPE_CHECKING:
    import nmaptool as nm
    from nmaptool.core.progress import Progress
    from nmaptool.io.output.filter_models import TrainingFile

# the targets' share of the progress bar
_TARGETS = 0.1
TARGETS = PerInput(
    FilterOptions, ("sigma_s", "sigma_r", "iterations"), "mesh meshes", base=FilterOptions(filter="grnf")
)


@dataclass(frozen=True)
class TrainOutputs(ReportOutputs):
    """A learned filter, and the state of its training.

    Parameters
    ----------
    output:
        Learned filter to write (.npz), for nmap bake --filter learned --model.
    state:
        File (.npz) for the state of an unfinished training. It is updated after every network; if it exists, training
        resumes from it with the same result. It is deleted once the filter is written.
    """

    output: Path | None = option(None, short="-o")
    state: Path | None = option(None)


@command(TrainOutputs, TrainOptions, MeshReadOptions, per_input=TARGETS)
def train(run: Run, /, *meshes: str) -> None:
    """Train a filter on your own meshes, whose detail you know how to separate.

    Give each mesh the parameters with which nmap bake --filter grnf shows the base you want. The learned filter then
    finds such bases in other meshes without parameters. Give --sigma-s, --sigma-r and --iterations once for all meshes,
    or once for each.

    Example: nmap train a.ply b.obj c.stl --sigma-s 3 --sigma-s 5 --sigma-s 4 -o mine.npz --state mine-state.npz

    Parameters
    ----------
    meshes:
        One or more mesh files: {meshes}.
    """
    from nmaptool.io.output.filter_models import TrainingFile, filter_outputs

    flags, options = run[TrainOutputs], run[TrainOptions]
    if not meshes:
        raise UsageError("no meshes given: add one or more, such as a.ply b.ply")
    refuse_stream(ONLY_FILES, *meshes)
    if flags.output is None:
        raise UsageError("no output given: add one, such as -o filter.npz")
    kept = TrainingFile(flags.state)
    outputs = filter_outputs(flags.output, kept=kept, **flags.shared)
    run.begin(outputs, meshes=meshes)
    kept.begun()
    filters = run.per_input(len(meshes))
    import nmaptool as nm
    from nmaptool_cli.wording.meshes import describe_training

    begun = time.perf_counter()
    with run.work() as (_, progress):
        examples = _examples(run, meshes, filters, progress)
        seconds = {"targets": time.perf_counter() - begun}
        model = _train(run, kept, examples, progress)
        seconds["training"] = time.perf_counter() - begun - seconds["targets"]
    describe_training(run, examples, model)
    run.seconds(seconds)
    metadata = {"version": nm.__version__, "filter": model.digest, "options": plain_values(options), **model.metadata}
    metadata["seconds"] = {stage: round(value, 4) for stage, value in seconds.items()}
    run.finish(outputs, model, metadata, done=kept.remove)


def _examples(
    run: Run, meshes: Sequence[str], filters: Sequence[FilterOptions], progress: Progress | None
) -> list[nm.TrainingExample]:
    import nmaptool as nm
    from nmaptool_cli.wording.meshes import describe_notes

    found = []
    for place, (name, target) in enumerate(zip(meshes, filters, strict=True)):
        if progress is not None:
            progress("targets", _TARGETS * place / len(meshes))
        mesh = read_mesh(run, name)
        describe_notes(run, mesh)
        found.append(nm.training_example(mesh, target))
    return found


def _train(
    run: Run, kept: TrainingFile, examples: list[nm.TrainingExample], progress: Progress | None
) -> nm.FilterModel:
    """Train the filter; an interrupted training is resumed."""
    import nmaptool as nm

    def notify(word: str, share: float) -> None:
        if progress is not None:
            progress(word, _TARGETS + (1 - _TARGETS) * share)

    state = kept.begun()
    if state is not None:
        run.say(f"  resumed from {state.name} with {counted(len(state.losses), 'network')} finished")
    return nm.train(examples, run[TrainOptions], state=state, keep=kept.keep, progress=notify)
