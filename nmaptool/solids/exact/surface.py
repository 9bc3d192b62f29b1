"""The pixels of a plate with an exact outline: one sheet, or a motif that stands on its plate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float32, Float64, Mask
from nmaptool.core.errors import InputError
from nmaptool.core.grid import dilated
from nmaptool.options.solid import SolidOptions
from nmaptool.solids.exact.flat_rim import bent_nearby, without_flat_rim
from nmaptool.solids.exact.inner import inner_mask, inside_of, pixels_over, vertices_between
from nmaptool.solids.exact.plate import PlateFront
from nmaptool.solids.exact.rings import OutlinePoints
from nmaptool.solids.exact.strip import strip_between
from nmaptool.solids.folds import moved_within
from nmaptool.solids.outline import OutlineEdges, find_splits, outline_edges
from nmaptool.solids.raised import RaisedFront, raised_front
from nmaptool.solids.shape import Shape
from nmaptool.solids.sheet import Placing, Sheet
from nmaptool.solids.smooth import has_soft_edges, smooth_foot_line
from nmaptool.types.height import Height
from nmaptool.types.relief import Relief
from nmaptool.types.solid import Nodes

# a raised motif keeps so many px from the strip along the outline
_CLEAR_PX = 1


@dataclass(frozen=True, eq=False)
class Pixels:
    """The pixels of a front that an exact outline does not cut.

    Attributes
    ----------
    surface : Sheet or RaisedFront
    edges : OutlineEdges
        The outline of these pixels, in edges of single pixels.
    between : (k,) int64
        Nodes of the grid between them and the outline.
    over : (H, W) bool
        The pixels inside the outline, also in part.
    deviation_px : float
        How far foot lines moved.
    """

    surface: Sheet | RaisedFront
    edges: OutlineEdges
    between: Nodes
    over: Mask
    deviation_px: float

    @property
    def rim(self) -> Sheet:
        """The sheet that meets the strip along the outline."""
        return self.surface.plate if isinstance(self.surface, RaisedFront) else self.surface

    @property
    def whole(self) -> Sheet:
        """What a back must stay behind."""
        return self.surface.whole if isinstance(self.surface, RaisedFront) else self.surface


def pixels_of(relief: Height | Relief, height: Height, points: OutlinePoints, options: SolidOptions) -> Pixels:
    """The pixels of a plate well inside its outline.

    Raises
    ------
    InputError
        If the outline crosses itself or is not that of the domain, or a raised motif comes near to it.
    """
    rings = _rings_px(points, height)
    over, inner = pixels_over(rings, height.frame.shape), _inner_of(height, rings)
    if options.shell is None and options.hollow is None and (options.max_error or options.triangles):
        bent = bent_nearby([height.z_mm], over)
        inner = without_flat_rim(inner, bent)
        between = np.flatnonzero(vertices_between(rings, inner) & bent)
    else:
        between = np.flatnonzero(vertices_between(rings, inner))
    coverage = relief.coverage if isinstance(relief, Relief) else None
    motif = relief.foreground & height.domain if isinstance(relief, Relief) else np.zeros_like(inner)
    raised = height.raised if height.raised is not None and height.raised.any() else None
    if raised is not None:
        _check_clear(raised, inner)
        is_smooth = _is_smooth(raised, coverage, options)
        front, deviation_px = raised_front(height, coverage, is_smooth, motif & ~raised, inner)
        return Pixels(front, front.border(), between, over, deviation_px)
    shape = Shape(inner, find_splits(inner), keeps_heights=True)
    deviation_px = 0.0
    if motif.any() and (height.domain & ~motif).any() and _is_smooth(motif, coverage, options):
        foot = smooth_foot_line(motif, motif.astype(np.float32) if coverage is None else coverage)[0]
        shape = moved_within(foot, inner, np.zeros(0, np.int64))
        deviation_px = float(np.hypot(*shape.by_px.T).max(initial=0.0))
    sheet = Sheet(height.z_mm, shape, Placing(height.pitch_mm, 0, 0))
    return Pixels(sheet, outline_edges(inner, shape.splits), between, over, deviation_px)


def front_of(pixels: Pixels, points: OutlinePoints, z_mm: Float64) -> PlateFront:
    """The front of these pixels and a strip along the outline, with heights of the points of the outline."""
    return PlateFront(pixels.surface, strip_between(points, pixels.rim, pixels.edges, pixels.between), z_mm)


def _rings_px(points: OutlinePoints, height: Height) -> list[Float64]:
    """The rings of an outline in px, x to the right and y down from the upper left corner of the picture."""
    flip = np.array([1.0, -1.0])
    return [ring / height.pitch_mm * flip + (0, height.frame.rows) for ring in points.rings]


def _inner_of(height: Height, rings: Sequence[Float64]) -> Mask:
    shape = height.frame.shape
    inner = inner_mask(rings, shape)
    inside = inside_of(rings, shape)
    beyond = int(np.count_nonzero(dilated(inside, 1) < height.domain) + np.count_nonzero(inner & ~height.domain))
    if beyond:
        raise InputError(
            f"the outline is not that of the heights: {beyond} px of their domain lie outside of it, or the other way "
            "round; the domain must be the pixels whose centres lie inside"
        )
    return inner


def _is_smooth(motif: Mask, coverage: Float32 | None, options: SolidOptions) -> bool:
    """Whether the outline of a motif follows its coverage."""
    if options.outline != "auto":
        return options.outline == "smooth"
    return coverage is not None and has_soft_edges(motif, coverage)


def _check_clear(raised: Mask, inner: Mask) -> None:
    """Refuse a raised motif that touches the strip along the outline."""
    near = int(np.count_nonzero(dilated(raised, _CLEAR_PX) & ~inner))
    if near:
        raise InputError(
            f"the raised motif comes nearer than about {_CLEAR_PX + 1} px to the outline of its plate, at {near} px; "
            "use a larger `margin`, move the hole, or use `edge='blend'`"
        )
