"""The layers of the document: how the page shows them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from nmaptool.types.recipe import Entry, RecipeGroup, RecipeLayer


def described(layers: Sequence[Entry], above: tuple[int, ...] = ()) -> list[dict[str, Any]]:
    """Return the layers for the page, from the lowest to the topmost, those of groups inside them."""
    return [_described(layer, (*above, number)) for number, layer in enumerate(layers)]


def _described(layer: Entry, place: tuple[int, ...]) -> dict[str, Any]:
    return {
        "place": place,
        "name": layer.options.name or (layer.file if isinstance(layer, RecipeLayer) else layer.label),
        "hidden": layer.hidden,
        "layers": described(layer.layers, place) if isinstance(layer, RecipeGroup) else None,
    }
