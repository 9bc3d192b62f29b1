"""Layers to be composed: maps with their place and mode, and groups of them."""

from __future__ import annotations

from dataclasses import dataclass, field

from nmaptool.core.arrays import Float32, read_only
from nmaptool.core.errors import InputError
from nmaptool.options import GroupOptions, LayerOptions
from nmaptool.types.normal_map import NormalMap


@dataclass(frozen=True, eq=False)
class Layer:
    """A normal map with its place on a canvas.

    Parameters
    ----------
    normal_map : NormalMap
    options : LayerOptions
    mask : (h, w) float32 in [0, 1], optional
        Of the map's own size: what shows of it.
    mask_name : str
        What to call the mask in messages, such as its file.

    Raises
    ------
    InputError
        If the mask is of another size, leaves [0, 1], is not finite, or is black all over.
    """

    normal_map: NormalMap
    options: LayerOptions = field(default_factory=LayerOptions)
    mask: Float32 | None = None
    mask_name: str = ""

    def __post_init__(self) -> None:
        if self.mask is not None:
            check_mask(self.mask, self.name, self.normal_map.frame.shape, self.mask_name)
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
    mask_name : str
        What to call the mask in messages, such as its file.
    """

    layers: tuple[Layer | LayerGroup, ...]
    options: GroupOptions = field(default_factory=GroupOptions)
    mask: Float32 | None = None
    mask_name: str = ""

    def __post_init__(self) -> None:
        if not self.layers:
            raise InputError(f"{self.name}: a group needs at least one layer")
        if self.mask is not None:
            check_mask(self.mask, self.name, self.mask.shape, self.mask_name)
            object.__setattr__(self, "mask", read_only(self.mask))

    @property
    def name(self) -> str:
        """What to call it."""
        return self.options.name


def check_mask(mask: Float32, name: str, shape: tuple[int, ...], mask_name: str = "") -> None:
    """Refuse a mask that does not fit ``shape``, leaves [0, 1], is not finite, or shows nothing.

    Raises
    ------
    InputError
        Says ``name``, the layer, and ``mask_name``, the mask's file, where it has one.
    """
    subject = f"{mask_name}: the mask of {name}" if mask_name else f"the mask of {name}"
    if mask.shape != shape:
        found, wanted = (f"{s[1]} x {s[0]}" if len(s) == 2 else str(s) for s in (mask.shape, shape))
        raise InputError(f"{subject} is {found}, expected {wanted}, as what it masks; resize it")
    low, high = float(mask.min()), float(mask.max())
    if not (low >= 0 and high <= 1):  # also for NaN
        raise InputError(f"{subject} must lie between 0 and 1, but holds {low:g} to {high:g}; scale its values")
    if not mask.any():
        raise InputError(f"{subject} is empty (black all over); white shows the layer")
