"""How normals are split into base and detail.

Nothing heavy is imported here, so that ``nmap --help`` stays quick.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal

from nmaptool.core.errors import UsageError
from nmaptool.core.units import Length, length
from nmaptool.options.checks import require_choices, require_number

Filter = Literal["rnf", "grnf", "learned"]
Neighborhood = Literal["surface", "ring"]

_MOST_ITERATIONS = 100


def _check(sigma_r: float, iterations: int) -> None:
    require_number("sigma-r", sigma_r, 0.01, 10, "0.5")
    if not 1 <= iterations <= _MOST_ITERATIONS:
        raise UsageError(f"--iterations {iterations}: must lie between 1 and {_MOST_ITERATIONS}, such as 5")


@dataclass(frozen=True)
class FilterOptions:
    """How the face normals of a mesh are split into base and detail (rolling guidance and a mixture threshold).

    Parameters
    ----------
    filter:
        "rnf" takes the filtered normals as the base; "grnf" does so only where the filter changed a normal more than a
        threshold found in the mesh itself, and keeps the original elsewhere; "learned" is grnf with a filter that was
        trained on many meshes and has no parameters.
    neighborhood:
        Faces that are averaged: "surface", those within 2.5 sigma_s along the surface; "ring", those that share a
        vertex, as the paper prints it.
    sigma_s:
        Size of what counts as detail: a plain number is in mean edge lengths of the mesh, 2% is of the mesh's longest
        side, 1.5mm is a length.
    sigma_r:
        How different (length of the difference of unit normals) two sides of an edge must be for the edge to stay in
        the base.
    iterations:
        Passes of the filter; the first blurs, the others bring back the larger forms.
    """

    filter: Filter = "rnf"
    neighborhood: Neighborhood = "surface"
    sigma_s: float | Length = 3.0
    sigma_r: float = 0.5
    iterations: int = 5

    def __post_init__(self) -> None:
        _check(self.sigma_r, self.iterations)
        require_choices(
            ("filter", self.filter, ("rnf", "grnf", "learned")),
            ("neighborhood", self.neighborhood, ("surface", "ring")),
        )
        if isinstance(self.sigma_s, str):
            try:
                size: float | Length = float(self.sigma_s)
            except ValueError:
                size = length(self.sigma_s)
            object.__setattr__(self, "sigma_s", size)
        if isinstance(self.sigma_s, Length):
            if self.sigma_s.unit == "px":
                raise UsageError(
                    f"--sigma-s {self.sigma_s}: a mesh has no pixels; give edges, mm or %, such as 3 or 2%"
                )
        else:
            require_number("sigma-s", self.sigma_s, 0.1, 1000, "3 or 2%")
        if self.filter == "learned":
            self._refuse_parameters()

    def _refuse_parameters(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name != "filter" and value != field.default:
                flag = field.name.replace("_", "-")
                raise UsageError(
                    f"--{flag} {value}: a learned filter has no parameters; leave it away, or use --filter grnf"
                )


@dataclass(frozen=True)
class SplitOptions:
    """How a normal map without a mesh is split into base and detail.

    Parameters
    ----------
    filter:
        "rnf" takes the filtered normals as the base; "grnf" does so only where the filter changed a normal more than a
        threshold found in the map itself, and keeps the original elsewhere.
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

    filter: Literal["rnf", "grnf"] = "rnf"
    sigma_s: Length = Length(1.0, "%")
    sigma_r: float = 0.35
    iterations: int = 5
    detail_encoding: Literal["rotation", "slope", "difference"] = "rotation"

    def __post_init__(self) -> None:
        _check(self.sigma_r, self.iterations)
        require_choices(
            ("filter", self.filter, ("rnf", "grnf")),
            ("detail-encoding", self.detail_encoding, ("rotation", "slope", "difference")),
        )
        if isinstance(self.sigma_s, str):
            object.__setattr__(self, "sigma_s", length(self.sigma_s))
