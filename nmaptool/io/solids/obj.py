"""Wavefront OBJ, band by band."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from nmaptool.io.solids.text import decimals_as_text, wholes_as_text, words_of
from nmaptool.types.solid import NumberedBody, Solid

HEADER = b"# nmaptool, mm\n"
VERTEX, FACE = words_of("v # # #\n"), words_of("f # # #\n")


def write_obj(solid: Solid, path: Path) -> None:
    """Write every body as an object of an OBJ file in mm."""
    decimals = _decimals(float(np.abs(solid.bounds_mm).max(initial=0.0)))
    first = 1
    with path.open("wb") as file:
        file.write(HEADER)
        for body in solid.bodies:
            numbered = NumberedBody.of(body)
            file.write(f"o {body.name.replace(' ', '_')}\n".encode())
            for vertices in numbered.vertices():
                file.writelines(decimals_as_text(vertices, VERTEX, decimals))
            for faces in numbered.faces():
                file.writelines(wholes_as_text(faces, FACE, first))
            first += numbered.vertex_count


def _decimals(largest: float) -> int:
    """At least as many as tell 1e-9 of the largest coordinate, and no fewer than 8."""
    return 8 if not largest > 0 else max(8, 9 - math.floor(math.log10(largest)))
