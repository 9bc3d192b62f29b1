"""Options for splitting normals into base and detail."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal

from nmaptool.core.errors import UsageError
from nmaptool.core.units import Length
from nmaptool.options.bake import DetailEncoding
from nmaptool.options.fields import Options, choice_of, option
from nmaptool.options.kinds import Count, Number
from nmaptool.options.length_kinds import EdgesOrLength, LengthText

Filter = Literal["rnf", "grnf", "learned"]
ImageFilter = Literal["rnf", "grnf"]
Neighborhood = Literal["surface", "ring"]

# both filters accept the same sigma_r and iterations
SIGMA_R = Number("0.5", 0.01, 10)
ITERATIONS = Count("5", 1, 100)


@dataclass(frozen=True)
class FilterOptions(Options, group="Filter"):
    """How the face normals of a mesh are split into base and detail (rolling guidance and a mixture threshold).

    Parameters
    ----------
    filter:
        "rnf" uses the filtered normals as the base. "grnf" uses them only where the filter changed a normal by more
        than a threshold computed from the mesh itself, and keeps the original normal elsewhere. "learned" is grnf with
        a filter that was trained on many meshes and has no parameters.
    neighborhood:
        Faces to average over: "surface", all within 2.5 sigma_s along the surface; "ring", those that share a vertex,
        as printed in the paper.
    sigma_s:
        Size of detail: finer features go to the detail, larger ones stay in the base. A plain number is in mean edge
        lengths of the mesh, 2% refers to the mesh's longest side, 1.5mm is a length.
    sigma_r:
        How sharp an edge must be to stay in the base, measured as the length of the difference between the unit normals
        on its two sides. Larger values smooth more edges away.
    iterations:
        Number of filter passes. The first pass blurs; the others bring back the larger forms.
    """

    filter: Filter = option("rnf", choice_of(Filter))
    neighborhood: Neighborhood = option("surface", choice_of(Neighborhood))
    sigma_s: float | Length = option(3.0, EdgesOrLength("3 or 2%"))
    sigma_r: float = option(0.5, SIGMA_R)
    iterations: int = option(5, ITERATIONS)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.filter == "learned":
            self._refuse_parameters()

    def _refuse_parameters(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name != "filter" and value != field.default:
                raise UsageError(
                    f"`{field.name}={value!r}`: a learned filter has no parameters; "
                    "leave it out, or use `filter='grnf'`"
                )


@dataclass(frozen=True)
class SplitOptions(Options, group="Filter"):
    """How a normal map without a mesh is split into base and detail.

    Parameters
    ----------
    filter:
        "rnf" uses the filtered normals as the base. "grnf" uses them only where the filter changed a normal by more
        than a threshold computed from the map itself, and keeps the original normal elsewhere.
    sigma_s:
        Size of detail, such as 1% (of the longer side), 8px or 0.5mm. Finer features go to the detail, larger ones stay
        in the base.
    sigma_r:
        How sharp an edge must be to stay in the base, measured as the length of the difference between the unit normals
        on its two sides. Larger values smooth more edges away.
    iterations:
        Number of filter passes. The first pass blurs; the others bring back the larger forms.
    detail_encoding:
        What the detail map stores: "rotation" (blend it back with mode rnm), "slope" (with mode pd), or "difference".
    """

    filter: ImageFilter = option("rnf", choice_of(ImageFilter))
    sigma_s: Length = option(Length(1.0, "%"), LengthText("1%"))
    sigma_r: float = option(0.35, SIGMA_R)
    iterations: int = option(5, ITERATIONS)
    detail_encoding: DetailEncoding = option("rotation", choice_of(DetailEncoding))
