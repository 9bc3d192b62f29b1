"""Write the parts of a relief: a file for each, with an index and a plan of how they assemble."""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Protocol

from nmaptool._version import __version__
from nmaptool.core.errors import UsageError
from nmaptool.core.progress import Progress
from nmaptool.io.output.targets import Destination, OutputStream, exists_already, place_of
from nmaptool.io.output.transaction import Outputs, Target
from nmaptool.options.formats import MESH_FORMATS, check_ending
from nmaptool.options.parts import PartOptions
from nmaptool.options.solid import SolidOptions
from nmaptool.types.height import Height
from nmaptool.types.parts import Assembly, PlannedPart, assembly_of, placed_part
from nmaptool.types.picture import Frame
from nmaptool.types.relief import Relief
from nmaptool.types.solid import Solid

_FIELDS = ("{row}", "{col}")
ASSEMBLY_ENDINGS = (".json", ".png")


def is_template(place: Destination) -> bool:
    """Whether a name stands for the files of many parts."""
    return any(field in str(place) for field in _FIELDS) and not isinstance(place, OutputStream)


def file_of_part(template: str | Path, row: int, col: int) -> Path:
    """The file of a part, from a name with {row} and {col}.

    >>> file_of_part("{row}_{col}.stl", 0, 2).name
    '0_2.stl'
    """
    return Path(str(template).replace("{row}", str(row)).replace("{col}", str(col)))


def check_template(template: str | Path, what: str = "parts", endings: Iterable[str] | None = None) -> None:
    """Refuse a name that does not give each part its own file.

    Raises
    ------
    UsageError
    """
    path = Path(template)
    if any(field in str(path.parent) for field in _FIELDS):
        raise UsageError(f"{path}: write {{row}} and {{col}} into the file name, not into the folder's")
    missing = [field for field in _FIELDS if field not in path.name]
    if missing:
        raise UsageError(
            f"{path}: does not name {' and '.join(missing)}, so parts would share a file; write {{row}} and {{col}} "
            f"into the name, such as {{row}}_{{col}}{path.suffix}"
        )
    check_ending(path, tuple(MESH_FORMATS if endings is None else endings), what)


def earlier_parts(template: str | Path) -> list[Path]:
    """Files that exist under the names of parts, by row and column."""
    path = Path(template)
    text = re.escape(path.name).replace(r"\{row\}", r"(\d+)", 1).replace(r"\{col\}", r"(\d+)", 1)
    pattern = re.compile(text.replace(r"\{row\}", r"\d+").replace(r"\{col\}", r"\d+"))
    if not path.parent.is_dir():
        return []
    found = ((pattern.fullmatch(file.name), file) for file in path.parent.iterdir())
    return [file for _, file in sorted((tuple(map(int, match.groups())), file) for match, file in found if match)]


def check_free(templates: Iterable[str | Path], overwrite: bool) -> None:
    """Refuse to replace parts of an earlier run, before their number is known.

    Raises
    ------
    OutputError
    """
    for template in templates:
        earlier = earlier_parts(template)
        if earlier and not overwrite:
            raise exists_already(earlier[0])


def new_folders(templates: Iterable[str | Path]) -> list[Path]:
    """Folders of parts, which are created if they are missing."""
    folders = dict.fromkeys(Path(template).parent for template in templates)
    return [folder for folder in folders if folder != Path()]


@dataclass(frozen=True, eq=False)
class CutRelief:
    """A relief in parts.

    Attributes
    ----------
    relief : Height or Relief
    frame : Frame
        Of the whole, in the pixels of the parts.
    options : PartOptions
    parts : sequence of (PlannedPart, Solid or None)
        None for parts that hold nothing of the relief.
    templates : sequence of str
        Names of the files, with {row} and {col}.
    """

    relief: Height | Relief
    frame: Frame
    options: PartOptions
    parts: Sequence[tuple[PlannedPart, Solid | None]]
    templates: Sequence[str]

    @classmethod
    def of(
        cls, relief: Height | Relief, options: PartOptions, solid: SolidOptions, templates: Sequence[str]
    ) -> CutRelief:
        """Cut a relief in memory."""
        from nmaptool.solids.cutting.cut import cut_relief

        frame, parts = cut_relief(relief, options, solid)
        return cls(relief, frame, options, list(parts), templates)

    @property
    def solids(self) -> list[Solid]:
        """The parts that hold something."""
        return [solid for _, solid in self.parts if solid is not None]

    @cached_property
    def assembly(self) -> Assembly:
        """Which part goes where, with the names of its files."""
        frame, origin = self.frame, self.options.part_origin
        placed = {
            (part.row, part.col): placed_part(
                part, frame, origin, solid, [file_of_part(each, part.row, part.col).name for each in self.templates]
            )
            for part, solid in self.parts
            if solid is not None
        }
        return assembly_of(frame, origin, [part for part, _ in self.parts], placed)


class Written(Protocol):
    """What the writers of parts need of the value that is written."""

    @property
    def cut(self) -> CutRelief | None:
        """The parts."""

    @property
    def progress(self) -> Progress | None:
        """What is told the progress."""


