"""A smooth outline: nodes of the outline of a mask move to where coverage says the edge is."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float32, Float64, Mask
from nmaptool.core.grid import corner_sum
from nmaptool.solids.folds import without_folds
from nmaptool.solids.outline import OutlineEdges, find_splits, outline_edges
from nmaptool.solids.shape import Shape, split_moves
from nmaptool.types.solid import Nodes

# nodes stay within half a pixel, so that parts of the outline that do not touch cannot meet
_FURTHEST_PX = 0.45
_STEPS = 3
_RELAXATIONS = 6
# a move is kept where it ends this near to the contour
_NEAR = 0.1
# soft pixels: partly covered
_SOFT = (0.04, 0.96)
_SOFT_SHARE = 0.25
# blurs the steps of a mask without soft pixels
_BLUR_PX = 1.5


def soft_share(mask: Mask, coverage: Float32) -> float:
    """Share of the corners of the pixel outline of a mask that lie beside partly covered pixels.

    Straight runs along rows and columns do not count: they need no soft pixels.
    """
    edges = outline_edges(mask, find_splits(mask))
    order = np.argsort(edges.start)
    following = order[np.searchsorted(edges.start[order], edges.end)]
    turns = edges.end[following] - edges.start[following] != edges.end - edges.start
    rows, cols = edges.rows[turns], edges.cols[turns]
    if not len(rows):
        return 0.0
    padded = np.pad(coverage, 1)
    sides = ((0, 0), (-1, 0), (1, 0), (0, -1), (0, 1))
    values = np.stack([padded[rows + 1 + down, cols + 1 + right] for down, right in sides])
    return float(((values > _SOFT[0]) & (values < _SOFT[1])).any(axis=0).mean())


def has_soft_edges(mask: Mask, coverage: Float32) -> bool:
    """Whether coverage describes the outline of the mask more finely than its pixels."""
    return soft_share(mask, coverage) >= _SOFT_SHARE


@dataclass(frozen=True)
class Cuts:
    """Rows and columns of vertices along which a shape will be cut."""

    rows: tuple[int, ...] = ()
    cols: tuple[int, ...] = ()


NO_CUTS = Cuts()


def smooth_shape(
    mask: Mask, coverage: Float32, *, rounds_border: bool = False, cuts: Cuts = NO_CUTS
) -> tuple[Shape, float]:
    """The shape of a mask with its outline moved to where coverage is one half.

    The nodes of the outline move by less than half a pixel, and no pixel is turned over, so islands, holes and bridges
    stay as the mask has them. Without soft pixels the steps of the mask are smoothed.

    Parameters
    ----------
    mask : (H, W) bool
    coverage : (H, W) float32
        Share of each pixel that is covered, 0 to 1.
    rounds_border : bool
        Whether coverage also describes the border of the picture, where its corners are rounded; otherwise nodes on the
        border slide along it.
    cuts : Cuts
        Nodes on them move only along them.

    Returns
    -------
    shape : Shape
    deviation_px : float
        The greatest distance between the smooth outline's nodes and the outline of the pixels.
    """
    splits = find_splits(mask)
    edges = outline_edges(mask, splits)
    ring = _Ring.of(edges, mask, splits.first, splits.vertices, slides=not rounds_border, cuts=cuts)
    contour = _Contour.of(
        coverage if has_soft_edges(mask, coverage) else _blurred(coverage, rounds_border), rounds_border
    )
    by_px = _towards(contour, ring)
    fixed_nodes, fixed_by = split_moves(splits)
    by_px[np.searchsorted(ring.nodes, fixed_nodes)] = fixed_by
    shape = Shape(mask, splits, ring.nodes, by_px)
    shape = without_folds(shape, ring.is_split)
    kept = np.abs(shape.by_px).max(axis=1) > 0
    deviation_px = float(np.hypot(*shape.by_px.T).max(initial=0.0))
    shape = dataclasses.replace(shape, moved=shape.moved[kept], by_px=shape.by_px[kept])
    return shape, deviation_px


def smooth_foot_line(motif: Mask, coverage: Float32, cuts: Cuts = NO_CUTS) -> tuple[Shape, float]:
    """The shape of a whole picture, in which the outline of a motif on a plate is moved as by `smooth_shape`.

    Parameters
    ----------
    motif : (H, W) bool
    coverage : (H, W) float32
    cuts : Cuts

    Returns
    -------
    shape : Shape
        Of all pixels.
    deviation_px : float
    """
    shape, deviation_px = smooth_shape(motif, coverage, cuts=cuts)
    first = shape.splits.first
    kept = (shape.moved < first) & ~np.isin(shape.moved, shape.splits.vertices)
    whole = np.ones_like(motif)
    foot = Shape(
        whole, find_splits(whole), shape.moved[kept], shape.by_px[kept], shape.forced, shape.forced_falls, True
    )
    return foot, deviation_px


def joined(first: Shape, second: Shape) -> tuple[Shape, Shape]:
    """Two foot lines that do not touch, moved together without folds between them.

    Parameters
    ----------
    first, second : Shape
        Without split vertices, of pictures of one size.

    Returns
    -------
    first : Shape
        With its moves that are kept.
    both : Shape
        Of the whole picture, with the moves of both.
    """
    whole = np.ones_like(first.mask)
    moved = np.concatenate([first.moved, second.moved])
    order = np.argsort(moved)
    by_px = np.concatenate([first.by_px, second.by_px])[order]
    both = without_folds(Shape(whole, find_splits(whole), moved[order], by_px), np.zeros(len(moved), bool))
    own = both.by_px[np.searchsorted(both.moved, first.moved)]
    first = dataclasses.replace(first, by_px=own, forced=both.forced, forced_falls=both.forced_falls)
    return first, dataclasses.replace(both, keeps_heights=True)


def _blurred(coverage: Float32, rounds_border: bool) -> Float32:
    from scipy import ndimage  # takes long to load

    blurred: Float32 = ndimage.gaussian_filter(coverage, _BLUR_PX, mode="constant" if rounds_border else "nearest")
    return blurred


@dataclass(frozen=True, eq=False)
class _Ring:
    """The nodes of an outline, with their neighbours on it.

    ``free`` is (n, 2): 1 where a node may move across and down. Nodes on the border of the picture slide along it, or
    only its corners stay.
    """

    nodes: Nodes
    grid_px: Float64
    before: Nodes
    after: Nodes
    free: Float64
    is_split: Mask

    @classmethod
    def of(cls, edges: OutlineEdges, mask: Mask, first_second: int, split: Nodes, *, slides: bool, cuts: Cuts) -> _Ring:
        rows, cols = mask.shape
        order = np.argsort(edges.start)
        nodes = edges.start[order]
        after = np.searchsorted(nodes, edges.end[order])
        before = np.empty_like(after)
        before[after] = np.arange(len(after))
        is_split = (nodes >= first_second) | np.isin(nodes, split)
        vertex = nodes.copy()
        vertex[nodes >= first_second] = split[nodes[nodes >= first_second] - first_second]
        row, col = np.divmod(vertex, cols + 1)
        grid = np.column_stack([col, row]).astype(np.float64)
        sides, ends = (col == 0) | (col == cols), (row == 0) | (row == rows)
        border = sides | ends
        along = border & border[before] & border[after]
        moves = np.column_stack([~sides & ~along, ~ends & ~along] if slides else [~(sides & ends)] * 2)
        free = moves.astype(np.float64)
        on_cut = np.column_stack([np.isin(col, cuts.cols), np.isin(row, cuts.rows)])
        free[on_cut] = 0.0
        free[is_split] = 0.0
        return cls(nodes, grid, before, after, free, is_split)


@dataclass(frozen=True, eq=False)
class _Contour:
    """Coverage at the vertices of the grid, with its slopes; its level one half is the edge."""

    values: Float64
    across: Float64
    down: Float64

    @classmethod
    def of(cls, coverage: Float32, rounds_border: bool) -> _Contour:
        counts = 4.0 if rounds_border else corner_sum(np.ones(coverage.shape))
        values = corner_sum(coverage.astype(np.float64)) / counts
        down, across = (np.asarray(slope, np.float64) for slope in np.gradient(values))
        return cls(values, across, down)

    def at(self, places_px: Float64) -> tuple[Float64, Float64]:
        """(n,) coverage and (n, 2) slopes at places, x right and y down."""
        from scipy import ndimage  # takes long to load

        here = places_px.T[::-1]
        sampled = [ndimage.map_coordinates(each, here, order=1, mode="nearest") for each in self._fields]
        return sampled[0], np.column_stack(sampled[1:])

    @property
    def _fields(self) -> tuple[Float64, Float64, Float64]:
        return self.values, self.across, self.down

    def step(self, places_px: Float64, free: Float64) -> Float64:
        """(n, 2) the way to the contour, along the free directions."""
        values, slopes = self.at(places_px)
        slopes = slopes * free
        squared = np.maximum((slopes**2).sum(axis=1), 1e-6)
        way: Float64 = ((0.5 - values) / squared)[:, None] * slopes
        return way


def _towards(contour: _Contour, ring: _Ring) -> Float64:
    """(n, 2) moves of the nodes to the contour, evenly along it; 0 where it is not near."""
    by_px = np.zeros_like(ring.grid_px)

    def project(by_px: Float64) -> Float64:
        moved = by_px + contour.step(ring.grid_px + by_px, ring.free)
        return np.clip(moved, -_FURTHEST_PX, _FURTHEST_PX)

    for _ in range(_STEPS):
        by_px = project(by_px)
    for _ in range(_RELAXATIONS):
        here = ring.grid_px + by_px
        before, after = here[ring.before], here[ring.after]
        along = after - before
        along /= np.maximum(np.hypot(*along.T), 1e-9)[:, None]
        slide = (((before + after) / 2 - here) * along).sum(axis=1)
        by_px = project(np.clip(by_px + 0.5 * slide[:, None] * along * ring.free, -_FURTHEST_PX, _FURTHEST_PX))
    values, _ = contour.at(ring.grid_px + by_px)
    by_px[np.abs(values - 0.5) > _NEAR] = 0.0
    return by_px
