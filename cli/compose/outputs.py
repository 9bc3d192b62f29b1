"""What every command that writes one normal map shares."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from nmaptool.core.errors import UsageError
from nmaptool.options import ReadOptions, WriteOptions
from nmaptool_cli.session import (
    STDOUT,
    STREAM,
    RunOptions,
    Session,
    StandardOutput,
    display_name,
    refuse_inputs,
)

if TYPE_CHECKING:
    import nmaptool as nm
    from nmaptool.io.output.normal_map import WrittenMap


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
        from nmaptool.io.output.normal_map import map_outputs
        from nmaptool.io.output.targets import OutputStream

        if outputs.output is None:
            raise UsageError("nothing to write: say where, such as -o map.exr")
        beside = {"curl": outputs.curl, **pictures}
        self.session = session
        self.report_to_stdout = str(outputs.report) == STREAM or run.json
        map_to_stdout = str(outputs.output) == STREAM
        if any(str(path) == STREAM for path in beside.values()):
            raise UsageError("-: pictures are written to files, such as --curl curl.png")
        if map_to_stdout and self.report_to_stdout:
            raise UsageError("-: the map and the report cannot both go to standard output; give one of them a file")
        self.output = OutputStream(StandardOutput(), ".exr", STDOUT) if map_to_stdout else outputs.output
        report = None if str(outputs.report) == STREAM else outputs.report
        self.files = map_outputs(self.output, options, pictures=beside, report=report, overwrite=outputs.overwrite)
        self._account: Mapping[str, Any] = {}
        self.files.check()
        refuse_inputs(self.files.paths, inputs)

    def write(self, written: WrittenMap, metadata: Mapping[str, Any]) -> None:
        """Write everything."""
        self._account = {**metadata, "outputs": self.files.names}
        self.files.write(written, self._account)

    def write_composition(
        self, composition: nm.Composition, metadata: Mapping[str, Any], recipe: str | None = None
    ) -> None:
        """Write a composition, with its picture of where layers lie."""
        from nmaptool.io.output.composition import composed_map

        self.write(composed_map(composition, recipe), {**metadata, **composition.report.to_dict()})

    def finish(self) -> None:
        """Say what was written; print the report where it goes to standard output."""
        for name in self.files.names:
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
