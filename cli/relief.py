"""``nmap relief``."""

from __future__ import annotations

import contextlib
import dataclasses
import time
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nmaptool.core.errors import InputError, UsageError
from nmaptool.options import HeightsAt, ReadOptions, ReliefOptions, SolidOptions
from nmaptool.options.fields import Options, choice_of, option
from nmaptool.options.formats import MESH_FORMATS, RELIEF_FORMATS
from nmaptool.options.kinds import Switch
from nmaptool.options.plain_values import plain_values
from nmaptool_cli.command import command
from nmaptool_cli.inputs import read_grey, read_map
from nmaptool_cli.outputs import FileOf, ReportOutputs
from nmaptool_cli.run import Run
from nmaptool_cli.streams import refuse_stream

if TYPE_CHECKING:
    import nmaptool as nm
    from nmaptool.core.progress import Progress
    from nmaptool.io.output.relief import WrittenRelief
    from nmaptool.io.output.transaction import Outputs

# names of the inputs in the library's error messages, by role
_CALLED = {
    "mask": "the mask",
    "mu_map": "the mu map",
    "beta_map": "the beta map",
    "delta_map": "the delta map",
    "wall_mask": "the wall mask",
    "surface": "the curved background",
}


@dataclass(frozen=True)
class ReliefInputs(Options, group="Inputs"):
    """Files besides the map.

    Parameters
    ----------
    detail:
        Detail map of the same size. --mu sets how strongly its detail is kept or exaggerated.
    mask:
        Grey picture, white where the motif is. Default: found from the map's own background.
    surface:
        Curved background for --background surface: a normal map, or heights in mm (.exr .tif .npy).
    mu_map:
        Grey picture that multiplies mu per pixel.
    beta_map:
        Grey picture that multiplies beta per pixel.
    delta_map:
        Grey picture that multiplies delta per pixel.
    wall_mask:
        Grey picture, white where the motif stands with the walls of --edge wall; the rest runs down into the plate.
        Default: all of it. nmap compose stack --walls writes one for layers with edge = "wall".
    """

    detail: str | None = option(None)
    mask: str | None = option(None)
    surface: str | None = option(None)
    mu_map: str | None = option(None)
    beta_map: str | None = option(None)
    delta_map: str | None = option(None)
    wall_mask: str | None = option(None)


@dataclass(frozen=True)
class ReliefOutputs(ReportOutputs):
    """Heights, meshes and a preview.

    Parameters
    ----------
    output:
        Heights or mesh to write; repeat the flag for several files. The ending sets the format:
    preview:
        Picture (.png) of the relief under two raking lights.
    at:
        Where height files hold heights: at pixel "centers", as a picture of the relief, or at pixel "corners", with one
        more row and column. "corners" loses nothing and can be read back exactly as --surface.
    dry_run:
        Solve, and print size, triangles and file sizes, but write no files.
    """

    output: tuple[Path, ...] = option((), FileOf(formats=lambda: RELIEF_FORMATS), short="-o")
    preview: Path | None = option(None)
    at: HeightsAt = option("centers", choice_of(HeightsAt))
    dry_run: bool = option(False, Switch())

    @property
    def meshes(self) -> list[Path]:
        """The outputs that hold triangles."""
        return [path for path in self.output if path.suffix.lower() in MESH_FORMATS]

    def plan(self, prints_json: bool, solid: SolidOptions) -> Outputs[WrittenRelief]:
        """The files to write."""
        from nmaptool.io.output.relief import relief_outputs

        refuse_stream("a relief or a preview is written to a file, such as -o relief.stl", *self.output, self.preview)
        if not (self.output or self.preview or self.report or prints_json):
            raise UsageError("no output given: add one, such as -o relief.stl --preview relief.png")
        if solid != SolidOptions() and not self.meshes:
            given = next(f.name for f in dataclasses.fields(solid) if getattr(solid, f.name) != f.default)
            raise UsageError(f"`{given}`: is for meshes; name one, such as -o relief.3mf")
        return relief_outputs(self.output, preview=self.preview, at=self.at, **self.shared)


