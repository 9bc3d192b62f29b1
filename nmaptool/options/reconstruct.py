"""How a mesh is rebuilt to a field of normals.

Nothing heavy is imported here, so that ``nmap --help`` stays quick.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from nmaptool.core.errors import UsageError
from nmaptool.options.checks import require_choices, require_number

Scheme = Literal["gsfg-gradient", "gsfg-shape", "gsfg", "poisson"]
Boundary = Literal["hold", "free"]
SCHEMES = ("gsfg-gradient", "gsfg-shape", "gsfg", "poisson")

_MOST_STEPS = 10_000
_LARGEST_GAIN = 10.0


@dataclass(frozen=True)
class ReconstructOptions:
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

    scheme: Scheme = "gsfg-gradient"
    steps: int = 20
    closeness: float = 0.01
    boundary: Boundary = "hold"

    def __post_init__(self) -> None:
        require_choices(("scheme", self.scheme, SCHEMES), ("boundary", self.boundary, ("hold", "free")))
        if not 1 <= self.steps <= _MOST_STEPS:
            raise UsageError(f"--steps {self.steps}: must lie between 1 and {_MOST_STEPS}, such as 20")
        require_number("closeness", self.closeness, 1e-8, 1e4, "0.01")


@dataclass(frozen=True)
class SmoothOptions:
    """How much of the detail a mesh keeps.

    Parameters
    ----------
    detail_gain:
        How much of the detail stays: 0 is smooth, 1 the mesh as it is, 2 has it twice; below 0 it is carved the other
        way round.
    """

    detail_gain: float = 0.0

    def __post_init__(self) -> None:
        require_number("detail-gain", self.detail_gain, -_LARGEST_GAIN, _LARGEST_GAIN, "0 or 2")
