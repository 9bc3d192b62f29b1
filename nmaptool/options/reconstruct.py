"""Options for rebuilding a mesh to match given normals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from nmaptool.options.fields import Options, choice_of, option
from nmaptool.options.kinds import Count, Number

Scheme = Literal["gsfg-gradient", "gsfg-shape", "gsfg", "poisson"]
Boundary = Literal["hold", "free"]


@dataclass(frozen=True)
class ReconstructOptions(Options, group="Reconstruction"):
    """How a mesh is rebuilt to match given normals.

    Parameters
    ----------
    scheme:
        "gsfg-gradient" projects the faces and stitches them together, all vertices at once, with errors measured over
        the surface. "gsfg-shape" measures them corner by corner. "gsfg" moves each vertex to the mean of its
        projections, as printed in the paper. "poisson" rotates the faces instead of projecting them; it is the
        reference for the others.
    steps:
        How many times to shape and stitch the faces. The literature uses 1 for Poisson.
    closeness:
        How strongly each vertex is held to its old position. Forms up to 1/sqrt(closeness) edges across follow the
        normals: smaller values follow them further, larger values keep more of the volume. "gsfg" ignores it.
    boundary:
        "hold" keeps the vertices on open edges in place; "free" lets them move.
    """

    scheme: Scheme = option("gsfg-gradient", choice_of(Scheme))
    steps: int = option(20, Count("20", 1, 10_000))
    closeness: float = option(0.01, Number("0.01", 1e-8, 1e4))
    boundary: Boundary = option("hold", choice_of(Boundary))


@dataclass(frozen=True)
class SmoothOptions(Options, group="Reconstruction"):
    """How much of the detail a mesh keeps.

    Parameters
    ----------
    detail_gain:
        How much detail to keep: 0 removes it, 1 leaves the mesh unchanged, 2 doubles it. Values below 0 invert it.
    """

    detail_gain: float = option(0.0, Number("0 or 2", -10, 10))
