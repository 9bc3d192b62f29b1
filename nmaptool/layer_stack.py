"""Layers to be composed: maps with their place and mode, and groups of them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from nmaptool.arrays import Float32, read_only
from nmaptool.errors import InputError
from nmaptool.model import NormalMap
from nmaptool.options import GroupOptions, LayerOptions


@dataclass(frozen=True, eq=False)
class Layer:
    """A normal map with its place on a canvas.

    Parameters
    ----------
    normal_map : NormalMap
    options : LayerOptions
    mask : (h, w) float32 in [0, 1], optional
        Of the map's own size: what shows of it.

    Raises
    ------
    InputError
        If the mask is of another size, leaves [0, 1], is not finite, or is black all over.
    """

    normal_map: NormalMap
    options: LayerOptions = field(default_factory=LayerOptions)
    mask: Float32 | None = None

    def __post_init__(self) -> None:
        if self.mask is not None:
            check_mask(self.mask, self.name, self.normal_map.frame.shape)
            object.__setattr__(self, "mask", read_only(self.mask))

    @property
    def name(self) -> str:
        """What to call it."""
        return self.options.name or self.normal_map.name


@dataclass(frozen=True, eq=False)
class LayerGroup:
    """Layers that are composed among themselves first.

    Parameters
    ----------
    layers : tuple of Layer or LayerGroup
        From the lowest to the topmost.
    options : GroupOptions
    mask : (H, W) float32 in [0, 1], optional
        Of the canvas's size: what shows of the group.
    """

    layers: tuple[Layer | LayerGroup, ...]
    options: GroupOptions = field(default_factory=GroupOptions)
    mask: Float32 | None = None

    def __post_init__(self) -> None:
        if not self.layers:
            raise InputError(f"{self.name}: a group needs at least one layer")
        if self.mask is not None:
            check_mask(self.mask, self.name, self.mask.shape)
            object.__setattr__(self, "mask", read_only(self.mask))

    @property
    def name(self) -> str:
        """What to call it."""
        return self.options.name


def check_mask(mask: Float32, name: str, shape: tuple[int, ...]) -> None:
    """Refuse a mask that does not fit ``shape``, leaves [0, 1], is not finite, or shows nothing.

    Raises
    ------
    InputError
    """
    if mask.shape != shape:
        found, wanted = (f"{s[1]} x {s[0]}" if len(s) == 2 else str(s) for s in (mask.shape, shape))
        raise InputError(f"the mask of {name} is {found}, expected {wanted}, as what it masks; resize it")
    if not (np.isfinite(mask).all() and mask.min() >= 0 and mask.max() <= 1):
        raise InputError(f"the mask of {name} must lie between 0 and 1")
    if not mask.any():
        raise InputError(f"the mask of {name} is empty (black all over); white shows the layer")