@command(ReliefInputs, ReliefOutputs, ReliefOptions, SolidOptions, ReadOptions)
def relief(run: Run, map: str, /) -> None:
    """Make a relief in millimetres from one or two normal maps.

    The original map with --detail keeps both shape and detail; a base map alone keeps only the structure.

    Example: nmap relief lion.png -o lion.stl --preview lion-view.png --height 4mm --width 80mm

    Parameters
    ----------
    map:
        Original or base normal map: {pictures}; FILE.exr:layer reads one layer; - reads standard input.
    """
    inputs = asdict(run[ReliefInputs])
    given = run[ReliefOutputs]
    outputs = given.plan(run.options.json, run[SolidOptions])
    run.begin(outputs, original=map, **inputs)
    import nmaptool as nm
    from nmaptool.io.output.relief import WrittenRelief
    from nmaptool_cli.wording.reliefs import describe_relief
    from nmaptool_cli.wording.solids import describe_solid

    with run.work() as (files, progress), _named_inputs(inputs):
        maps, result = _solve(run, files, progress)
        solid = nm.solid(result, run[SolidOptions]) if given.meshes else None
    describe_relief(run, maps, result)
    if solid is not None:
        describe_solid(run, solid, given.meshes)
    read = [{"name": m.name, "cols": m.frame.cols, "rows": m.frame.rows, **asdict(m.decoding)} for m in maps]
    metadata = run.header(inputs=read, reading=asdict(run[ReadOptions]), **result.report.to_dict())
    if solid is not None:
        metadata["solid"] = {"options": plain_values(run[SolidOptions]), **solid.to_dict()}
    if given.dry_run:
        run.say("  nothing written (--dry-run)")
        run.finish(dataclasses.replace(outputs, targets=(), report=None), WrittenRelief(result), metadata)
        return
    written = [f"{path}{_png_range(path, result) if path in given.output else ''}" for path in outputs.paths]

    def watched(value: WrittenRelief, progress: Progress) -> WrittenRelief:
        return dataclasses.replace(value, progress=progress)

    run.finish(outputs, WrittenRelief(result, solid), metadata, written=written, watched=watched)


def _solve(run: Run, files: Mapping[str, Any], progress: Progress | None) -> tuple[list[nm.NormalMap], nm.Relief]:
    """Read the inputs and solve; returns the maps that were read, the original first, and the relief."""
    import nmaptool as nm

    started = time.perf_counter()
    original = read_map(run, files["original"])
    detail = None
    if files["detail"] is not None:
        detail = read_map(run, files["detail"], like=original, own_layer=False)
    surface = None
    if files["surface"] is not None:
        pitch_mm, _ = nm.pitch_of(original, run[ReliefOptions])
        reading = dataclasses.replace(run[ReadOptions], layer=None)
        surface = nm.read_surface(files["surface"], reading, like=original, pitch_mm=pitch_mm)
    greys = {role: read_grey(run, files[role]) for role in ("mask", "mu_map", "beta_map", "delta_map", "wall_mask")}
    read_s = time.perf_counter() - started
    result = nm.relief(original, detail, surface=surface, **greys, options=run[ReliefOptions], progress=progress)
    report = dataclasses.replace(result.report, seconds={"reading": read_s, **result.report.seconds})
    maps = [each for each in (original, detail, surface) if isinstance(each, nm.NormalMap)]
    return maps, dataclasses.replace(result, report=report)


@contextlib.contextmanager
def _named_inputs(inputs: Mapping[str, str | None]) -> Iterator[None]:
    """Add the file name to errors about the mask or a weight map."""
    try:
        yield
    except InputError as error:
        text = str(error)
        for role, called in _CALLED.items():
            if inputs[role] is not None:
                text = text.replace(called, f"{called} {inputs[role]}", 1)
        raise InputError(text) from None


def _png_range(path: Path, result: nm.Relief) -> str:
    low, high = result.height.range_mm
    return f" (black {low:.3f} mm, white {high:.3f} mm)" if path.suffix.lower() == ".png" else ""
