"""``nmap relief``."""

from __future__ import annotations

import contextlib
import dataclasses
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from nmaptool.core.errors import InputError, UsageError
from nmaptool.core.units import memory_text
from nmaptool.options import ReadOptions, ReliefOptions
from nmaptool_cli.session import (
    INPUTS,
    OUTPUTS,
    READING,
    RELIEF,
    RUN,
    STREAM,
    RunOptions,
    Session,
    display_name,
    input_files,
    refuse_inputs,
)

if TYPE_CHECKING:
    import nmaptool as nm


@dataclass(frozen=True)
class ReliefInputs:
    """Files beside the map.

    Parameters
    ----------
    detail:
        Detail map of the same size: its detail is kept or exaggerated by --mu.
    mask:
        Grey picture, white where the motif is. Default: what the map's own background tells.
    surface:
        Curved background for --background surface: a normal map, or heights in mm (.exr .tif .npy).
    mu_map:
        Grey picture that multiplies mu per pixel.
    beta_map:
        Grey picture that multiplies beta per pixel.
    delta_map:
        Grey picture that multiplies delta per pixel.
    """

    detail: str | None = None
    mask: str | None = None
    surface: str | None = None
    mu_map: str | None = None
    beta_map: str | None = None
    delta_map: str | None = None


@dataclass(frozen=True)
class ReliefOutputs:
    """What is written.

    Parameters
    ----------
    output:
        Repeatable. By ending: .exr .tif .npy heights in mm; .png 16-bit heights; .stl .ply .obj surface in mm, .glb in
        metres.
    preview:
        Picture of the relief under two raking lights, .png.
    report:
        Full account of the run as JSON; - for standard output.
    overwrite:
        Replace files that exist.
    """

    output: Annotated[tuple[Path, ...], Parameter(name=["--output", "-o"])] = ()
    preview: Path | None = None
    report: Path | None = None
    overwrite: bool = False


@contextlib.contextmanager
def named_inputs(inputs: ReliefInputs) -> Iterator[None]:
    """Errors that speak of the mask or a weight map name its file."""
    try:
        yield
    except InputError as error:
        text = str(error)
        for words, file in (
            ("the mask", inputs.mask),
            ("the mu map", inputs.mu_map),
            ("the beta map", inputs.beta_map),
            ("the delta map", inputs.delta_map),
            ("the curved background", inputs.surface),
        ):
            if file is not None:
                text = text.replace(words, f"{words} {file}", 1)
        raise InputError(text) from None


def relief(
    map: str,
    /,
    *,
    inputs: Annotated[ReliefInputs, Parameter(name="*", group=INPUTS)] = ReliefInputs(),
    outputs: Annotated[ReliefOutputs, Parameter(name="*", group=OUTPUTS)] = ReliefOutputs(),
    options: Annotated[ReliefOptions, Parameter(name="*", group=RELIEF)] = ReliefOptions(),
    reading: Annotated[ReadOptions, Parameter(name="*", group=READING)] = ReadOptions(),
    run: Annotated[RunOptions, Parameter(name="*", group=RUN)] = RunOptions(),
) -> None:
    """Make a relief in millimetres from one or two normal maps.

    With the original map and --detail, shape and detail are both kept; with a base map alone, the structure.

    Example: nmap relief lion.png -o lion.stl --preview lion-view.png --height 4mm --width 80mm

    Parameters
    ----------
    map:
        Original or base normal map: PNG, EXR, TIFF, JPEG or BMP; FILE.exr:layer names a layer; - reads standard input.
    """
    from nmaptool.io.output.relief import ReliefFiles

    session = Session(run)
    to_stdout = str(outputs.report) == STREAM
    files = ReliefFiles(
        outputs.output, outputs.preview, None if to_stdout else outputs.report, overwrite=outputs.overwrite
    )
    if any(str(path) == STREAM for path in (*outputs.output, outputs.preview)):
        raise UsageError("-: a relief or a preview is written to a file, such as -o relief.stl")
    if not (files.targets or run.json or to_stdout):
        raise UsageError("nothing to write: say where, such as -o relief.stl --preview relief.png")
    files.check()
    names = (map, inputs.detail, inputs.mask, inputs.surface, inputs.mu_map, inputs.beta_map, inputs.delta_map)
    refuse_inputs(files.targets, names)
    with input_files(*names) as sources, named_inputs(inputs):
        result, metadata = _solve(session, sources, options, reading)
    import nmaptool as nm

    roles = ("original", "detail", "mask", "surface", "mu_map", "beta_map", "delta_map")
    metadata["files"] = {role: name for role, name in zip(roles, names, strict=True) if name is not None}
    metadata["reading"] = asdict(reading)
    metadata["outputs"] = [str(path) for path in files.targets]
    nm.write_relief(
        result, *files.outputs, preview=files.preview, report=files.report, overwrite=files.overwrite, metadata=metadata
    )
    for path in files.targets:
        session.say(f"  wrote {path}{_png_range(path, result) if path in files.outputs else ''}")
    if run.json or to_stdout:
        session.data(metadata)


