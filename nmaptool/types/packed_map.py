"""A normal map with its place in a workspace."""

from __future__ import annotations

from dataclasses import dataclass

from nmaptool.core.arrays import Float32
from nmaptool.core.errors import InputError, UsageError
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.shown import OneLine

_FURTHEST_PX = 30_000


@dataclass(frozen=True, eq=False, repr=False)
class PackedMap(OneLine):
    """A normal map and its settings as a layer of a workspace.

    Parameters
    ----------
    normal_map : NormalMap
    name : str
        Name of the layer. Default: the name of the map.
    left, top : int
        Position of its top left pixel on the canvas, px; may be negative.
    mode : str
        How its vectors blend with those below: ``over``, or a mode of `nmaptool.blend`.
    strength : float
        0 fades the map to flat, 1 leaves it unchanged.
    mask : (h, w) float32 in [0, 1], optional
        Has the size of the map; hides parts of it in addition to its coverage.
    visible : bool
    group : tuple of str
        Names of the groups that contain it, outermost first. Only neighbouring layers can share a group.
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
            raise UsageError(
                f"{shown}: is placed at {self.left}, {self.top}; positions must be within {_FURTHEST_PX} px"
            )
        if self.mask is not None and self.mask.shape != self.normal_map.frame.shape:
            rows, cols = self.mask.shape
            raise InputError(
                f"{shown}: its mask is {cols} x {rows} but the map is {self.normal_map.frame}; make them the same size"
            )

    def _line(self) -> str:
        name = self.name or self.normal_map.name
        return f"{name}: {self.normal_map.frame} px at {self.left}, {self.top}, mode {self.mode}"
