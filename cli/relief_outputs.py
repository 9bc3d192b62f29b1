"""What `nmap relief` writes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nmaptool.core.errors import UsageError
from nmaptool.options import HeightsAt, PartOptions
from nmaptool.options.fields import choice_of, option
from nmaptool.options.formats import LARGE_RELIEF_FORMATS, MESH_FORMATS, RELIEF_FORMATS, FileFormat
from nmaptool.options.kinds import Switch
from nmaptool_cli.outputs import FileOf, ReportOutputs
from nmaptool_cli.part_outputs import check_part_names
from nmaptool_cli.streams import STREAM, refuse_stream

if TYPE_CHECKING:
    from nmaptool.io.output.relief import WrittenRelief
    from nmaptool.io.output.transaction import Outputs


def _output_formats() -> Mapping[str, FileFormat]:
    return {**RELIEF_FORMATS, **LARGE_RELIEF_FORMATS}


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
    assembly:
        Index (.json) or picture (.png) of the parts of --part or --parts: which file goes where, with sizes in mm.
        Repeat the flag for both.
    save_recipe:
        Recipe (.toml) with all values of this run, preset and machine included, to edit and run again; - prints it.
        Alone, without solving.
    dry_run:
        Solve, and print size, triangles and file sizes, but write no files.
    """

    output: tuple[Path, ...] = option((), FileOf(formats=_output_formats), short="-o")
    preview: Path | None = option(None)
    at: HeightsAt = option("centers", choice_of(HeightsAt))
    assembly: tuple[Path, ...] = option(())
    save_recipe: Path | None = option(None)
    dry_run: bool = option(False, Switch())

    @property
    def meshes(self) -> list[Path]:
        """The outputs that hold triangles."""
        return [path for path in self.output if path.suffix.lower() in MESH_FORMATS]

    def plan(
        self, prints_json: bool, solid: Mapping[str, Any], recipe: str | None, parts: PartOptions
    ) -> Outputs[WrittenRelief]:
        """The files to write."""
        from nmaptool.io.output.relief import relief_outputs

        refuse_stream("a relief or a preview is written to a file, such as -o relief.stl", *self.output, self.preview)
        if not (self.output or self.preview or self.report or prints_json or self.save_recipe or self.assembly):
            raise UsageError("no output given: add one, such as -o relief.stl --preview relief.png")
        check_part_names(self.output, self.assembly, parts)
        if solid and not (self.meshes or self.is_recipe_only):
            raise UsageError(f"`{next(iter(solid))}`: is for meshes; name one, such as -o relief.3mf")
        saved = None if self.prints_recipe else self.save_recipe
        written = None if saved is None or recipe is None else (saved, recipe)
        wanted: dict[str, Any] = {"preview": self.preview, "at": self.at, "recipe": written, **self.shared}
        return relief_outputs(self.output, assembly=self.assembly, **wanted)

    @property
    def prints_recipe(self) -> bool:
        """Whether the recipe goes to standard output."""
        return self.save_recipe is not None and str(self.save_recipe) == STREAM

    @property
    def is_recipe_only(self) -> bool:
        """Whether nothing but the recipe is wanted."""
        return self.save_recipe is not None and not (self.output or self.preview or self.report)
