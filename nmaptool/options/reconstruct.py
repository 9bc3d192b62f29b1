"""How a mesh is rebuilt to a field of normals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from nmaptool.options.fields import Options, choice_of, option
from nmaptool.options.kinds import Count, Number

Scheme = Literal["gsfg-gradient", "gsfg-shape", "gsfg", "poisson"]
Boundary = Literal["hold", "free"]


@dataclass(frozen=True)
class ReconstructOptions(Options, group="Rebuilding"):
    """How a mesh is rebuilt to a field of normals.

    Parameters
    ----------
    scheme:
        "gsfg-gradient" stitches the projected faces together, all vertices at once, measured over the surface;
        "gsfg-shape" does so corner by corner; "gsfg" takes the mean of each vertex's projections, as the paper prints
        it; "poisson" turns faces instead of projecting them, the yardstick of the others.
    steps:
        Times that faces are shaped and stitched. Poisson takes 1 in the literature.
    closeness:
        Pull of each vertex to where it was; forms up to 1/sqrt(closeness) edges across follow the normals. "gsfg"
        has none.
    boundary:
        "hold" keeps the vertices of open edges where they are; "free" lets them go.
    """

    scheme: Scheme = option("gsfg-gradient", choice_of(Scheme))
    steps: int = option(20, Count("20", 1, 10_000))
    closeness: float = option(0.01, Number("0.01", 1e-8, 1e4))
    boundary: Boundary = option("hold", choice_of(Boundary))


@dataclass(frozen=True)
class SmoothOptions(Options, group="Rebuilding"):
    """How much of the detail a mesh keeps.

    Parameters
    ----------
    detail_gain:
        How much of the detail stays: 0 is smooth, 1 the mesh as it is, 2 has it twice; below 0 it is carved the other
        way round.
    """

    detail_gain: float = option(0.0, Number("0 or 2", -10, 10))
