"""The relief of a document as a file: the same steps as `nmap relief scene.toml`, so the same bytes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, get_args

from nmaptool.core.errors import UsageError
from nmaptool.core.progress import Progress
from nmaptool.io.output.relief import WrittenRelief, relief_outputs
from nmaptool.io.recipes.scenes import read_scene
from nmaptool.options import HeightsAt, ReadOptions
from nmaptool.options.formats import HEIGHT_FORMATS, MESH_FORMATS, RELIEF_FORMATS
from nmaptool.plates.wording import describe_plate
from nmaptool.reliefs.wording import advise
from nmaptool.solids.solid import solid
from nmaptool.solids.wording import count_triangles, describe_solid, warnings_of
from nmaptool.studio.document import Document
from nmaptool.types.relief import Relief
from nmaptool.types.solid import Solid

PREVIEW = "preview"


@dataclass(frozen=True)
class Wanted:
    """The file that a page asks for.

    Parameters
    ----------
    format : str
        An ending such as "stl", or "preview".
    at : str
        Where heights lie, as in `nmaptool.write_relief`.

    Raises
    ------
    UsageError
        If either is not known.
    """

    format: str
    at: HeightsAt = "centers"

    def __post_init__(self) -> None:
        known = [one["format"] for one in formats()]
        if self.format not in known:
            raise UsageError(f"{self.format!r}: a relief is written as {', '.join(known)}")
        if self.at not in get_args(HeightsAt):
            raise UsageError(f"`at={self.at!r}`: use one of {', '.join(get_args(HeightsAt))}")

    @property
    def ending(self) -> str:
        """The ending of the file."""
        return ".png" if self.format == PREVIEW else f".{self.format}"

    @property
    def kind(self) -> str:
        """The kind of file: "mesh", "heights" or "picture"."""
        if self.format == PREVIEW:
            return "picture"
        return "mesh" if self.ending in MESH_FORMATS and self.ending not in HEIGHT_FORMATS else "heights"


@dataclass(frozen=True)
class Exported:
    """What was written: facts and advice, and warnings, one line each, with options as in messages of the library."""

    notes: tuple[str, ...]
    warnings: tuple[str, ...]


def formats() -> list[dict[str, Any]]:
    """Return every kind of file for the page: meshes, heights, and the preview."""
    return [*_formats()]


def _formats() -> Iterator[dict[str, Any]]:
    for group, table in (("Mesh", MESH_FORMATS), ("Heights", HEIGHT_FORMATS)):
        for ending, entry in table.items():
            if RELIEF_FORMATS[ending] is entry and not entry.description.startswith("the same as"):
                yield {"format": ending[1:], "group": group, "description": entry.description}
    yield {"format": PREVIEW, "group": "Picture", "description": "PNG of the relief under two raking lights"}


def export(document: Document, path: Path, wanted: Wanted, progress: Progress | None = None) -> Exported:
    """Solve the document in full and write its relief.

    Parameters
    ----------
    document : Document
    path : Path
        With the ending of ``wanted``.
    wanted : Wanted
    progress : callable, optional
        Called with the stage and the share done, 0 to 1; an exception that it raises ends the export, and leaves no
        file.

    Raises
    ------
    NmaptoolError
        If a file cannot be read, the relief cannot be solved, or the file cannot be written.
    """
    if progress is not None:
        progress("reading", 0.0)
    scene = read_scene(document.recipe, progress=progress)
    result = scene.solve(progress)
    body = None
    if wanted.kind == "mesh":
        if progress is not None:
            progress("making triangles", 0.0)
        body = solid(result, scene.solid)
    preview = path if wanted.format == PREVIEW else None
    plan = relief_outputs([] if preview else [path], preview=preview, at=wanted.at)
    if progress is not None:
        progress("writing", 0.0)
    metadata = {**result.report.to_dict(), "reading": asdict(ReadOptions())}
    plan.write(WrittenRelief(result, body, progress), metadata)
    return _told(result, body, scene.composition.report.warnings)


def _told(result: Relief, body: Solid | None, warnings: tuple[str, ...]) -> Exported:
    notes = [*advise(result.report)]
    own: tuple[str, ...] = ()
    if result.plate is not None:
        notes = [*describe_plate(result.plate), *notes]
        own = result.plate.warnings
    if body is not None:
        thinned = [count_triangles(body)] if "max_error_mm" in body.facts else []
        notes = [*describe_solid(body), *thinned, *notes]
        own = (*own, *warnings_of(body))
    return Exported(tuple(notes), (*warnings, *result.report.warnings, *own))
