"""What is said about the triangles of a relief, one line each, with options as in `nmaptool.core.mentions`."""

from __future__ import annotations

from collections.abc import Iterator

from nmaptool.types.shown import counted
from nmaptool.types.solid import Solid


def describe_solid(solid: Solid) -> Iterator[str]:
    """The kind of solid or surface, and how it follows the outline."""
    x, y, z = solid.size_mm
    facts = solid.facts
    if solid.is_closed:
        bodies = counted(len(solid.bodies), "closed body")
        yield f"{bodies}, {x:.4g} x {y:.4g} x {z:.4g} mm, {solid.volume_mm3 / 1000:.4g} cm3"
        hollowed = facts.get("hollowed_mm3")
        if hollowed:
            yield f"hollowed by {hollowed / 1000:.4g} cm3"
    else:
        yield "the mesh is an open surface; add `base='2mm'` for a solid"
    if facts["outline"] == "smooth":
        yield f"outline smoothed, at most {facts['outline_deviation_mm']:.3g} mm from the pixels"
    if facts["outline"] == "curve":
        tolerance_mm = facts["outline_tolerance_mm"]
        within = f" within {tolerance_mm:.3g} mm" if tolerance_mm else ""
        yield f"the outline follows its curve{within} and encloses {facts['area_mm2']:.5g} mm2"
    if facts.get("split_corners"):
        corners = counted(facts["split_corners"], "corner")
        yield f"separated {corners} where pixels of the mask only touch; fill a pixel there to join them"


def count_triangles(solid: Solid) -> str:
    """The number of triangles and, if some were left out, the error."""
    facts = solid.facts
    error = f", at most {facts['max_error_mm']:.3g} mm from the full grid" if "max_error_mm" in facts else ""
    return f"{solid.face_count} triangles{error}"


def warnings_of(solid: Solid) -> tuple[str, ...]:
    """What the user should know before the solid is made."""
    if solid.is_closed and solid.facts.get("hollowed_mm3") == 0:
        return ("nothing to hollow: no part is thicker than the wall inside its outline; use a smaller `hollow`",)
    return ()
