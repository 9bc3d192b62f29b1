"""``nmap compose unpack``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from nmaptool.core.errors import UsageError
from nmaptool.options.fields import Options, choice_of, option
from nmaptool.options.kinds import Positive
from nmaptool_cli.command import command
from nmaptool_cli.mentions import in_flags
from nmaptool_cli.outputs import LayerFormat, ReportOutputs
from nmaptool_cli.run import Run
from nmaptool_cli.streams import STREAM


@dataclass(frozen=True)
class UnpackOutputs(ReportOutputs):
    """A folder of layers.

    Parameters
    ----------
    output:
        Folder for one map per layer, the masks, and recipe.toml, which nmap compose stack composes again. The folder is
        created if it is missing.
    format:
        Format of the maps: "exr" (float) or "png" (16 bit).
    """

    output: Path | None = option(None, short="-o")
    format: LayerFormat = option("exr", choice_of(LayerFormat))


@dataclass(frozen=True)
class UnpackReading(Options, group="Reading"):
    """How large a workspace may be.

    Parameters
    ----------
    max_megapixels:
        Refuse larger files before any memory is used. Applies to the canvas and to all layers together.
    """

    max_megapixels: float = option(270.0, Positive())


@command(UnpackOutputs, UnpackReading)
def unpack(run: Run, workspace: str, /) -> int:
    """Unpack a layered file after editing: repair what can be repaired and report what the editor changed.

    Exit code 0: no findings; 1: findings (the layers are written anyway).

    Example: nmap compose unpack work.psd -o edited, then nmap compose stack edited/recipe.toml -o result.exr

    Parameters
    ----------
    workspace:
        PSD, PSB, ORA, multi-page TIFF or multi-part EXR.
    """
    from nmaptool.io.output.unpacked import unpacked_outputs

    flags = run[UnpackOutputs]
    if workspace == STREAM:
        raise UsageError("-: a layered file cannot be read from standard input; give its name")
    if flags.output is None:
        raise UsageError("no output given: add one, such as -o maps")
    run.begin(unpacked_outputs(flags.output, format=flags.format, **flags.shared))
    import nmaptool as nm
    from nmaptool_cli.wording.edits import describe_unpacked

    unpacked = nm.unpack(nm.read_workspace(workspace, max_megapixels=run[UnpackReading].max_megapixels))
    outputs = unpacked_outputs(flags.output, unpacked, format=flags.format, **flags.shared)
    printed = flags.prints_report or run.options.json
    run.detail(*(f"  wrote {path}" for path in outputs.paths))
    written = [f"{len(outputs.paths)} files to {flags.output}"]
    run.finish(outputs, unpacked, {"version": nm.__version__, **unpacked.to_dict()}, written=written)
    if not (printed or run.options.quiet):
        print(in_flags("\n".join(describe_unpacked(unpacked))))
    return 1 if unpacked.findings else 0
