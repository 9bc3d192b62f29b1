"""How normals are split into base and detail.

Nothing heavy is imported here, so that ``nmap --help`` stays quick.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from nmaptool.errors import UsageError
from nmaptool.options.checks import require_choices, require_number
from nmaptool.units import Length, length

Filter = Literal["grnf", "rnf"]
Neighborhood = Literal["surface", "ring"]

_MOST_ITERATIONS = 100


def _check(filter: str, sigma_r: float, iterations: int) -> None:
    require_choices(("filter", filter, ("grnf", "rnf")))
    require_number("sigma-r", sigma_r, 0.01, 10, "0.5")
    if not 1 <= iterations <= _MOST_ITERATIONS:
        raise UsageError(f"--iterations {iterations}: must lie between 1 and {_MOST_ITERATIONS}, such as 5")


@dataclass(frozen=True)
class FilterOptions:
    """How the face normals of a mesh are split into base and detail (rolling guidance and a mixture threshold).

    Parameters
    ----------
    filter:
        "grnf" keeps the original normal in the base wherever the filter changed it less than a threshold found in the
        mesh itself; "rnf" takes the filtered normals as they are.
    neighborhood:
        Faces that are averaged: "surface", those within 2.5 sigma_s along the surface; "ring", those that share a
        vertex, as the paper prints it.
    sigma_s:
        Size of what counts as detail, in mean edge lengths of the mesh.
    sigma_r:
        How different (length of the difference of unit normals) two sides of an edge must be for the edge to stay in
        the base.
    iterations:
        Passes of the filter; the first blurs, the others bring back the larger forms.
    """

    filter: Filter = "grnf"
    neighborhood: Neighborhood = "surface"
    sigma_s: float = 8.0
    sigma_r: float = 0.5
    iterations: int = 5

    def __post_init__(self) -> None:
        _check(self.filter, self.sigma_r, self.iterations)
        require_choices(("neighborhood", self.neighborhood, ("surface", "ring")))
        require_number("sigma-s", self.sigma_s, 0.1, 1000, "8")


@dataclass(frozen=True)
class SplitOptions:
    """How a normal map without a mesh is split into base and detail.

    Parameters
    ----------
    filter:
        "grnf" keeps the original normal in the base wherever the filter changed it less than a threshold found in the
        map itself; "rnf" takes the filtered normals as they are.
    sigma_s:
        Size of what counts as detail, such as 1% (of the longer side), 8px or 0.5mm.
    sigma_r:
        How different (length of the difference of unit normals) two sides of an edge must be for the edge to stay in
        the base.
    iterations:
        Passes of the filter; the first blurs, the others bring back the larger forms.
    detail_encoding:
        What the detail map holds: "rotation" (undone by blending with mode rnm), "slope" (by mode pd), or
        "difference".
    """

    filter: Filter = "grnf"
    sigma_s: Length = Length(1.0, "%")
    sigma_r: float = 0.5
    iterations: int = 5
    detail_encoding: Literal["rotation", "slope", "difference"] = "rotation"

    def __post_init__(self) -> None:
        _check(self.filter, self.sigma_r, self.iterations)
        require_choices(("detail-encoding", self.detail_encoding, ("rotation", "slope", "difference")))
        if isinstance(self.sigma_s, str):
            object.__setattr__(self, "sigma_s", length(self.sigma_s))
