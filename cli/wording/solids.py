"""Messages about the triangles of a relief."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from nmaptool.io.solids.sizes import about_bytes
from nmaptool.solids import wording

if TYPE_CHECKING:
    from nmaptool import Solid
    from nmaptool_cli.run import Run


def describe_solid(run: Run, solid: Solid, meshes: Sequence[Path]) -> None:
    """The size of a solid or surface, and of its files."""
    run.say(*(f"  {line}" for line in wording.describe_solid(solid)))
    run.warn(*wording.warnings_of(solid))
    endings = dict.fromkeys(path.suffix.lower() for path in meshes)
    sizes = [f"{ending} {'about ' * (ending != '.stl')}{_size(ending, solid)}" for ending in endings]
    run.say(f"  {wording.count_triangles(solid)}: {', '.join(sizes)}")


def _size(ending: str, solid: Solid) -> str:
    size = about_bytes(ending, solid.face_count)
    return f"{size / 1e6:.1f} MB" if size >= 1e6 else f"{size / 1e3:.0f} kB"
