"""The table of blend modes: the name, meaning and function of each.

To add a mode, add an entry here and its kernel in `nmaptool.composition.blend_kernels`. Help texts, recipes, error
messages and the README's list are made from the table. A program may add a mode at run time:
``BLEND_MODES["mine"] = BlendMode(...)``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any, Literal, cast

# (base, detail, result, two work arrays); each of the first three is a triple of component arrays
Kernel = Callable[[Any, Any, Any, Any], None]
_KERNELS = "nmaptool.composition.blend_kernels"


@dataclass(frozen=True)
class BlendMode:
    """One way of blending a detail normal with a base normal.

    Parameters
    ----------
    meaning : str
        What the mode does, as the predicate of a sentence whose subject is its name.
    kernel : callable or str
        Writes the blended components, not normalised, into its third argument and does not change the first two:
        (base, detail, result, two work arrays). A string names a function in
        `nmaptool.composition.blend_kernels`, which is loaded on first use.
    fades : str
        Effect of strength: ``detail`` scales the detail's slopes; ``sum`` weights the detail in the sum; ``result``
        mixes the result with the base.
    keeps_flat : bool
        A flat detail changes nothing.
    flat_base : bool
        On a flat base, the result is the detail unchanged.
    adds_slopes : bool
        The formula works on slopes, so normals that face away must be reduced to a slope first.
    """

    meaning: str
    kernel: Kernel | str
    fades: Literal["detail", "sum", "result"] = "detail"
    keeps_flat: bool = True
    flat_base: bool = True
    adds_slopes: bool = False

    @property
    def function(self) -> Kernel:
        """The kernel itself."""
        if isinstance(self.kernel, str):
            return cast("Kernel", getattr(import_module(_KERNELS), self.kernel))
        return self.kernel


BLEND_MODES: dict[str, BlendMode] = {
    "rnm": BlendMode("rotates the detail with the base; restores the original from the maps of bake", "reoriented"),
    "pd": BlendMode("adds slopes, so two surfaces give a surface", "partial_derivative", adds_slopes=True),
    "whiteout": BlendMode("is a cheaper form of pd", "whiteout", adds_slopes=True),
    "udn": BlendMode("is cheaper still and keeps the base's z", "udn", flat_base=False, adds_slopes=True),
    "linear": BlendMode("is the direction of the sum", "linear", "sum", keeps_flat=False, flat_base=False),
    "overlay": BlendMode("is the overlay of image editors", "overlay", "result", keeps_flat=False, flat_base=False),
}


def blend_meanings() -> dict[str, str]:
    """The meaning of each mode, including those added at run time."""
    return {name: mode.meaning for name, mode in BLEND_MODES.items()}


def layer_meanings() -> dict[str, str]:
    """The meaning of each mode of a layer: ``over`` and the blend modes."""
    return {"over": "covers what is below", **blend_meanings()}