def _png_range(path: Path, result: nm.Relief) -> str:
    low, high = result.height.range_mm
    return f" (black {low:.3f} mm, white {high:.3f} mm)" if path.suffix.lower() == ".png" else ""


def _solve(
    session: Session, sources: list[str | None], options: ReliefOptions, reading: ReadOptions
) -> tuple[nm.Relief, dict[str, Any]]:
    """Read the inputs, solve, say what was done; also the account for the report."""
    import nmaptool as nm

    source, detail_source, mask, surface_source, mu_map, beta_map, delta_map = sources
    assert source is not None
    started = time.perf_counter()
    with session.progress() as progress:
        original = nm.read_normal_map(source, reading)
        others = dataclasses.replace(reading, layer=None)
        detail = None if detail_source is None else nm.read_normal_map(detail_source, others, like=original)
        surface = None
        if surface_source is not None:
            pitch_mm, _ = nm.pitch_of(original, options)
            surface = nm.read_surface(surface_source, others, like=original, pitch_mm=pitch_mm)

        def grey(path: str | None) -> Any:
            return None if path is None else nm.read_grey(path, max_megapixels=reading.max_megapixels)

        maps = {"mask": mask, "mu_map": mu_map, "beta_map": beta_map, "delta_map": delta_map}
        greys = {role: grey(path) for role, path in maps.items()}
        read_s = time.perf_counter() - started
        result = nm.relief(original, detail, surface=surface, **greys, options=options, progress=progress)
    report = dataclasses.replace(result.report, seconds={"reading": read_s, **result.report.seconds})
    result = dataclasses.replace(result, report=report)
    read = [
        dataclasses.replace(m, name=display_name(m.name))
        for m in (original, detail, surface)
        if isinstance(m, nm.NormalMap)
    ]
    _tell(session, read, nm.diagnose(original), result)
    inputs = [{"name": m.name, "cols": m.frame.cols, "rows": m.frame.rows, **asdict(m.decoding)} for m in read]
    return result, {"version": nm.__version__, "inputs": inputs, **result.report.to_dict()}


def _tell(session: Session, maps: list[nm.NormalMap], diagnose: tuple[str, ...], result: nm.Relief) -> None:
    from nmaptool_cli.wording import describe_decoding, describe_relief

    for each in maps:
        share = float(each.foreground.mean())
        session.say(f"{each.name}: {each.frame}, {describe_decoding(each.decoding, share)}")
        for warning in each.decoding.warnings:
            session.warn(f"{each.name}: {warning}")
    for doubt in diagnose:
        session.warn(f"{maps[0].name}: {doubt}")
    for line in describe_relief(result.report):
        session.say(line)
    for warning in result.report.warnings:
        session.warn(warning)
    session.detail(f"  memory planned for the solver {memory_text(result.report.planned_bytes)}")
    session.detail(f"  residuals {' '.join(f'{r:.1e}' for r in result.report.history)}")
    session.detail(f"  seconds {', '.join(f'{k} {v:.2f}' for k, v in result.report.seconds.items())}")
