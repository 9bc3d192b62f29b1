"""A motif that stands on its plate with vertical walls, as one body: motif, walls, plate, back."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from nmaptool.core.arrays import Float32, Float64, Mask
from nmaptool.core.errors import InputError
from nmaptool.core.grid import touching_vertices
from nmaptool.solids.flat_back import FlatBack
from nmaptool.solids.folds import moved_within
from nmaptool.solids.integral import volume_below
from nmaptool.solids.outline import OutlineEdges, find_splits, outline_edges
from nmaptool.solids.piece import Back, lowest_of, volume_below_back
from nmaptool.solids.shape import Shape, pixel_shape
from nmaptool.solids.sheet import Placing, Sheet
from nmaptool.solids.smooth import NO_CUTS, Cuts, joined, smooth_foot_line, smooth_shape
from nmaptool.solids.walls import wall_parts
from nmaptool.types.height import Height
from nmaptool.types.solid import Body, Nodes, Part


@dataclass(frozen=True, eq=False)
class RaisedFront:
    """The front of a motif that stands on its plate: two sheets with walls between them.

    Nodes of the plate follow those of the motif.

    Attributes
    ----------
    motif, plate : Sheet
    motif_edges, plate_edges : OutlineEdges
    """

    motif: Sheet
    plate: Sheet
    motif_edges: OutlineEdges
    plate_edges: OutlineEdges

    @property
    def node_count(self) -> int:
        """One more than the highest node number."""
        return self.plate.node_count

    @property
    def face_count(self) -> int:
        """Triangles of both sheets and of the walls between them."""
        return self.motif.face_count + self.plate.face_count + 2 * len(self.walls.start)

    @cached_property
    def walls(self) -> OutlineEdges:
        """The edges between motif and plate, with the motif to the left."""
        return self.motif_edges.chosen(~self._on_border(self.motif_edges))

    @cached_property
    def borders(self) -> tuple[OutlineEdges, OutlineEdges]:
        """The edges of motif and plate on the border of the picture."""
        motif, plate = (each.chosen(self._on_border(each)) for each in (self.motif_edges, self.plate_edges))
        return motif, plate

    def border(self) -> OutlineEdges:
        """Both of them."""
        motif, plate = self.borders
        return motif.joined(plate)

    def _on_border(self, edges: OutlineEdges) -> Mask:
        rows, cols = self.motif.shape.mask.shape
        (r0, c0), (r1, c1) = (np.divmod(nodes, cols + 1) for nodes in (edges.start, edges.end))
        on: Mask = ((r0 == r1) & ((r0 == 0) | (r0 == rows))) | ((c0 == c1) & ((c0 == 0) | (c0 == cols)))
        return on

    @property
    def whole(self) -> Sheet:
        """The lower of motif and plate at each vertex: what a back must stay behind."""
        motif, plate = self.motif, self.plate
        mask = motif.shape.mask | plate.shape.mask
        shape = Shape(mask, find_splits(mask), plate.shape.moved, plate.shape.by_px, keeps_heights=True)
        inner = touching_vertices(motif.shape.mask) & ~touching_vertices(plate.shape.mask)
        outline = touching_vertices(motif.shape.mask) & ~inner
        z_mm = np.where(inner, motif.z_mm, np.where(outline, np.minimum(motif.z_mm, 0.0), plate.z_mm))
        return Sheet(z_mm, shape, motif.placing, 1, plate.first_node, diagonals_of=motif)

    @property
    def bounds_mm(self) -> Float64:
        """(2, 3) float64: the box around it."""
        rim = self.plate.xyz_of(self.border().start)
        low, high = rim.min(axis=0), rim.max(axis=0)
        ranges = [self.motif.z_range(), self.plate.z_range()]
        low[2], high[2] = min(each[0] for each in ranges), max(each[1] for each in ranges)
        return np.stack([low, high])

    def parts(self) -> Iterator[Part]:
        """The triangles."""
        yield from self.motif.parts()
        edges = self.walls
        yield from wall_parts(edges.start, edges.end, self.motif.xyz_of, self.plate.xyz_of, self.plate.first_node)
        yield from self.plate.parts()


class InsetFront(RaisedFront):
    """A motif that stands well inside its plate: the plate has the whole border."""

    def _on_border(self, edges: OutlineEdges) -> Mask:
        on: Mask = ~np.isin(edges.start, self.motif_edges.start)
        return on


def raised_front(
    height: Height,
    coverage: Float32 | None,
    is_smooth: bool,
    beside: Mask | None = None,
    inner: Mask | None = None,
    cuts: Cuts = NO_CUTS,
) -> tuple[RaisedFront, float]:
    """The front of a height field with a raised motif.

    Parameters
    ----------
    height : Height
        ``raised`` is given.
    coverage : (H, W) float32, optional
        Share of each pixel that is motif. Default: that of the mask.
    is_smooth : bool
        Whether the outline follows the coverage.
    beside : (H, W) bool, optional
        Rest of the motif, which runs down into the plate. It must not touch what is raised.
    inner : (H, W) bool, optional
        Pixels of the plate and the motif, which lies well inside. Default: the whole picture.
    cuts : Cuts
        Nodes on them move only along them.

    Returns
    -------
    front : RaisedFront
    deviation_px : float

    Raises
    ------
    InputError
        If pixels of the motif touch only at a corner, or its outline touches the plate.
    """
    mask = height.raised
    assert mask is not None
    if len(find_splits(mask).vertices):
        raise InputError("pixels of the raised motif touch only at a corner; join them in the mask")
    shape, deviation_px = pixel_shape(mask, find_splits(mask)), 0.0
    around = shape
    if is_smooth:
        coverage = mask.astype(np.float32) if coverage is None else coverage
        around = shape = smooth_shape(mask, _only(mask, coverage), cuts=cuts)[0]
        if beside is not None and beside.any():
            shape, around = joined(shape, smooth_foot_line(beside, _only(beside, coverage), cuts)[0])
        deviation_px = float(np.hypot(*around.by_px.T).max(initial=0.0))
    placing = Placing(height.pitch_mm, 0, 0)
    motif = Sheet(_in_range(height, shape, placing), shape, placing)
    if inner is not None:
        around = moved_within(around, inner, shape.moved)
    other = ~mask if inner is None else inner & ~mask
    moved = dataclasses.replace(around, mask=other, splits=find_splits(other), keeps_heights=True)
    plate = Sheet(height.plate_mm(), moved, placing, 1, shape.node_count)
    edges = outline_edges(mask, shape.splits)
    _check_walls(motif.z_of(edges.start))
    front = RaisedFront if inner is None else InsetFront
    return front(motif, plate, edges, outline_edges(other, moved.splits)), deviation_px


def _only(mask: Mask, coverage: Float32) -> Float32:
    """Coverage without that of other parts of the motif."""
    return np.where(mask | (coverage < 0.5), coverage, np.float32(0))


def _in_range(height: Height, shape: Shape, placing: Placing) -> Float64:
    """Heights whose extreme above or below the plate is kept by the moved nodes of the outline."""
    low, high = Sheet(height.z_mm, shape, placing).z_range()
    inside = height.z_mm[touching_vertices(shape.mask)]
    wanted_low, wanted_high = float(inside.min()), float(inside.max())
    factor = wanted_high / high if wanted_high >= -wanted_low else wanted_low / low
    return height.z_mm * factor


def _check_walls(z_mm: Float64) -> None:
    """Refuse walls that vanish or change their side."""
    if not (z_mm.min() > 0 or z_mm.max() < 0):
        raise InputError(
            f"the outline of the raised motif lies at {z_mm.min():.4g} to {z_mm.max():.4g} mm, so its wall vanishes "
            "in places; use a larger `edge_height`, or `edge='blend'`"
        )


@dataclass(frozen=True, eq=False)
class RaisedPiece:
    """A closed body with a raised motif.

    Attributes
    ----------
    front : RaisedFront
    back : Sheet or FlatBack
        Its nodes follow those of the plate.
    """

    front: RaisedFront
    back: Back

    @classmethod
    def of(cls, front: RaisedFront, back: Back) -> RaisedPiece:
        """Put a back behind a front."""
        if isinstance(back, FlatBack):
            back = dataclasses.replace(back, outline=front.border())
        return cls(front, back)

    @property
    def bounds_mm(self) -> Float64:
        """(2, 3) float64: the box around the body."""
        bounds = self.front.bounds_mm
        bounds[0, 2] = lowest_of(self.back)
        return bounds

    @property
    def volume_mm3(self) -> float:
        """Between front and back, from the heights."""
        return volume_below(self.front.motif) + volume_below(self.front.plate) - volume_below_back(self.back)

    @property
    def face_count(self) -> int:
        """Number of triangles."""
        return self.front.face_count + sum(len(part.faces) for part in self._border_walls) + self.back.face_count

    def body(self, name: str) -> Body:
        """Its triangles."""
        return Body(name, self._parts, self.face_count, self.back.node_count)

    def _parts(self) -> Iterator[Part]:
        yield from self.front.parts()
        yield from self._border_walls
        yield from self.back.parts()

    @cached_property
    def _border_walls(self) -> tuple[Part, ...]:
        """Walls below the motif's and below the plate's part of the border."""
        front, borders = self.front, self.front.borders
        nodes = [np.unique(np.concatenate([each.start, each.end])) for each in borders]
        shared = np.intersect1d(nodes[0], nodes[1])
        motif, plate = front.motif, front.plate
        return tuple(
            border_walls(edges, this, other, self.back, shared)
            for edges, this, other in ((borders[0], motif, plate), (borders[1], plate, motif))
            if len(edges.start)
        )


def border_walls(edges: OutlineEdges, front: Sheet, other: Sheet, back: Back, shared: Nodes) -> Part:
    """Walls from a front down to a back, through the nodes that another front has on the way.

    Parameters
    ----------
    edges : OutlineEdges
        With the front to the left.
    front, other : Sheet
    back : Sheet or FlatBack
    shared : (k,) int64
        Nodes that both fronts have; the other's lies between front and back where it is lower.
    """
    nodes, local = np.unique(np.stack([edges.start, edges.end]), return_inverse=True)
    count = np.int32(len(nodes))
    a, b = local.reshape(2, -1).astype(np.int32)
    lower = np.isin(nodes, shared) & (other.z_of(nodes) < front.z_of(nodes))
    (has_a,), (has_b,) = (np.nonzero(lower[end]) for end in (a, b))
    back_a, back_b = a + count, b + count
    over_a, over_b = a[has_a], b[has_b]
    # down at a: in one triangle, or in two through the node between
    faces = [
        np.stack([b, np.where(lower[a], a + 2 * count, a), back_a], 1),
        np.stack([b[has_a], over_a, over_a + 2 * count], 1),
    ]
    faces += [np.stack([back_a, back_b, np.where(lower[b], b + 2 * count, b)], 1)]
    faces += [np.stack([back_a[has_b], over_b + 2 * count, over_b], 1)]
    xyz_mm = np.concatenate([front.xyz_of(nodes), back.xyz_of(nodes), other.xyz_of(nodes)])
    numbers = np.concatenate([nodes + each.first_node for each in (front, back, other)])
    return Part(xyz_mm, np.concatenate(faces).astype(np.int32), numbers)


def raised_mask(height: Height) -> Mask | None:
    """The raised pixels, or None where the whole picture is raised or nothing is."""
    mask = height.raised
    return None if mask is None or mask.all() or not mask.any() else mask
