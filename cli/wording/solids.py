"""Messages about the triangles of a relief."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from nmaptool.types.shown import counted

if TYPE_CHECKING:
    from nmaptool import Solid
    from nmaptool_cli.run import Run

# bytes per triangle, a vertex for every two triangles
_BYTES = {".stl": 50.0, ".ply": 19.0, ".obj": 42.0, ".glb": 18.0, ".3mf": 14.0}


def describe_solid(run: Run, solid: Solid, meshes: Sequence[Path]) -> None:
    """The size of a solid or surface, and of its files."""
    x, y, z = solid.size_mm
    facts = solid.facts
    if solid.is_closed:
        bodies = counted(len(solid.bodies), "closed body")
        run.say(f"  {bodies}, {x:.4g} x {y:.4g} x {z:.4g} mm, {solid.volume_mm3 / 1000:.4g} cm3")
        hollowed = facts.get("hollowed_mm3")
        if hollowed:
            run.say(f"  hollowed by {hollowed / 1000:.4g} cm3")
        elif hollowed is not None:
            run.warn("nothing to hollow: no part is thicker than the wall inside its outline; use a smaller --hollow")
    else:
        run.say("  the mesh is an open surface; add --base 2mm for a solid")
    if facts["outline"] == "smooth":
        run.say(f"  outline smoothed, at most {facts['outline_deviation_mm']:.3g} mm from the pixels")
    if facts.get("split_corners"):
        corners = counted(facts["split_corners"], "corner")
        run.say(f"  separated {corners} where pixels of the mask only touch; fill a pixel there to join them")
    error = f", at most {facts['max_error_mm']:.3g} mm from the full grid" if "max_error_mm" in facts else ""
    sizes = [
        f"{path.suffix.lower()} {'about ' * (path.suffix.lower() != '.stl')}{_size(path, solid)}" for path in meshes
    ]
    run.say(f"  {solid.face_count} triangles{error}: {', '.join(dict.fromkeys(sizes))}")


def _size(path: Path, solid: Solid) -> str:
    size = _BYTES.get(path.suffix.lower(), 0.0) * solid.face_count
    return f"{size / 1e6:.1f} MB" if size >= 1e6 else f"{size / 1e3:.0f} kB"
