"""What every command that writes one normal map shares."""

from __future__ import annotations

import contextlib
import json
import shutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from nmaptool.core.errors import OutputError, UsageError
from nmaptool.io.unfinished import temporary_folder
from nmaptool.options import ReadOptions, WriteOptions
from nmaptool_cli.session import (
    STDOUT,
    STREAM,
    RunOptions,
    Session,
    display_name,
    refuse_inputs,
    standard_output,
)

if TYPE_CHECKING:
    import nmaptool as nm
    from nmaptool.io.output.maps import MapFiles
    from nmaptool.io.pictures.writer import Picture

_STREAMED = "map.exr"


@dataclass(frozen=True)
class MapOutputs:
    """What is written.

    Parameters
    ----------
    output:
        Normal map: .png, .exr or .tif; - writes EXR to standard output, for the next command.
    curl:
        Picture of where the map stops being a surface, .png: black is sound, yellow is torn.
    report:
        Full account of the run as JSON; - for standard output.
    overwrite:
        Replace files that exist.
    """

    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None
    curl: Path | None = None
    report: Path | None = None
    overwrite: bool = False


class MapWriter:
    """The outputs of one run, checked before any work is done.

    Parameters
    ----------
    session : Session
    outputs : MapOutputs
    options : WriteOptions
    run : RunOptions
    inputs : sequence of str
        Files that are read: none of them may be written.
    pictures : Path or None, by kind
        More pictures, .png.
    """

    def __init__(
        self,
        session: Session,
        outputs: MapOutputs,
        options: WriteOptions,
        run: RunOptions,
        inputs: tuple[str | None, ...],
        **pictures: Path | None,
    ) -> None:
        from nmaptool.io.output.maps import MapFiles

        if outputs.output is None:
            raise UsageError("nothing to write: say where, such as -o map.exr")
        beside = {"curl": outputs.curl, **pictures}
        self.session = session
        self.report_to_stdout = str(outputs.report) == STREAM or run.json
        self.map_to_stdout = str(outputs.output) == STREAM
        if any(str(path) == STREAM for path in beside.values()):
            raise UsageError("-: pictures are written to files, such as --curl curl.png")
        if self.map_to_stdout and self.report_to_stdout:
            raise UsageError("-: the map and the report cannot both go to standard output; give one of them a file")
        self.files: MapFiles = MapFiles(
            outputs.output,
            options,
            {kind: path for kind, path in beside.items() if path is not None},
            None if str(outputs.report) == STREAM else outputs.report,
            outputs.overwrite,
        )
        self._account: Mapping[str, Any] = {}
        with self._placed_files() as files:
            files.check()
        refuse_inputs(self.files.targets, inputs)

    @contextlib.contextmanager
    def _placed_files(self) -> Iterator[MapFiles]:
        """The files, with one in a temporary folder for the map that goes to standard output."""
        if not self.map_to_stdout:
            yield self.files
            return
        with temporary_folder() as folder:
            try:
                yield replace(self.files, output=folder / _STREAMED)
            except OutputError as error:  # nobody knows the temporary file
                raise OutputError(str(error).replace(str(folder / _STREAMED), STDOUT)) from None

    @property
    def named_targets(self) -> list[str]:
        """Every output as the user called it."""
        return [STDOUT if str(path) == STREAM else str(path) for path in self.files.targets]

    def write(
        self,
        normal_map: nm.NormalMap,
        pictures: Mapping[str, Callable[[], Picture]],
        metadata: Mapping[str, Any],
        recipe: str,
        attributes: Mapping[str, str] | None = None,
    ) -> None:
        """Write everything."""
        from nmaptool.io.output.maps import write_map_files

        self._account = {**metadata, "outputs": self.named_targets}
        with self._placed_files() as files:
            write_map_files(files, normal_map, pictures, self._account, recipe, attributes)
            if self.map_to_stdout:
                with files.output.open("rb") as made, standard_output() as stream:
                    shutil.copyfileobj(made, stream)

    def write_composition(
        self,
        composition: nm.Composition,
        metadata: Mapping[str, Any],
        recipe: str | None = None,
        attributes: Mapping[str, str] | None = None,
    ) -> None:
        """Write a composition, with its picture of where layers lie."""
        from nmaptool.io.output.maps import composition_recipe, placed_picture

        everything = {**metadata, **composition.report.to_dict()}
        recipe = composition_recipe(composition) if recipe is None else recipe
        pictures = {"placed": lambda: placed_picture(composition)}
        self.write(composition.normal_map, pictures, everything, recipe, attributes)

    def finish(self) -> None:
        """Say what was written; print the report where it goes to standard output."""
        for name in self.named_targets:
            self.session.say(f"  wrote {'the map to standard output' if name == STDOUT else name}")
        if self.report_to_stdout:
            self.session.data(self._account)


def read_map(file: str | None, reading: ReadOptions, like: nm.NormalMap | None = None) -> nm.NormalMap:
    """A normal map under the name that the user gave it."""
    import nmaptool as nm

    assert file is not None  # the map is no option
    normal_map = nm.read_normal_map(file, reading, like=like)
    name = display_name(normal_map.name)
    return normal_map if name == normal_map.name else replace(normal_map, name=name)


def say_map(session: Session, normal_map: nm.NormalMap) -> None:
    """How an input was read, in one line, and what speaks against it."""
    from nmaptool_cli.wording import describe_decoding

    name = normal_map.name
    share = float(normal_map.foreground.mean())
    session.say(f"{name}: {normal_map.frame}, {describe_decoding(normal_map.decoding, share)}")
    for warning in normal_map.decoding.warnings:
        session.warn(f"{name}: {warning}")


def say_composition(session: Session, composition: nm.Composition) -> None:
    """What was done, a line each."""
    from nmaptool_cli.wording import describe_composition

    for line in describe_composition(composition):
        session.say(line)
    for warning in composition.report.warnings:
        session.warn(warning)
    session.detail(f"  seconds {', '.join(f'{k} {v:.2f}' for k, v in composition.report.seconds.items())}")


def report_header(maps: tuple[nm.NormalMap, ...], **more: Any) -> dict[str, Any]:
    """The part of a report that says what was read."""
    from dataclasses import asdict

    from nmaptool._version import __version__

    inputs = [{"name": m.name, "cols": m.frame.cols, "rows": m.frame.rows, **asdict(m.decoding)} for m in maps]
    return {"version": __version__, "inputs": inputs, **json.loads(json.dumps(more, default=str))}
