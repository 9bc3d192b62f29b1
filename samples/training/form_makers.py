"""Forms for a catalogue: sizes are given now, random numbers later."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from forms import box, cloth, prism, turned
from ornament import Rng
from profiles import folds
from simple_forms import Form
from solids import animal, blob, bracket, disk_part, head, shell, torso, vessels
from surface import Array, Surface
from tessellation import Bounds, Field, cubes, sharpened

# bounding boxes of the solids
_BOUNDS: dict[Field, tuple[Bounds, Bounds]] = {
    animal: ((-21, -16, -8), (19, 16, 8)),
    bracket: ((-13, -11, -10), (13, 13, 10)),
    disk_part: ((-6, -12, -5.5), (11.5, 12, 7)),
    head: ((-11, -15, -13), (11, 14, 13)),
    shell: ((-10, -13, -7), (10, 13, 4)),
    torso: ((-15, -19, -8), (15, 19, 9)),
    vessels: ((-22, -20, -7), (22, 22, 7)),
}


def block(size: Bounds, spacing: float, radius: float = 0.0, diagonal: str = "both") -> Form:
    """A box; a radius rounds its edges."""
    return lambda rng: box(size, spacing, radius, diagonal)


def extruded(
    outline: Array, height: float, spacing: float, top: Callable[[Array], Array] | None = None, diagonal: str = "both"
) -> Form:
    """A prism over an outline; its top is level by default."""
    return lambda rng: prism(outline, height, spacing, rng, top, diagonal)


def spun(section: Sequence[Any] | Array, cols: int, spacing: float, diagonal: str = "both") -> Form:
    """A section rotated about an axis."""
    return lambda rng: turned(section, cols, spacing, rng, diagonal)


def solid(field: Field, spacing: float, rounds: int = 3, creased: bool = False) -> Form:
    """One of the solids by marching cubes; vertices near creases are moved onto them."""

    def form(rng: Rng) -> Surface:
        surface = cubes(field, *_BOUNDS[field], spacing, rounds)
        return sharpened(surface, field) if creased else surface

    return form


def lump(half: Bounds, spacing: float, balls: int = 7, spread: float = 7.0, rounds: int = 3) -> Form:
    """Merged balls within a box of this half size."""
    low = (-half[0], -half[1], -half[2])
    return lambda rng: cubes(blob(rng, balls, spread), low, half, spacing, rounds)


def folded(counts: tuple[int, int], diagonal: str = "both") -> Form:
    """A square cloth in folds, of rows and columns."""
    return lambda rng: cloth((24, 24), counts, folds, diagonal)
