"""Where the layers lie on the canvas, for the handles of the page."""

from __future__ import annotations

from typing import Any

from nmaptool.composition.placing import matrix_of
from nmaptool.io.recipes.scenes import Scene
from nmaptool.studio.layers import maps_of
from nmaptool.types.layers import Layer, LayerGroup


def placements(scene: Scene) -> dict[str, Any]:
    """Return the message with the size of the canvas and, for each map, its size and its matrix to the canvas in px."""
    frame = scene.composition.normal_map.frame
    stack = scene.stacks[0]
    read = _flat(stack.layers)
    layers = []
    for (place, _), layer in zip(maps_of(stack.recipe.layers), read, strict=True):
        rows, cols = layer.normal_map.frame.shape
        matrix = matrix_of(layer, frame).round(4).tolist()
        layers.append({"place": place, "cols": cols, "rows": rows, "matrix": matrix})
    canvas = {"cols": frame.cols, "rows": frame.rows, "pitch_mm": frame.pitch_mm}
    return {"kind": "placements", "canvas": canvas, "layers": layers}


def _flat(layers: tuple[Layer | LayerGroup, ...]) -> list[Layer]:
    found: list[Layer] = []
    for layer in layers:
        found += [layer] if isinstance(layer, Layer) else _flat(layer.layers)
    return found