def part_targets(cut: CutRelief) -> list[Target[Written]]:
    """A file for each part and name; parts that hold nothing have none."""
    made = [(part, solid) for part, solid in cut.parts if solid is not None]
    count = len(made) * len(cut.templates)
    return [
        Target(
            file_of_part(template, part.row, part.col),
            "a part",
            tuple(MESH_FORMATS),
            _PartWriter(solid, f"part {part.row}, {part.col}", at * len(made) + number, count),
        )
        for at, template in enumerate(cut.templates)
        for number, (part, solid) in enumerate(made)
    ]


@dataclass(frozen=True, eq=False)
class _PartWriter:
    """Writes one part; reports its share of the progress of all."""

    solid: Solid
    title: str
    number: int
    count: int

    def __call__(self, written: Written, path: Path) -> None:
        from nmaptool.io.solids.writer import write_solid

        progress = written.progress

        def shared(stage: str, share: float) -> None:
            assert progress is not None
            progress(stage, (self.number + share) / self.count)

        write_solid(self.solid, path, title=self.title, progress=None if progress is None else shared)


def assembly_targets(places: Iterable[Destination]) -> list[Target[Written]]:
    """The index and the picture of an assembly."""
    return [Target(place_of(place), "an assembly", ASSEMBLY_ENDINGS, _write_assembly) for place in places]


def _write_assembly(written: Written, path: Path) -> None:
    cut = written.cut
    assert cut is not None  # checked with the options
    write_assembly_file(cut.assembly, path, cut.relief)


def write_assembly_file(assembly: Assembly, path: Path, relief: Height | Relief | None = None) -> None:
    """Write the index (.json) or the picture (.png) of an assembly.

    Parameters
    ----------
    assembly : Assembly
    path : Path
    relief : Height or Relief, optional
        For the picture, possibly with fewer pixels.
    """
    if path.suffix.lower() == ".json":
        text = json.dumps({"version": __version__, **assembly.to_dict()}, indent=2)
        path.write_text(text + "\n", encoding="utf-8", newline="\n")
        return
    from nmaptool.figures.assembly import assembly_picture
    from nmaptool.figures.preview import preview
    from nmaptool.io.pictures.writer import write_image

    below = None if relief is None else preview(relief)
    write_image(assembly_picture(assembly, below), path, ("R", "G", "B"), {"kind": "assembly", "version": __version__})


@dataclass(frozen=True, eq=False)
class _Parts:
    """Parts alone."""

    cut: CutRelief
    progress: Progress | None = None


def write_parts(
    relief: Height | Relief,
    outputs: str | Path | Sequence[str | Path],
    options: PartOptions,
    solid: SolidOptions | None = None,
    *,
    assembly: Sequence[Destination] = (),
    overwrite: bool = False,
) -> Assembly:
    """Cut a relief into parts that fit each other, and write each to its own file: all of them appear, or none.

    Parameters
    ----------
    relief : Height or Relief
    outputs : str, Path or sequence of them
        Names with {row} and {col}, such as ``parts/{row}_{col}.stl``; the extension sets the format: .stl .ply .obj
        .glb .3mf. The folder is created if missing. Files are read back and checked.
    options : PartOptions
    solid : SolidOptions, optional
        Default: open surfaces.
    assembly : sequence of str, Path or OutputStream
        Index (.json) and picture (.png) of the parts: which goes where.
    overwrite : bool
        Replace files that exist.

    Returns
    -------
    Assembly
        Where each part lies and how large it is, and which parts are left out.

    Raises
    ------
    UsageError
        If a name does not have {row} and {col}, or an extension is not supported; as `nmaptool.parts`.
    InputError
        As `nmaptool.parts`.
    OutputError
        If a file cannot be written or fails its check, or exists and ``overwrite`` is False.

    Examples
    --------
    >>> height = nm.Height(np.zeros((3, 5)), np.ones((2, 4), bool), nm.Frame(2, 4, pitch_mm=0.5))
    >>> made = nm.write_parts(height, "{row}_{col}.stl", nm.PartOptions(parts="2x1"))
    >>> [part.files for part in made.parts]
    [('0_0.stl',), ('0_1.stl',)]
    """
    templates = [str(output) for output in ([outputs] if isinstance(outputs, str | Path) else outputs)]
    check_templates(templates, overwrite)
    plan: Outputs[_Parts] = Outputs(assembly_targets(assembly), None, overwrite, new_folders(templates))
    plan.check()
    cut = CutRelief.of(relief, options, solid or SolidOptions(), templates)
    dataclasses.replace(plan, targets=[*part_targets(cut), *plan.targets]).write(_Parts(cut))
    return cut.assembly


def check_templates(templates: Sequence[str], overwrite: bool) -> None:
    """Refuse names that are not for parts, and those of parts that exist, before their number is known.

    Raises
    ------
    UsageError, OutputError
    """
    for template in templates:
        check_template(template)
    check_free(templates, overwrite)
