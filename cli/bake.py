"""``nmap bake``."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from nmaptool.core.errors import UsageError
from nmaptool.options import BakeOptions, FilterOptions, MeshReadOptions
from nmaptool_cli.learned import LearnedFilter
from nmaptool_cli.session import CAMERA, FILTER, OUTPUTS, READING, RUN, STREAM, RunOptions, Session

if TYPE_CHECKING:
    import nmaptool as nm


@dataclass(frozen=True)
class LayerOutputs:
    """What is written.

    Parameters
    ----------
    output:
        Folder for original, base, detail, coverage and a contact sheet; or one file .exr that holds them all.
    format:
        Of the files in a folder: "exr" (float) or "png" (16 bit).
    plot:
        Figure of the residuals, the two Gaussians and the threshold, .png.
    curl:
        Picture of where the base stops being a surface, .png: black is sound, yellow is torn.
    report:
        Full account of the run as JSON; - for standard output.
    overwrite:
        Replace files that exist.
    """

    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None
    format: Literal["exr", "png"] = "exr"
    plot: Path | None = None
    curl: Path | None = None
    report: Path | None = None
    overwrite: bool = False


@dataclass(frozen=True)
class DrawnOutputs:
    """Layers beyond the normals.

    Parameters
    ----------
    depth:
        Also write the distance from the camera, in mm.
    faces:
        Also write the number of the face at each pixel.
    """

    depth: bool = False
    faces: bool = False


def bake(
    mesh: str,
    /,
    *,
    outputs: Annotated[LayerOutputs, Parameter(name="*", group=OUTPUTS)] = LayerOutputs(),
    drawn: Annotated[DrawnOutputs, Parameter(name="*", group=OUTPUTS)] = DrawnOutputs(),
    options: Annotated[BakeOptions, Parameter(name="*", group=CAMERA)] = BakeOptions(),
    filter: Annotated[FilterOptions, Parameter(name="*", group=FILTER)] = FilterOptions(),
    learned: Annotated[LearnedFilter, Parameter(name="*", group=FILTER)] = LearnedFilter(),
    reading: Annotated[MeshReadOptions, Parameter(name="*", group=READING)] = MeshReadOptions(),
    run: Annotated[RunOptions, Parameter(name="*", group=RUN)] = RunOptions(),
) -> None:
    """Draw a mesh as original, base and detail normal maps.

    The base keeps the forms, the detail what is finer than --sigma-s; nmap relief takes original and detail, or base.

    Example: nmap bake bunny.obj -o maps, then nmap relief maps/original.exr --detail maps/detail.exr -o bunny.stl

    Parameters
    ----------
    mesh:
        OBJ, PLY, STL, OFF, GLB or glTF.
    """
    from nmaptool.io.output.layers import layer_outputs

    session = Session(run)
    output, report, to_stdout = destination(outputs)
    if mesh == STREAM:
        raise UsageError("-: a mesh is read from a file, whose ending tells what it is")
    files = layer_outputs(
        output,
        format=outputs.format,
        depth=drawn.depth,
        faces=drawn.faces,
        plot=outputs.plot,
        report=report,
        curl=outputs.curl,
        views=options.views,
        overwrite=outputs.overwrite,
    )
    files.check()
    import nmaptool as nm

    with session.progress() as progress:
        model = learned.read()
        source = nm.read_mesh(mesh, unit=reading.unit, max_faces=reading.max_faces)
        layer_sets = nm.bake_views(source, options, filter, model=model, progress=progress)
    metadata: dict[str, Any] = {
        "version": nm.__version__,
        "files": {"mesh": mesh} | learned.files,
        "reading": asdict(reading),
        "outputs": files.names,
        "layers": [layers.report.to_dict() for layers in layer_sets],
    }
    files.write(layer_sets, metadata)
    _tell(session, source, layer_sets)
    say_written(session, files.paths)
    if run.json or to_stdout:
        session.data(metadata)


def destination(outputs: LayerOutputs) -> tuple[Path, Path | None, bool]:
    """Where layers go, the report's file, and whether the report goes to standard output."""
    if outputs.output is None:
        raise UsageError("nothing to write: say where, such as -o maps or -o maps.exr")
    if STREAM in (str(outputs.output), str(outputs.plot), str(outputs.curl)):
        raise UsageError("-: layers and pictures are written to files, such as -o maps")
    to_stdout = str(outputs.report) == STREAM
    return outputs.output, None if to_stdout else outputs.report, to_stdout


def say_written(session: Session, written: list[Path]) -> None:
    """The files, in one line a folder."""
    by_folder: dict[Path, list[str]] = {}
    for path in written:
        by_folder.setdefault(path.parent, []).append(path.name)
    for folder, names in by_folder.items():
        place = "" if folder == Path() else f"{folder}: "
        session.say(f"  wrote {folder / names[0] if len(names) == 1 else place + ' '.join(names)}")


def _tell(session: Session, source: nm.Mesh, layer_sets: tuple[nm.LayerSet, ...]) -> None:
    from nmaptool_cli.wording import describe_mesh, describe_split, describe_view

    first = layer_sets[0].report
    for line in (*describe_mesh(source, first), *describe_split(first)):
        session.say(line)
    for layers in layer_sets:
        session.say(describe_view(layers))
    for warning in dict.fromkeys(warning for layers in layer_sets for warning in layers.report.warnings):
        session.warn(f"{source.name}: {warning}")
    session.detail(f"  seconds {', '.join(f'{k} {v:.2f}' for k, v in first.seconds.items())}")
