"""Errors about the layers of a recipe, with its keys instead of flags."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from nmaptool.core.errors import NmaptoolError

if TYPE_CHECKING:
    import nmaptool as nm


@contextmanager
def errors_of(stack: nm.Stack) -> Iterator[None]:
    """Make errors that are raised within name the recipe and its keys: ``at``, not ``--at``."""
    from nmaptool.composition.recipe_values import with_recipe_keys

    try:
        yield
    except NmaptoolError as error:
        text = with_recipe_keys(str(error))
        if not text.startswith(tuple(_origins(stack.layers))):
            text = f"{stack.recipe.name}: {text}"
        raise type(error)(text) from None


def _origins(layers: Sequence[nm.Layer | nm.LayerGroup]) -> Iterator[str]:
    for layer in layers:
        if layer.origin:
            yield f"{layer.origin}: "
        yield from _origins(getattr(layer, "layers", ()))
