"""``nmap compose unpack``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from nmaptool.core.errors import UsageError
from nmaptool_cli.session import OUTPUTS, READING, RUN, STREAM, RunOptions, Session


@dataclass(frozen=True)
class UnpackOutputs:
    """What is written.

    Parameters
    ----------
    output:
        Folder for a map per layer, their masks, and recipe.toml, which nmap compose stack composes again. Made if
        missing.
    format:
        "exr" (floats) or "png" (16 bits).
    report:
        Full account as JSON; - for standard output.
    overwrite:
        Replace files that exist.
    """

    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None
    format: Literal["exr", "png"] = "exr"
    report: Path | None = None
    overwrite: bool = False


def unpack(
    workspace: str,
    /,
    *,
    outputs: Annotated[UnpackOutputs, Parameter(name="*", group=OUTPUTS)] = UnpackOutputs(),
    max_megapixels: Annotated[float, Parameter(group=READING)] = 270.0,
    run: Annotated[RunOptions, Parameter(name="*", group=RUN)] = RunOptions(),
) -> int:
    """Take a layered file apart after an editor's hand: repair what can be, and say what was done to it.

    Exit code 0: clean; 1: there are findings (the layers are written all the same).

    Example: nmap compose unpack work.psd -o edited, then nmap compose stack edited/recipe.toml -o result.exr

    Parameters
    ----------
    workspace:
        PSD, PSB, ORA, multi-page TIFF or multi-part EXR.
    max_megapixels:
        Of the canvas, and of all layers together; larger files are refused before any memory is taken.
    """
    from nmaptool.io.output.unpacked import UnpackedFiles

    session = Session(run)
    if workspace == STREAM:
        raise UsageError(f"{STREAM}: a workspace is read from a file; give its name")
    if not max_megapixels > 0:
        raise UsageError(f"--max-megapixels {max_megapixels:g}: must be greater than zero")
    if outputs.output is None:
        raise UsageError("nothing to write: say where, such as -o maps")
    to_stdout = run.json or str(outputs.report) == STREAM
    report = None if str(outputs.report) == STREAM else outputs.report
    UnpackedFiles(outputs.output, outputs.format, report, outputs.overwrite).check()
    import nmaptool as nm
    from nmaptool_cli.wording import describe_unpacked

    unpacked = nm.unpack(nm.read_workspace(workspace, max_megapixels=max_megapixels))
    metadata: dict[str, Any] = {"version": nm.__version__, **unpacked.to_dict()}
    written = nm.write_unpacked(
        unpacked,
        outputs.output,
        format=outputs.format,
        report=report,
        overwrite=outputs.overwrite,
        metadata=metadata,
    )
    if to_stdout:
        session.data({**metadata, "outputs": [str(path) for path in written]})
    elif not run.quiet:
        print("\n".join(describe_unpacked(unpacked)))
    for path in written:
        session.detail(f"  wrote {path}")
    session.say(f"  wrote {len(written)} files into {outputs.output}")
    return 1 if unpacked.findings else 0
