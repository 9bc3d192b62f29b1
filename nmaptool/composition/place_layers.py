"""Place the layers of a composition for a layered file, without blending them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from nmaptool.composition.compose import canvas_frame, is_ground
from nmaptool.composition.compositor import clear_canvas, compose_onto, group_piece
from nmaptool.composition.placement import Piece
from nmaptool.composition.placing import place
from nmaptool.core.errors import InputError
from nmaptool.options import CanvasOptions, GroupOptions
from nmaptool.types.layers import Layer, LayerGroup, LayerLike, as_layers, errors_about
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.packed_map import PackedMap
from nmaptool.types.picture import Frame


def place_layers(
    layers: Sequence[LayerLike], canvas: CanvasOptions | None = None
) -> tuple[tuple[PackedMap, ...], Frame]:
    """Move, rotate, mask and feather layers for a canvas, without blending them: the input of `nmaptool.pack`.

    Parameters
    ----------
    layers : sequence of Layer, LayerGroup, NormalMap or (h, w, 3) float
        From the lowest to the topmost. A group whose layers all have the mode "over" stays a group of these layers. Any
        other group, or one with a mode, strength or mask of its own, becomes one layer: image editors have no such
        groups.
    canvas : CanvasOptions, optional
        Size, width in mm and ground. Default: the size of the lowest layer.

    Returns
    -------
    layers : tuple of PackedMap
        Layers, cropped to what they cover. Their vectors are transformed; masks and soft edges are in the coverage.
    frame : Frame
        The canvas.

    Raises
    ------
    InputError
        If there is no layer, or one is outside the canvas or covers nothing.
    UsageError
        If a length is in mm and the pitch is unknown, or a layer is neither a Layer nor a map.

    Examples
    --------
    >>> plate, square = np.full((32, 32, 3), (0.0, 0, 1)), np.full((8, 8, 3), (0.6, 0, 0.8))
    >>> layers, frame = nm.place_layers([plate, square])
    >>> [(layer.left, layer.top) for layer in layers]
    [(0, 0), (12, 12)]
    """
    layers = as_layers(layers)
    if not layers:
        raise InputError("nothing to pack: give at least one layer")
    canvas = canvas or CanvasOptions()
    frame = canvas_frame(layers, canvas)
    first = layers[0]
    if is_ground(first, frame, canvas):  # includes its flat background, unlike other layers
        ground = PackedMap(replace(first.normal_map, frame=frame), first.options.name)
        return (ground, *_placed(layers[1:], frame, ())), frame
    return tuple(_placed(layers, frame, ())), frame


def _placed(layers: Sequence[Layer | LayerGroup], frame: Frame, group: tuple[str, ...]) -> list[PackedMap]:
    found: list[PackedMap] = []
    for layer in layers:
        if isinstance(layer, Layer):
            found.append(_packed(place(layer, frame)[0], layer, frame, group))
        elif layer.mask is None and layer.options == GroupOptions(layer.name) and _all_over(layer):
            found += _placed(layer.layers, frame, (*group, layer.name))
        else:
            inner = compose_onto(clear_canvas(frame, "clear"), layer.layers, in_group=True)
            found.append(_packed(group_piece(inner, layer), layer, frame, group))
    return found


def _all_over(group: LayerGroup) -> bool:
    return all(
        layer.options.mode == "over" and (isinstance(layer, Layer) or _all_over(layer)) for layer in group.layers
    )


def _packed(piece: Piece, layer: Layer | LayerGroup, frame: Frame, group: tuple[str, ...]) -> PackedMap:
    """Crop a piece to what it covers."""
    rows, cols = (np.flatnonzero(piece.coverage.any(axis=axis)) for axis in (1, 0))
    if not rows.size:
        with errors_about(layer):
            raise InputError(f"{layer.name}: covers no pixel of the canvas; check its mask, alpha and position")
    part = slice(int(rows[0]), int(rows[-1]) + 1), slice(int(cols[0]), int(cols[-1]) + 1)
    coverage = piece.coverage[part]
    own = NormalMap(
        piece.normals[part],
        coverage,
        Frame(coverage.shape[0], coverage.shape[1], frame.pitch_mm),
        piece.foreground[part],
        name=layer.name,
    )
    left, top = piece.left + part[1].start, piece.top + part[0].start
    o = layer.options
    return PackedMap(own, o.name, left, top, o.mode, o.strength, group=group)
