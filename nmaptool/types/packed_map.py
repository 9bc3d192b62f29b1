"""A normal map and where it lies in a workspace."""

from __future__ import annotations

from dataclasses import dataclass

from nmaptool.core.arrays import Float32
from nmaptool.core.errors import InputError, UsageError
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.shown import OneLine

_FURTHEST_PX = 30_000


@dataclass(frozen=True, eq=False, repr=False)
class PackedMap(OneLine):
    """A normal map and how it lies in the workspace.

    Parameters
    ----------
    normal_map : NormalMap
    name : str
        Of the layer; default: what the map is called.
    left, top : int
        Place of its first pixel on the canvas, px; may be negative.
    mode : str
        How its vectors blend with those below: ``over``, or a mode of `nmaptool.blend`.
    strength : float
        0 fades it to flat, 1 leaves it.
    mask : (h, w) float32 in [0, 1], optional
        Of the map's size; hides parts of it beside its coverage.
    visible : bool
    group : tuple of str
        Names of the groups it is in, outermost first; layers in one group follow each other.
    """

    normal_map: NormalMap
    name: str = ""
    left: int = 0
    top: int = 0
    mode: str = "over"
    strength: float = 1.0
    mask: Float32 | None = None
    visible: bool = True
    group: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        shown = self.name or self.normal_map.name
        if max(abs(self.left), abs(self.top)) > _FURTHEST_PX:
            raise UsageError(f"{shown}: lies at {self.left}, {self.top}; accepted are places within {_FURTHEST_PX} px")
        if self.mask is not None and self.mask.shape != self.normal_map.frame.shape:
            rows, cols = self.mask.shape
            raise InputError(f"{shown}: its mask is {cols} x {rows}, the map is {self.normal_map.frame}")

    def _line(self) -> str:
        name = self.name or self.normal_map.name
        return f"{name}: {self.normal_map.frame} px at {self.left}, {self.top}, mode {self.mode}"
