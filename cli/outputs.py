"""Output flags that several commands share."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, Literal, cast

from nmaptool.core.errors import UsageError
from nmaptool.options import WriteOptions
from nmaptool.options.fields import Options, choice_of, option
from nmaptool.options.formats import NORMAL_MAP_FORMATS
from nmaptool.options.kinds import Kind, Switch
from nmaptool_cli.streams import STDOUT, STREAM, StandardOutput, refuse_stream

if TYPE_CHECKING:
    import nmaptool as nm
    from nmaptool.io.output.normal_map import WrittenMap
    from nmaptool.io.output.transaction import Outputs

LayerFormat = Literal["exr", "png"]


@dataclass(frozen=True)
class FileOf(Kind):
    """A file whose ending is in a table of formats, which the help lists."""

    formats: Callable[[], Mapping[str, Any]] = dict

    def meanings(self) -> str:
        """As `Kind.meanings`."""
        return "; ".join(f"{ending} {entry.description}" for ending, entry in self.formats().items()) + "."


@dataclass(frozen=True)
class ReportOutputs(Options, group="Outputs"):
    """The report, and whether files may be replaced.

    Parameters
    ----------
    report:
        Write a full report of the run as JSON; - writes it to standard output.
    overwrite:
        Replace existing files.
    """

    report: Path | None = option(None)
    overwrite: bool = option(False, Switch())

    @property
    def prints_report(self) -> bool:
        """Whether the report goes to standard output."""
        return str(self.report) == STREAM

    @property
    def shared(self) -> dict[str, Any]:
        """The arguments ``report`` and ``overwrite`` of every plan of outputs."""
        return {"report": None if self.prints_report else self.report, "overwrite": self.overwrite}


@dataclass(frozen=True)
class MapOutputs(ReportOutputs):
    """A normal map and a picture of its curl.

    Parameters
    ----------
    output:
        Normal map to write; - writes EXR to standard output, for the next command. The ending sets the format:
    curl:
        Picture of the curl (.png): black where the normals form a surface, yellow where they do not.
    """

    output: Path | None = option(None, FileOf(formats=lambda: NORMAL_MAP_FORMATS), short="-o")
    curl: Path | None = option(None)

    def plan(self, writing: WriteOptions, prints_json: bool, **pictures: Path | None) -> Outputs[WrittenMap]:
        """The files to write; more pictures by kind."""
        from nmaptool.io.output.normal_map import map_outputs
        from nmaptool.io.output.targets import OutputStream

        if self.output is None:
            raise UsageError("no output given: add one, such as -o map.exr")
        beside = {"curl": self.curl, **pictures}
        refuse_stream("pictures are written to files, such as --curl curl.png", *beside.values())
        to_stdout = str(self.output) == STREAM
        if to_stdout and (prints_json or self.prints_report):
            raise UsageError("-: the map and the report cannot both go to standard output; write one of them to a file")
        place = OutputStream(cast("BinaryIO", StandardOutput()), ".exr", STDOUT) if to_stdout else self.output
        return map_outputs(place, writing, pictures=beside, **self.shared)


@dataclass(frozen=True)
class PlacedOutputs(MapOutputs):
    """A composed normal map with pictures of its curl and of the area that layers cover.

    Parameters
    ----------
    placed:
        Picture (.png) of the area that the layers above the lowest cover. Give it to nmap relief as --mask to let the
        background keep its own height.
    walls:
        Picture (.png) of the area of the layers with edge "wall". Give it to nmap relief --edge wall as --wall-mask.
    """

    placed: Path | None = option(None)
    walls: Path | None = option(None)

    def check_walls(self, composition: nm.Composition) -> None:
        """Refuse a picture of walls where no layer has any.

        Raises
        ------
        UsageError
        """
        if self.walls is not None and (composition.walls is None or not composition.walls.any()):
            raise UsageError(f"{self.walls}: no layer has walls; give one `edge='wall'`")


@dataclass(frozen=True)
class LayerOutputs(ReportOutputs):
    """Layers in a folder or in one file.

    Parameters
    ----------
    output:
        Folder for the original, base, detail and coverage maps and a contact sheet, or one .exr file with all the maps.
    format:
        Format of the files in a folder: "exr" (float) or "png" (16 bit).
    plot:
        Figure (.png) of the residuals, the two Gaussians and the threshold.
    curl:
        Picture of the curl (.png): black where the base normals form a surface, yellow where they do not.
    """

    output: Path | None = option(None, short="-o")
    format: LayerFormat = option("exr", choice_of(LayerFormat))
    plot: Path | None = option(None)
    curl: Path | None = option(None)

    def plan(self, **more: Any) -> Outputs[Any]:
        """The files to write; ``more`` as in `nmaptool.io.output.layers.layer_outputs`."""
        from nmaptool.io.output.layers import layer_outputs

        if self.output is None:
            raise UsageError("no output given: add one, such as -o maps or -o maps.exr")
        refuse_stream("layers and pictures are written to files, such as -o maps", self.output, self.plot, self.curl)
        return layer_outputs(self.output, format=self.format, plot=self.plot, curl=self.curl, **more, **self.shared)


def by_folder(paths: list[Path]) -> Iterator[str]:
    """Files as messages list them: one line per folder."""
    folders: dict[Path, list[str]] = {}
    for path in paths:
        folders.setdefault(path.parent, []).append(path.name)
    for folder, names in folders.items():
        place = "" if folder == Path() else f"{folder}: "
        yield str(folder / names[0]) if len(names) == 1 else place + " ".join(names)


def as_given(path: Path) -> str:
    """The text of a path or URL: a path has only one slash after the scheme."""
    return re.sub(r"^(\w{2,}):[/\\](?![/\\])", r"\1://", str(path))
