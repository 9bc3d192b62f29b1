"""``nmap compare``."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from nmaptool.core.errors import UsageError
from nmaptool.options import CompareOptions, FilterOptions, MeshReadOptions, ReconstructOptions
from nmaptool_cli.learned import LearnedFilter
from nmaptool_cli.session import (
    CAMERA,
    FILTER,
    OUTPUTS,
    READING,
    REBUILDING,
    RUN,
    STREAM,
    RunOptions,
    Session,
    refuse_inputs,
)

if TYPE_CHECKING:
    import nmaptool as nm


@dataclass(frozen=True)
class FigureOutputs:
    """What is written.

    Parameters
    ----------
    output:
        Figure of both schemes: rebuilt meshes, vertex deviations, histograms, curves and the verdict, .png.
    report:
        All figures as JSON; - for standard output.
    overwrite:
        Replace files that exist.
    """

    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None
    report: Path | None = None
    overwrite: bool = False


def compare(
    mesh: str,
    /,
    *,
    outputs: Annotated[FigureOutputs, Parameter(name="*", group=OUTPUTS)] = FigureOutputs(),
    options: Annotated[CompareOptions, Parameter(name="*", group=CAMERA)] = CompareOptions(),
    rebuilding: Annotated[ReconstructOptions, Parameter(name="*", group=REBUILDING)] = ReconstructOptions(),
    filter: Annotated[FilterOptions, Parameter(name="*", group=FILTER)] = FilterOptions(),
    learned: Annotated[LearnedFilter, Parameter(name="*", group=FILTER)] = LearnedFilter(),
    reading: Annotated[MeshReadOptions, Parameter(name="*", group=READING)] = MeshReadOptions(),
    run: Annotated[RunOptions, Parameter(name="*", group=RUN)] = RunOptions(),
) -> None:
    """Compare gSfG with Poisson reconstruction on one mesh's base normals.

    Says how far vertices and normals are off by either, swept so that they are compared at equal normal deviation.

    Example: nmap compare bunny.obj -o figure.png --report figure.json

    Parameters
    ----------
    mesh:
        OBJ, PLY, STL, OFF, GLB or glTF.
    """
    from nmaptool.io.output.comparison import comparison_outputs

    session = Session(run)
    to_stdout = str(outputs.report) == STREAM
    files = comparison_outputs(
        outputs.output, report=None if to_stdout else outputs.report, overwrite=outputs.overwrite
    )
    if mesh == STREAM:
        raise UsageError("-: a mesh is read from a file, whose ending tells what it is")
    if str(outputs.output) == STREAM:
        raise UsageError("-: a figure is written to a file, such as -o figure.png")
    if not (files.places or run.json or to_stdout):
        raise UsageError("nothing to write: say where, such as -o figure.png")
    files.check()
    refuse_inputs(files.paths, [mesh])
    import nmaptool as nm

    with session.progress() as progress:
        model = learned.read()
        source = nm.read_mesh(mesh, unit=reading.unit, max_faces=reading.max_faces)
        comparison = nm.compare(source, options, filter, rebuilding, model=model, progress=progress)
    metadata: dict[str, Any] = {
        "version": nm.__version__,
        "files": {"mesh": mesh} | learned.files,
        "reading": asdict(reading),
        "outputs": files.names,
        "mm_per_unit": source.mm_per_unit,
        "unit_from": source.unit_from,
        **comparison.to_dict(),
    }
    files.write(comparison, metadata)
    _tell(session, comparison)
    for name in files.names:
        session.say(f"  wrote {name}")
    if run.json or to_stdout:
        session.data(metadata)


def _tell(session: Session, comparison: nm.Comparison) -> None:
    from nmaptool_cli.mesh_wording import describe_comparison, describe_curves

    for line in describe_comparison(comparison):
        session.say(line)
    for line in describe_curves(comparison):
        session.detail(line)
