"""Compose layers on one canvas; pasting is composing on a background as the lowest layer."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import TypeGuard

from nmaptool.composition.compositor import Canvas, canvas_of, clear_canvas, compose_onto
from nmaptool.composition.placement import is_uneven
from nmaptool.core.errors import InputError, LimitError, UsageError
from nmaptool.core.progress import Progress
from nmaptool.core.units import Length
from nmaptool.core.vectors import mean_abs_curl
from nmaptool.options import CanvasOptions, LayerOptions
from nmaptool.options.compose import ANCHORS
from nmaptool.options.plain_values import plain_values
from nmaptool.types.composition import ComposeReport, Composition
from nmaptool.types.inputs import NormalsLike, as_normal_map
from nmaptool.types.layers import Layer, LayerGroup, LayerLike, as_layers
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.picture import Frame

# pitches that differ by more differ by more than rounding
_SAME_PITCH = 0.01
_SAME_PLACE_PX = 1e-3


def compose(
    layers: Sequence[LayerLike],
    canvas: CanvasOptions | None = None,
    *,
    max_megapixels: float = 270.0,
    progress: Progress | None = None,
) -> Composition:
    """Compose layers, from the lowest to the topmost.

    Parameters
    ----------
    layers : sequence of Layer, LayerGroup, NormalMap or (h, w, 3) float
        A map alone is a layer with the default options. The lowest layer becomes the ground of the others if it has the
        size of the canvas, the mode "over" and no mask, and is not moved.
    canvas : CanvasOptions, optional
        Size, width in mm and ground. Default: the size of the lowest layer.
    max_megapixels : float
        Limit of the canvas size.
    progress : callable, optional
        Called with the name of the stage and the share done, 0 to 1.

    Returns
    -------
    Composition
        The map, where layers lie above the lowest one, and the report.

    Raises
    ------
    InputError
        If there is no layer, or a layer is outside the canvas, covers nothing or has nothing below it to change.
    UsageError
        If a length is in mm and the pitch is unknown, or a layer is neither a Layer nor a map.
    LimitError
        If the canvas is larger than ``max_megapixels``.

    Examples
    --------
    A slanted square in the middle of a flat plate:

    >>> plate, square = np.full((32, 32, 3), (0.0, 0, 1)), np.full((8, 8, 3), (0.6, 0, 0.8))
    >>> int(nm.compose([plate, square]).placed.sum())
    64
    """
    layers = as_layers(layers)
    if not layers:
        raise InputError("nothing to compose: give at least one layer")
    canvas = canvas or CanvasOptions()
    frame = canvas_frame(layers, canvas)
    if frame.rows * frame.cols > max_megapixels * 1e6:
        raise LimitError(
            f"the canvas of {frame} has {frame.rows * frame.cols / 1e6:.0f} megapixels, more than the limit of "
            f"{max_megapixels:g}; make it smaller or raise `max_megapixels`"
        )
    first = layers[0]
    if is_ground(first, frame, canvas):
        return _composed("stack", canvas_of(first.normal_map, frame), layers[1:], canvas, progress)
    return _composed("stack", clear_canvas(frame, canvas.ground), layers, canvas, progress, lowest=True)


def paste(
    background: NormalsLike,
    layers: Sequence[LayerLike],
    *,
    width: Length | None = None,
    progress: Progress | None = None,
) -> Composition:
    """Paste layers on a background, from the lowest to the topmost.

    Parameters
    ----------
    background : NormalMap or (H, W, 3) float of any type
        The result has its size and, where no layer covers it, exactly the same normals.
    layers : sequence of Layer, LayerGroup, NormalMap or (h, w, 3) float
        A map alone is a layer with the default options. Only the motif of a layer is pasted, not the flat background
        around it.
    width : Length, optional
        Width of the whole picture in mm, for lengths given in mm. Default: from the pitch of the background.
    progress : callable, optional
        Called with the name of the stage and the share done, 0 to 1.

    Returns
    -------
    Composition
        The map, where layers lie above the background, and the report.

    Raises
    ------
    InputError
        If a layer is outside the canvas, covers nothing or has nothing below it to change.
    UsageError
        If a length is in mm and the pitch is unknown, or a value is neither a map nor a layer.

    Examples
    --------
    >>> plate, square = np.full((32, 32, 3), (0.0, 0, 1)), np.full((8, 8, 3), (0.6, 0, 0.8))
    >>> place = nm.LayerOptions(at="0px,0px", anchor="top-left")
    >>> pasted = nm.paste(plate, [nm.Layer(square, place)]).normal_map
    >>> pasted.normals[4, 4].tolist(), pasted.normals[16, 16].tolist()
    ([0.6000000238418579, 0.0, 0.800000011920929], [0.0, 0.0, 1.0])
    """
    background, layers = as_normal_map(background, "the background"), as_layers(layers)
    canvas = CanvasOptions(width=width)
    frame = _with_pitch(background.frame, canvas)
    return _composed("paste", canvas_of(background, frame), layers, canvas, progress)


def _composed(
    command: str,
    canvas: Canvas,
    layers: Sequence[Layer | LayerGroup],
    options: CanvasOptions,
    progress: Progress | None,
    lowest: bool = False,
) -> Composition:
    start = time.perf_counter()
    begun = bool(canvas.coverage.any()) and not lowest
    before = mean_abs_curl(canvas.normals, canvas.coverage >= 0.5) if begun else None
    done = 0

    def notify(name: str) -> None:
        nonlocal done
        if progress is not None:
            progress("composing", done / _count(layers))
        done += 1

    compose_onto(canvas, layers, lowest=lowest, progress=notify)
    result = NormalMap(
        canvas.normals,
        canvas.coverage,
        canvas.frame,
        canvas.foreground,
        name=command,
        flat_background=canvas.flat_background,
    )
    report = ComposeReport(
        command=command,
        options=plain_values(options),
        layers=tuple(canvas.layer_reports),
        curl_before=before,
        curl_after=mean_abs_curl(result.normals, result.coverage >= 0.5),
        seconds={"compose": round(time.perf_counter() - start, 4)},
        warnings=tuple(_warnings(layers, canvas.frame)),
    )
    return Composition(result, canvas.placed, report, canvas.walls)


def _count(layers: Sequence[Layer | LayerGroup]) -> int:
    return sum(1 + _count(each.layers) if isinstance(each, LayerGroup) else 1 for each in layers)


def _first_map(layers: Sequence[Layer | LayerGroup]) -> NormalMap:
    first = layers[0]
    return _first_map(first.layers) if isinstance(first, LayerGroup) else first.normal_map


def canvas_frame(layers: Sequence[Layer | LayerGroup], canvas: CanvasOptions) -> Frame:
    """Return the size and pitch of the canvas: from the options, else from the lowest layer."""
    lowest = _first_map(layers).frame
    if canvas.cols_rows is None:
        return _with_pitch(lowest, canvas)
    cols, rows = canvas.cols_rows
    return _with_pitch(Frame(rows, cols, lowest.pitch_mm), canvas)


def _with_pitch(frame: Frame, canvas: CanvasOptions) -> Frame:
    if canvas.width is None:
        return frame
    return replace(frame, pitch_mm=canvas.width.to_mm(1.0, 1) / frame.cols)


def is_ground(layer: Layer | LayerGroup, frame: Frame, canvas: CanvasOptions) -> TypeGuard[Layer]:
    """Whether the lowest layer is used unchanged as the canvas, however its options express its position."""
    if isinstance(layer, LayerGroup) or canvas.ground != "clear":
        return False
    o = layer.options
    if layer.mask is not None or layer.normal_map.frame.shape != frame.shape:
        return False
    # name, clip and anchor do not matter for such a layer; position and scale are checked separately
    plain = replace(o, name="", at=None, anchor="center", scale="1", clip="auto", height_factor=None)
    if plain != LayerOptions() or o.factors != (1.0, 1.0) or o.height_factor not in (None, 1.0):
        return False
    sides = (frame.cols, frame.rows)
    try:
        place = [d.to_px(frame.pitch_mm, side) for d, side in zip(o.place, sides, strict=True)]
    except UsageError:  # mm without a pitch: placing the layer raises the error
        return False
    return all(
        abs(at - part * side) < _SAME_PLACE_PX for at, part, side in zip(place, ANCHORS[o.anchor], sides, strict=True)
    )


def _warnings(layers: Sequence[Layer | LayerGroup], frame: Frame) -> list[str]:
    """Return warnings about effects that may be unintended: different pitches ignored, heights kept when stretched."""
    found: list[str] = []
    for layer in layers:
        if isinstance(layer, LayerGroup):
            found += _warnings(layer.layers, frame)
            continue
        found += layer_warnings(layer.name, layer.normal_map.frame.pitch_mm, layer.options, frame)
    return found


def layer_warnings(name: str, pitch_mm: float | None, o: LayerOptions, frame: Frame) -> list[str]:
    """Return warnings about a layer with its own pitch on a canvas: effects that may be unintended."""
    found: list[str] = []
    if pitch_mm is not None and frame.pitch_mm is not None and o.scale == "1":
        factor = pitch_mm / frame.pitch_mm
        if abs(factor - 1) > _SAME_PITCH:
            found.append(
                f"{name}: its pixels are {pitch_mm:.4g} mm, those of the canvas {frame.pitch_mm:.4g} mm; to keep "
                f"its size in mm, set its scale to {factor:.4g}"
            )
    factors = o.factors
    if not isinstance(factors, Length) and o.height_factor is None and is_uneven(factors):
        even = (factors[0] * factors[1]) ** 0.5
        found.append(
            f"{name}: is stretched unevenly and keeps its heights, so its slopes are multiplied by "
            f"{1 / factors[0]:.3g} across and {1 / factors[1]:.3g} down; a height factor of {even:.3g} keeps them "
            "on average"
        )
    return found
