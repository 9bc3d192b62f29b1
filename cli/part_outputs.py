"""Files of parts in `nmap relief`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from nmaptool.core.errors import UsageError
from nmaptool.options import PartOptions, SolidOptions
from nmaptool.options.formats import MESH_FORMATS
from nmaptool_cli.run import Run
from nmaptool_cli.streams import refuse_stream

if TYPE_CHECKING:
    import nmaptool as nm
    from nmaptool.io.output.parts import CutRelief

_SUCH_AS = "-o 'parts/{row}_{col}.stl'"


def check_part_names(outputs: Sequence[Path], assembly: Sequence[Path], parts: PartOptions) -> None:
    """Refuse one file for several parts, and names of parts where there are none.

    Raises
    ------
    UsageError
    """
    from nmaptool.io.output.parts import is_template

    refuse_stream("an assembly is written to files, such as --assembly parts.json", *assembly)
    templates = [path for path in outputs if is_template(path)]
    if not parts.is_given:
        if templates or assembly:
            raise UsageError(f"{[*templates, *assembly][0]}: is for parts; give `part`, such as `part='400mm'`")
        return
    given = "part" if parts.part is not None else "parts"
    single = [path for path in outputs if path.suffix.lower() in MESH_FORMATS and path not in templates]
    if single:
        name = f"{single[0].stem}_{{row}}_{{col}}{single[0].suffix}"
        raise UsageError(f"{single[0]}: is one file, but `{given}` makes several; name them such as {name}")
    if not templates and not assembly:
        raise UsageError(f"`{given}`: is for meshes; name their files, such as {_SUCH_AS}")


def cut_relief(run: Run, relief: nm.Relief, solid: SolidOptions, meshes: Sequence[Path]) -> CutRelief | None:
    """The relief in parts; None if it stays whole."""
    if not run[PartOptions].is_given:
        return None
    from nmaptool.io.output.parts import CutRelief

    return CutRelief.of(relief, run[PartOptions], solid, [str(path) for path in meshes])
