"""Wavefront OBJ, band by band."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from nmaptool.io.solids.text import rows_as_text
from nmaptool.types.solid import NumberedBody, Solid


def write_obj(solid: Solid, path: Path) -> None:
    """Write every body as an object of an OBJ file in mm."""
    decimals = _decimals(float(np.abs(solid.bounds_mm).max(initial=0.0)))
    row = f"v %.{decimals}f %.{decimals}f %.{decimals}f\n"
    first = 1
    with path.open("wb") as file:
        file.write(b"# nmaptool, mm\n")
        for body in solid.bodies:
            numbered = NumberedBody.of(body)
            file.write(f"o {body.name.replace(' ', '_')}\n".encode())
            for vertices in numbered.vertices():
                file.writelines(rows_as_text(row, vertices))
            for faces in numbered.faces():
                file.writelines(rows_as_text("f %d %d %d\n", faces.astype(np.int64) + first))
            first += numbered.vertex_count


def _decimals(largest: float) -> int:
    """At least as many as tell 1e-9 of the largest coordinate, and no fewer than 8."""
    return 8 if not largest > 0 else max(8, 9 - math.floor(math.log10(largest)))
