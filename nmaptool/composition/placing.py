"""Place a layer on a canvas, whole or window by window: move, rotate, mask and feather it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from nmaptool.composition.edges import feathered
from nmaptool.composition.placement import (
    Piece,
    bounds,
    is_exact,
    linear_part,
    map_piece,
    scale_factors,
    with_fixed_point,
)
from nmaptool.core.arrays import Float32, Float64
from nmaptool.core.errors import InputError, UsageError
from nmaptool.maps.masks import motif_coverage
from nmaptool.options import LayerOptions
from nmaptool.options.compose import ANCHORS
from nmaptool.types.layers import Layer, errors_about
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.picture import Frame

Box = tuple[slice, slice]


@dataclass(frozen=True, eq=False)
class Placing:
    """Where a layer lies on a canvas.

    Attributes
    ----------
    name : str
    shape : (int, int)
        Rows and columns of the layer's map.
    options : LayerOptions
    matrix : (2, 3) float64
        Takes points of the map to the canvas: in px, from the top left corners.
    feather_px : float
        Width of the soft edge.
    box : (slice, slice)
        Rows and columns that are mapped: on the canvas, and as far beyond it as the soft edge depends on.
    """

    name: str
    shape: tuple[int, int]
    options: LayerOptions
    matrix: Float64
    feather_px: float
    box: Box

    @property
    def is_exact(self) -> bool:
        """Whether pixels become pixels: quarter turns, mirrors and moves."""
        return is_exact(self.matrix[:, :2])

    @property
    def reach(self) -> int:
        """Pixels of the canvas around a pixel that it depends on, because of the soft edge."""
        return _reach(self.feather_px)


def _reach(feather_px: float) -> int:
    return int(np.ceil(feather_px)) + 1 if feather_px else 0


def place(layer: Layer, frame: Frame) -> tuple[Piece, Float32]:
    """Move, rotate, mask and feather a layer, and crop it to the canvas.

    Returns
    -------
    piece : Piece
    own : (h, w) float32
        Its coverage without mask and feather, which modes other than "over" need.

    Raises
    ------
    InputError
        If it is outside the canvas.
    UsageError
        If a length is in mm and the pitch of the canvas is unknown.
    """
    with errors_about(layer):
        placing = placing_of(layer.normal_map.frame.shape, layer.options, frame, layer.name)
        return _placed(placing, layer.normal_map, layer.mask, placing.box, (slice(0, frame.rows), slice(0, frame.cols)))


def matrix_of(layer: Layer, frame: Frame) -> Float64:
    """Return the (2, 3) matrix that takes points of a layer's map to the canvas: in px, from the top left corners.

    Raises
    ------
    UsageError
        If a length is in mm and the pitch of the canvas is unknown.
    """
    return _matrix(layer.normal_map.frame.shape, layer.options, frame, layer.name)


def placing_of(shape: tuple[int, int], options: LayerOptions, frame: Frame, name: str) -> Placing:
    """Return where a layer lies on a canvas.

    Raises
    ------
    InputError
        If it is outside the canvas.
    UsageError
        If a length is in mm and the pitch of the canvas is unknown.
    """
    rows, cols = shape
    matrix = _matrix(shape, options, frame, name)
    linear = matrix[:, :2]
    longer = float(np.max(np.linalg.norm(linear, axis=0) * (cols, rows)))  # on the canvas
    try:
        feather = 0.0 if options.feather is None else options.feather.to_px(frame.pitch_mm, round(longer))
    except UsageError as error:
        raise UsageError(f"{name}: {error}") from None
    left, top, right, bottom = bounds(matrix, cols, rows)
    if left >= frame.cols or top >= frame.rows or right <= 0 or bottom <= 0:
        raise InputError(
            f"{name}: its area from {left},{top} to {right},{bottom} px is outside the canvas of {frame} px; "
            "move it with `at`"
        )
    # feathering needs the coverage beyond the canvas: a layer that continues there has no edge at the canvas border
    beyond = _reach(feather)
    rim = 0 if is_exact(linear) else 1  # interpolation reaches half a pixel further
    left, top = max(left - rim, -beyond), max(top - rim, -beyond)
    right, bottom = min(right + rim, frame.cols + beyond), min(bottom + rim, frame.rows + beyond)
    return Placing(name, shape, options, matrix, feather, (slice(top, bottom), slice(left, right)))


def _matrix(shape: tuple[int, int], o: LayerOptions, frame: Frame, name: str) -> Float64:
    rows, cols = shape
    linear = linear_part(scale_factors(o.factors, frame, cols), o.flip_h, o.flip_v, o.rotate)
    share_across, share_down = ANCHORS[o.anchor]
    try:
        across, down = (
            d.to_px(frame.pitch_mm, side) for d, side in zip(o.place, (frame.cols, frame.rows), strict=True)
        )
    except UsageError as error:
        raise UsageError(f"{name}: {error}") from None
    return with_fixed_point(linear, (share_across * cols, share_down * rows), (across, down))


def part_for(placing: Placing, window: Box) -> tuple[Box, Box] | None:
    """Return what a window of the canvas needs of a layer whose pixels become pixels; None if it does not reach it.

    Parameters
    ----------
    placing : Placing
        `Placing.is_exact`.
    window : (slice, slice)
        Rows and columns of the canvas.

    Returns
    -------
    box : (slice, slice)
        The part of ``placing.box`` that lies in the window or near enough to have an effect on it.
    part : (slice, slice)
        Rows and columns of the layer's map that become it.
    """
    if _common(window, placing.box) is None:
        return None
    reach = placing.reach
    around = tuple(slice(side.start - reach, side.stop + reach) for side in window)
    box = _common((around[0], around[1]), placing.box)
    if box is None:
        return None
    linear = np.round(placing.matrix[:, :2])
    corners = np.array([[box[1].start, box[1].stop], [box[0].start, box[0].stop]]) - placing.matrix[:, 2:]
    across, down = np.sort(np.round(linear.T @ corners).astype(int))
    return box, (slice(int(down[0]), int(down[1])), slice(int(across[0]), int(across[1])))


def place_part(
    placing: Placing, part: NormalMap, mask: Float32 | None, box: Box, first: tuple[int, int], window: Box
) -> tuple[Piece, Float32]:
    """Place a part of a layer, with the pixels that `place` gives in a window of the canvas.

    Parameters
    ----------
    placing : Placing
    part : NormalMap
        The part of the layer that `part_for` names, with its first row and column.
    mask : (h, w) float32 or None
        The same part of the mask.
    box, first, window
        As of `part_for`.

    Returns
    -------
    piece : Piece
        Its position is that in the window.
    own : (h, w) float32
        As of `place`.
    """
    matrix = placing.matrix.copy()
    matrix[:, 2] += matrix[:, :2] @ (first[1], first[0])
    return _placed(replace(placing, matrix=matrix), part, mask, box, window)


def _placed(placing: Placing, source: NormalMap, mask: Float32 | None, box: Box, window: Box) -> tuple[Piece, Float32]:
    o, coverage = placing.options, motif_coverage(source)
    rows, cols = box
    place = (cols.start, rows.start, cols.stop - cols.start, rows.stop - rows.start)

    def mapped(shown: Float32) -> Piece:
        piece = Piece(source.normals, shown, source.foreground)
        return map_piece(piece, placing.matrix, place, o.height_factor, placing.name)

    piece = mapped(coverage if mask is None else coverage * mask)
    own = piece if mask is None or o.mode == "over" else mapped(coverage)
    if placing.feather_px:
        piece = replace(piece, coverage=feathered(piece.coverage, placing.feather_px))
    return _cut(piece, window), _cut(own, window).coverage


def _common(one: Box, other: Box) -> Box | None:
    """What two boxes have in common; None if that is nothing."""
    rows, cols = (slice(max(a.start, b.start), min(a.stop, b.stop)) for a, b in zip(one, other, strict=True))
    return (rows, cols) if rows.start < rows.stop and cols.start < cols.stop else None


def _cut(piece: Piece, window: Box) -> Piece:
    """Return the part of a piece that is in a window, at its position there."""
    rows, cols = piece.coverage.shape
    box = _common((slice(piece.top, piece.top + rows), slice(piece.left, piece.left + cols)), window)
    assert box is not None
    part = tuple(slice(side.start - at, side.stop - at) for side, at in zip(box, (piece.top, piece.left), strict=True))
    place = (part[0], part[1])
    left, top = box[1].start - window[1].start, box[0].start - window[0].start
    return Piece(piece.normals[place], piece.coverage[place], piece.foreground[place], left, top)
