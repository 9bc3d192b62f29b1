"""How normals are split into base and detail."""

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

# what both filters take for the range of normals and for their passes
SIGMA_R = Number("0.5", 0.01, 10)
ITERATIONS = Count("5", 1, 100)


@dataclass(frozen=True)
class FilterOptions(Options, group="Filter"):
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

    filter: ImageFilter = option("rnf", choice_of(ImageFilter))
    sigma_s: Length = option(Length(1.0, "%"), LengthText("1%"))
    sigma_r: float = option(0.35, SIGMA_R)
    iterations: int = option(5, ITERATIONS)
    detail_encoding: DetailEncoding = option("rotation", choice_of(DetailEncoding))
