"""The result of comparing two ways of rebuilding a mesh: measurements of both, curves, verdicts, pictures."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from nmaptool.core.arrays import Float32, Float64
from nmaptool.options import FilterOptions, ReconstructOptions
from nmaptool.options.plain_values import filter_values, plain_values
from nmaptool.types.mesh import Mesh
from nmaptool.types.shown import OneLine


@dataclass(frozen=True, eq=False, repr=False)
class Contender(OneLine):
    """The result of one scheme for the shared target normals (paper, Fig. 13).

    Attributes
    ----------
    options : ReconstructOptions
    mesh : Mesh
        The rebuilt mesh, moved so that its centroid is that of the given mesh.
    deviation_mm : (N,) float64
        Distance of each vertex from its original position, after that move.
    rms_mm, mean_mm, max_mm : float
        Root mean square, mean and maximum of the deviation.
    hausdorff_mm, to_original_mm, from_original_mm : float
        Largest distance from a vertex of either mesh to the surface of the other; the same from this mesh to the
        original, and from the original to this mesh.
    normal_mean_deg, normal_median_deg, normal_p95_deg : float
        Angles between face normals and targets; the mean is weighted by the areas of the given mesh.
    histogram : (B,) float64
        Share of the area in each bin of the comparison's ``edges_deg``; the last also holds all larger angles.
    folded : int
        Faces whose normals are more than a right angle from their targets.
    volume_share : float or None
        Volume gained by a closed mesh, as a share of its volume; None for an open mesh.
    seconds : float
    """

    options: ReconstructOptions
    mesh: Mesh
    deviation_mm: Float64
    rms_mm: float
    mean_mm: float
    max_mm: float
    hausdorff_mm: float
    to_original_mm: float
    from_original_mm: float
    normal_mean_deg: float
    normal_median_deg: float
    normal_p95_deg: float
    histogram: Float64
    folded: int
    volume_share: float | None
    seconds: float

    def _line(self) -> str:
        return f"{self.options.scheme}: {self.normal_mean_deg:.3g} deg from the targets, {self.rms_mm:.3g} mm rms moved"


@dataclass(frozen=True)
class CurvePoint:
    """One run of a sweep: mean normal deviation in degrees, RMS vertex deviation in mm, number of folded faces."""

    closeness: float | None
    steps: int
    normal_deg: float
    rms_mm: float
    folded: int


@dataclass(frozen=True)
class Verdict:
    """Whether gSfG has the smaller vertex deviation at equal or smaller normal deviation.

    Attributes
    ----------
    rival : str
        The curve of Poisson that gSfG is compared with.
    holds : str
        ``yes``, ``no`` or ``in part``.
    points, held : int
        Number of points on the rival's Pareto front, and how many of them gSfG beats.
    held_deg : tuple of float
        Normal deviations of the points that gSfG beats.
    ratio_low, ratio_high : float or None
        Smallest and largest ratio of gSfG's vertex deviation to Poisson's, over the points that gSfG reaches.
    summary : str
        The verdict as a sentence.
    """

    rival: str
    holds: str
    points: int
    held: int
    held_deg: tuple[float, ...]
    ratio_low: float | None
    ratio_high: float | None
    summary: str


@dataclass(frozen=True, eq=False, repr=False)
class RenderedView(OneLine):
    """A rendering of a contender, at twice its size in the figure.

    Attributes
    ----------
    deviation_mm : (2 H, 2 W) float32
        Deviation of the face seen at each sample; NaN where no face is seen.
    shade : (2 H, 2 W) float32
        Shading, 0 to 1.
    """

    deviation_mm: Float32
    shade: Float32


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(OneLine):
    """gSfG and Poisson on the same targets.

    Attributes
    ----------
    name : str
    faces, vertices : int
    diagonal_mm : float
    filter : FilterOptions
    normal_before_deg : float
        Mean angle between the given mesh's normals and the targets.
    edges_deg : (B + 1,) float64
        Edges of the histogram bins.
    contenders : mapping
        ``gsfg`` and ``poisson``, as the figure shows them. ``poisson`` is the run of its sweep that is closest to gSfG.
    curves : mapping
        The points of each sweep, by name.
    verdicts : tuple of Verdict
    rendered_views : mapping of str to RenderedView
        Renderings of the contenders.
    seconds : mapping of str to float
    """

    name: str
    faces: int
    vertices: int
    diagonal_mm: float
    filter: FilterOptions
    normal_before_deg: float
    edges_deg: Float64
    contenders: Mapping[str, Contender]
    curves: Mapping[str, tuple[CurvePoint, ...]]
    verdicts: tuple[Verdict, ...]
    rendered_views: Mapping[str, RenderedView]
    seconds: Mapping[str, float] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Plain values for JSON; lengths in mm and in % of the diagonal."""
        share = 100 / self.diagonal_mm
        contenders = {}
        for name, each in self.contenders.items():
            skipped = ("mesh", "deviation_mm", "histogram", "options")
            values = {f.name: getattr(each, f.name) for f in dataclasses.fields(each) if f.name not in skipped}
            lengths = [key for key in values if key.endswith("_mm")]
            values |= {key.removesuffix("_mm") + "_percent": values[key] * share for key in lengths}
            values["options"] = plain_values(each.options)
            values["histogram"] = [round(float(part), 6) for part in each.histogram]
            contenders[name] = values
        return {
            "mesh": self.name,
            "faces": self.faces,
            "vertices": self.vertices,
            "diagonal_mm": self.diagonal_mm,
            "filter": filter_values(self.filter),
            "normal_before_deg": self.normal_before_deg,
            "histogram_edges_deg": [float(edge) for edge in self.edges_deg],
            "contenders": contenders,
            "curves": {name: [dataclasses.asdict(p) for p in points] for name, points in self.curves.items()},
            "verdicts": [dataclasses.asdict(verdict) for verdict in self.verdicts],
            "seconds": dict(self.seconds),
        }

    def _line(self) -> str:
        names = ", ".join(self.contenders)
        return f"{self.name}: {self.faces} faces, {names}; gSfG ahead: {', '.join(v.holds for v in self.verdicts)}"
