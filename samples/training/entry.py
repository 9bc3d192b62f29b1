"""Entry of the catalogue for one mesh."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ornament import Ornament, Rng
from surface import Array, Surface

KEPT = (0.25, 0.2, 4)  # a filter that does not change a mesh


@dataclass(frozen=True)
class Entry:
    """Definition of one mesh: sizes are in edges; nine in ten ornamented faces have slopes below ``slope``."""

    name: str
    group: str
    form: Callable[[Rng], Surface]
    filter: tuple[float, float, int]
    ornament: Ornament | None = None
    slope: float = 0.0
    where: Callable[[Array], Array] | None = None  # over vertices: 1 where there is ornament
    rim: tuple[float, float] | None = None  # edges from a crease within which ornament fades in
    noise: float = 0.0
    finer: tuple[float, float, int] | None = None  # parameters of its version with four times as many faces
