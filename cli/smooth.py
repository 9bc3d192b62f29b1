"""``nmap smooth``."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from nmaptool.core.errors import UsageError
from nmaptool.options import FilterOptions, MeshReadOptions, ReconstructOptions, SmoothOptions
from nmaptool_cli.learned import LearnedFilter
from nmaptool_cli.session import (
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
class MeshOutputs:
    """What is written.

    Parameters
    ----------
    output:
        Repeatable. By ending: .stl .ply .obj in mm, .glb in metres. A mesh whose units are not known is taken to be in
        mm: its numbers stay. Faces keep their order.
    report:
        Full account of the run as JSON; - for standard output.
    overwrite:
        Replace files that exist.
    """

    output: Annotated[tuple[Path, ...], Parameter(name=["--output", "-o"])] = ()
    report: Path | None = None
    overwrite: bool = False


def smooth(
    mesh: str,
    /,
    *,
    outputs: Annotated[MeshOutputs, Parameter(name="*", group=OUTPUTS)] = MeshOutputs(),
    options: Annotated[SmoothOptions, Parameter(name="*", group=REBUILDING)] = SmoothOptions(),
    rebuilding: Annotated[ReconstructOptions, Parameter(name="*", group=REBUILDING)] = ReconstructOptions(),
    filter: Annotated[FilterOptions, Parameter(name="*", group=FILTER)] = FilterOptions(),
    learned: Annotated[LearnedFilter, Parameter(name="*", group=FILTER)] = LearnedFilter(),
    reading: Annotated[MeshReadOptions, Parameter(name="*", group=READING)] = MeshReadOptions(),
    run: Annotated[RunOptions, Parameter(name="*", group=RUN)] = RunOptions(),
) -> None:
    """Rebuild a mesh without its fine detail, or with more of it.

    What is finer than --sigma-s is detail; the vertices move until the faces look as without it, or with --detail-gain
    of it.

    Example: nmap smooth bunny.obj -o smooth.stl, or nmap smooth bunny.obj -o crisp.stl --detail-gain 2

    Parameters
    ----------
    mesh:
        OBJ, PLY, STL, OFF, GLB or glTF.
    """
    from nmaptool.io.output.mesh import mesh_metadata, mesh_outputs

    session = Session(run)
    to_stdout = str(outputs.report) == STREAM
    files = mesh_outputs(outputs.output, report=None if to_stdout else outputs.report, overwrite=outputs.overwrite)
    if mesh == STREAM:
        raise UsageError("-: a mesh is read from a file, whose ending tells what it is")
    if any(str(path) == STREAM for path in outputs.output):
        raise UsageError("-: a mesh is written to a file, such as -o smooth.stl")
    if not (files.places or run.json or to_stdout):
        raise UsageError("nothing to write: say where, such as -o smooth.stl")
    files.check()
    refuse_inputs(files.paths, [mesh])
    import nmaptool as nm

    with session.progress() as progress:
        model = learned.read()
        source = nm.read_mesh(mesh, unit=reading.unit, max_faces=reading.max_faces)
        smoothed = nm.smooth(source, options, filter, rebuilding, model=model, progress=progress)
    metadata: dict[str, Any] = {
        "version": nm.__version__,
        "files": {"mesh": mesh} | learned.files,
        "reading": asdict(reading),
        "outputs": files.names,
        "mm_per_unit": source.mm_per_unit,
        "unit_from": source.unit_from,
        **smoothed.report.to_dict(),
    }
    files.write(smoothed.mesh, mesh_metadata(smoothed.mesh, metadata))
    _tell(session, source, smoothed)
    for path in files.paths:
        session.say(f"  wrote {path}{_unit_of(path, source) if path in outputs.output else ''}")
    if run.json or to_stdout:
        session.data(metadata)


def _tell(session: Session, source: nm.Mesh, smoothed: nm.SmoothResult) -> None:
    from nmaptool_cli.mesh_wording import describe_reconstruction
    from nmaptool_cli.wording import describe_findings

    report = smoothed.report
    session.say(describe_findings(source, report.findings))
    for line in describe_reconstruction(report.reconstruction, report.detail_gain):
        session.say(line)
    for warning in report.warnings:
        session.warn(f"{source.name}: {warning}")
    session.detail(f"  moves {' '.join(f'{move:.1e}' for move in report.reconstruction.moves)} edges")
    session.detail(f"  seconds {', '.join(f'{k} {v:.2f}' for k, v in report.seconds.items())}")


def _unit_of(path: Path, source: nm.Mesh) -> str:
    if path.suffix.lower() == ".glb":
        return " (in metres)" if source.unit_from != "assumed" else " (in metres, the input's numbers taken as mm)"
    return " (in mm)" if source.unit_from != "assumed" else " (the numbers of the input)"
