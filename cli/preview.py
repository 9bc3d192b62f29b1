"""``nmap preview``."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nmaptool.core.errors import UsageError
from nmaptool.core.units import Length
from nmaptool.options import MeshReadOptions, PreviewOptions, ReadOptions
from nmaptool.options.fields import Options, option
from nmaptool.options.length_kinds import LengthText
from nmaptool.options.plain_values import plain_values
from nmaptool_cli.command import command
from nmaptool_cli.outputs import ReportOutputs
from nmaptool_cli.run import Run
from nmaptool_cli.streams import display_name, refuse_stream

if TYPE_CHECKING:
    from nmaptool.core.progress import Progress
    from nmaptool.io.output.preview import DrawnPreview
    from nmaptool.io.output.transaction import Outputs


@dataclass(frozen=True)
class PreviewOutputs(ReportOutputs):
    """A picture or a film.

    Parameters
    ----------
    output:
        Picture (.png), or film (.webp, .gif or .mp4) with --turntable or --light-sweep.
    """

    output: Path | None = option(None, short="-o")

    def plan(self, options: PreviewOptions) -> Outputs[DrawnPreview]:
        """The file to write."""
        from nmaptool.io.output.preview import preview_outputs

        refuse_stream("a preview is written to a file, such as -o view.png", self.output)
        if self.output is None:
            raise UsageError("no output given: add one, such as -o view.png")
        return preview_outputs(self.output, options, **self.shared)


@dataclass(frozen=True)
class PreviewInputs(Options, group="Inputs"):
    """What the files do not say.

    Parameters
    ----------
    width:
        Width of height files that do not state the size of their pixels. Default: 100 mm on the longer side.
    """

    width: Length | None = option(None, LengthText("80mm", absolute=True, sets="the size of a pixel"))


@command(PreviewOutputs, PreviewInputs, PreviewOptions, ReadOptions, MeshReadOptions)
def preview(run: Run, /, *files: str) -> None:
    """Show reliefs in a material: pictures, perspective views, sections with mm axes, and films.

    Shadows and the shade of recesses are those of the heights. Several files become a contact sheet. Needs no OpenGL.

    Example: nmap preview coin.npy -o coin.png --material silver --view iso

    Parameters
    ----------
    files:
        One or more height files (.exr .tif .npy .png), normal maps, meshes ({meshes}), or recipes (.toml); - reads a
        picture from standard input.
    """
    options = run[PreviewOptions]
    if not files:
        raise UsageError("no files given: add one or more, such as coin.npy")
    if len(files) > 1 and options.is_film:
        name = "turntable" if options.turntable else "light_sweep"
        raise UsageError(f"`{name}`: a film shows one relief, and {len(files)} files are given; leave out the others")
    outputs = run[PreviewOutputs].plan(options)
    run.begin(outputs, files=files)
    from nmaptool.io.output.preview import drawn
    from nmaptool.io.previewed import read_previewed
    from nmaptool_cli.wording.previews import describe_drawn, describe_source

    width = run[PreviewInputs].width
    values: dict[str, Any] = {}
    found = []
    with run.work() as (names, progress):
        for given, name in zip(files, names["files"], strict=True):
            with run.reading():
                source = read_previewed(
                    name,
                    run[ReadOptions],
                    run[MeshReadOptions],
                    width_mm=None if width is None else width.to_mm(1.0, 1),
                    progress=progress,
                )
            label = _label(display_name(given), values)
            values[label] = source.value
            found.append({"name": display_name(given), "notes": list(source.notes)})
            describe_source(run, display_name(given), source)
        result = drawn(values if len(values) > 1 else next(iter(values.values())), options)
    describe_drawn(run, result, options)
    run.finish(outputs, result, run.header(inputs=found, options=plain_values(options)), watched=_watched)


def _watched(value: DrawnPreview, progress: Progress) -> DrawnPreview:
    return dataclasses.replace(value, progress=progress)


def _label(name: str, taken: Mapping[str, object]) -> str:
    """A file's name for the contact sheet; with its folder if another file has the same."""
    short = Path(name).name
    return short if short not in taken else name if name not in taken else f"{name} ({len(taken) + 1})"
