"""Compose layers and groups on one canvas: order, coverage, clipping."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nmaptool.composition.blend_vectors import blend_normals
from nmaptool.composition.edges import detail_weight
from nmaptool.composition.placement import Piece
from nmaptool.composition.placing import place
from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.errors import InputError
from nmaptool.core.vectors import FLAT, unit
from nmaptool.options import GroupOptions, LayerOptions
from nmaptool.types.layers import Layer, LayerGroup, check_mask, errors_about
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.picture import Frame

_SMALLEST_COVERAGE = np.float32(1e-6)


@dataclass(eq=False)
class Canvas:
    """The state of a canvas; only `_lay` changes it.

    Attributes
    ----------
    frame : Frame
    normals, coverage, foreground
        As in `nmaptool.NormalMap`.
    flat_background : bool
        As in `nmaptool.NormalMap`, for the map or plate below the layers.
    placed : (H, W) float32
        Coverage of the layers above the lowest one.
    walls : (H, W) float32
        Coverage of the layers that stand with walls.
    layer_reports : list of dict
        Report of each layer.
    """

    frame: Frame
    normals: Float32
    coverage: Float32
    foreground: Mask
    flat_background: bool
    placed: Float32
    walls: Float32
    layer_reports: list[dict[str, Any]]


def clear_canvas(frame: Frame, ground: str) -> Canvas:
    """Return an empty canvas: transparent, or a flat plate."""
    normals = np.empty((*frame.shape, 3), np.float32)
    normals[...] = FLAT
    coverage = np.full(frame.shape, 1 if ground == "flat" else 0, np.float32)
    placed, walls = (np.zeros(frame.shape, np.float32) for _ in range(2))
    return Canvas(frame, normals, coverage, np.zeros(frame.shape, bool), ground == "flat", placed, walls, [])


def canvas_of(base: NormalMap, frame: Frame) -> Canvas:
    """Return a canvas with a copy of a map of the same size."""
    copies = (base.normals.copy(), base.coverage.copy(), base.foreground.copy())
    placed, walls = (np.zeros(frame.shape, np.float32) for _ in range(2))
    return Canvas(frame, *copies, base.flat_background, placed, walls, [])


def compose_onto(
    canvas: Canvas,
    layers: Sequence[Layer | LayerGroup],
    *,
    in_group: bool = False,
    lowest: bool = False,
    progress: Callable[[str], None] = lambda name: None,
) -> Canvas:
    """Compose layers onto a canvas, in place, from the lowest to the topmost.

    Parameters
    ----------
    canvas : Canvas
    layers : sequence of Layer or LayerGroup
    in_group : bool
        Whether the layers are in a group; "auto" then does not clip them, since the group is clipped.
    lowest : bool
        Whether the first layer is the ground of the others.
    progress : callable
        Called with the name of each layer.

    Raises
    ------
    InputError
        If a layer is outside the canvas, covers nothing or has nothing below it to change.
    UsageError
        If a length is in mm and the pitch of the canvas is unknown.
    """
    for number, layer in enumerate(layers):
        progress(layer.name)
        if isinstance(layer, LayerGroup):
            inner = compose_onto(clear_canvas(canvas.frame, "clear"), layer.layers, in_group=True, progress=progress)
            piece, own, within = group_piece(inner, layer), inner.coverage, {"layers": inner.layer_reports}
            walls: Float32 | np.float32 = (inner.walls / np.maximum(inner.coverage, _SMALLEST_COVERAGE)).clip(0, 1)
        else:
            (piece, own), within = place(layer, canvas.frame), {}
            walls = np.float32(layer.options.edge == "wall")
        o = layer.options
        clip = is_clipped(o, in_group=in_group)
        with errors_about(layer):
            share = _lay(canvas, piece, own, layer, clip, walls, counts=number > 0 or not lowest)
        rows, cols = piece.coverage.shape
        box = [piece.left, piece.top, cols, rows]
        metadata = {"name": layer.name, "mode": o.mode, "strength": o.strength, "box_px": box, "share": share}
        canvas.layer_reports.append({**metadata, **within})
    return canvas


def group_piece(inner: Canvas, group: LayerGroup) -> Piece:
    """Return the piece of a group: its layers, already composed on their own canvas, under its mask.

    Raises
    ------
    InputError
        If the mask does not have the size of the canvas.
    """
    coverage = inner.coverage
    if group.mask is not None:
        with errors_about(group):
            check_mask(group.mask, group.name, inner.frame.shape, group.mask_name)
        coverage = coverage * group.mask
    return Piece(inner.normals, coverage, inner.foreground)


def is_clipped(options: LayerOptions | GroupOptions, *, in_group: bool = False) -> bool:
    """Whether a layer shows only where there is something below it."""
    return options.clip == "yes" or (options.clip == "auto" and options.mode != "over" and not in_group)


def _lay(
    canvas: Canvas,
    piece: Piece,
    own: Float32,
    layer: Layer | LayerGroup,
    clip: bool,
    walls: Float32 | np.float32,
    *,
    counts: bool,
) -> float:
    """Compose a piece onto the canvas, in place; return the share of the canvas that it covers.

    ``walls`` is the share of the piece that stands with walls.
    """
    below = canvas.coverage[_window_of(piece)]
    if not piece.coverage.any():
        raise covers_nothing(layer.name)
    if clip and not (piece.coverage * below).any():
        raise nothing_below(layer.name, layer.options.mode)
    return lay(canvas, piece, own, layer.options, clip, walls, counts=counts) / canvas.coverage.size


def covers_nothing(name: str) -> InputError:
    """The error about a layer that has no pixel on the canvas."""
    return InputError(
        f"{name}: covers no pixel of the canvas; check its mask, alpha, position and scale (a flat background is "
        "not part of a layer)"
    )


def nothing_below(name: str, mode: str) -> InputError:
    """The error about a layer that has nothing to change."""
    return InputError(f'{name}: mode "{mode}" needs a surface below it, found none; use mode "over", or clip "no"')


def _window_of(piece: Piece) -> tuple[slice, slice]:
    rows, cols = piece.coverage.shape
    return slice(piece.top, piece.top + rows), slice(piece.left, piece.left + cols)


def lay(
    canvas: Canvas,
    piece: Piece,
    own: Float32,
    options: LayerOptions | GroupOptions,
    clip: bool,
    walls: Float32 | np.float32,
    *,
    counts: bool = True,
) -> float:
    """Compose a piece onto the canvas, in place, each pixel on its own; return the sum of what it covers.

    Parameters
    ----------
    canvas : Canvas
    piece : Piece
        Within the canvas.
    own : (h, w) float32
        Its coverage without mask and feather, which modes other than "over" need.
    options : LayerOptions or GroupOptions
        The mode and the strength.
    clip : bool
        Whether it shows only where there is something below it.
    walls : (h, w) float32 or float32
        The share of the piece that stands with walls.
    counts : bool
        Whether it is a layer above the lowest.
    """
    mode, strength = options.mode, options.strength
    window = _window_of(piece)
    below, above = canvas.coverage[window], piece.coverage
    if strength == 0:
        return 0.0
    if mode == "over":
        shown = above * np.float32(strength)
        if clip:
            shown = shown * below
        outcome = below if clip else below + shown * (1 - below)
        with np.errstate(invalid="ignore", divide="ignore"):
            share = np.where(outcome > 0, shown / outcome, 0).astype(np.float32).clip(0, 1)
        canvas.normals[window] = mix_normals(canvas.normals[window], piece.normals, share)
        motif = np.where(share >= 0.5, piece.foreground, canvas.foreground[window])
    else:
        # without clipping, the parts of the layer beyond the surface extend it
        weight = detail_weight(above, own if clip else above, below)
        canvas.normals[window] = blend_normals(
            canvas.normals[window], piece.normals, mode, weight * np.float32(strength)
        )
        outcome = below if clip else np.maximum(below, above)
        shown = weight * below if clip else above
        motif = canvas.foreground[window] | (piece.foreground & (shown >= 0.5))
    canvas.coverage[window] = outcome
    canvas.foreground[window] = motif
    gone = outcome <= 0
    if gone.any():
        canvas.normals[window][gone] = FLAT
    hidden = shown if mode == "over" else shown * walls
    canvas.walls[window] = canvas.walls[window] * (1 - hidden) + shown * walls
    if counts:
        placed = canvas.placed[window]
        canvas.placed[window] = placed + shown * (1 - placed)
    return float(shown.sum(dtype=np.float64))


def mix_normals(below: Float32, above: Float32, share: Float32) -> Float32:
    """Return unit normals interpolated from ``below`` to ``above``; exact for shares of 0 and 1."""
    out = np.where((share >= 1)[..., None], above, below)
    soft = (share > 0) & (share < 1)
    if soft.any():
        under, over = below[soft], above[soft]
        out[soft] = unit(under + share[soft][:, None] * (over - under))
    return out
