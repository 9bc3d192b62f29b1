"""Layers for composing: maps with their position and mode, and groups of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from nmaptool.core.arrays import Float32, read_only
from nmaptool.core.errors import InputError, NmaptoolError, UsageError
from nmaptool.options import GroupOptions, LayerOptions
from nmaptool.types.inputs import NormalsLike, as_normal_map
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.plain_arrays import as_float32
from nmaptool.types.shown import OneLine, counted


@dataclass(frozen=True, eq=False, repr=False)
class Layer(OneLine):
    """A normal map with its position on a canvas.

    Parameters
    ----------
    normal_map : NormalMap or (h, w, 3) float of any type
    options : LayerOptions
    mask : (h, w) bool or float in [0, 1], optional
        Has the size of the map: 1 shows the layer, 0 hides it.
    mask_name : str
        Name of the mask for messages, such as its file.
    origin : str
        Start of errors about it, such as "scene.toml, line 14: layer 2 (bunny)". Default: its name.

    Raises
    ------
    InputError
        If the mask has another size, has values that are not finite or outside [0, 1], or is entirely black.
    UsageError
        If the map or the mask has a type that is not accepted.
    """

    normal_map: NormalMap
    options: LayerOptions = field(default_factory=LayerOptions)
    mask: Float32 | None = None
    mask_name: str = ""
    origin: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "normal_map", as_normal_map(self.normal_map, "the layer"))
        if self.mask is not None:
            object.__setattr__(self, "mask", read_only(as_float32(self.mask, f"the mask of {self.name}")))
            check_mask(self.mask, self.name, self.normal_map.frame.shape, self.mask_name)

    @property
    def name(self) -> str:
        """The name for messages."""
        return self.options.name or self.normal_map.name

    def _line(self) -> str:
        masked = "" if self.mask is None else ", masked"
        return f"{self.name}: {self.normal_map.frame.with_pitch}, mode {self.options.mode}{masked}"


@dataclass(frozen=True, eq=False, repr=False)
class LayerGroup(OneLine):
    """Layers that are composed with each other first.

    Parameters
    ----------
    layers : sequence of Layer, LayerGroup, NormalMap or (h, w, 3) float
        From the lowest to the topmost; a map alone is a layer with the default options.
    options : GroupOptions
    mask : (H, W) bool or float in [0, 1], optional
        Has the size of the canvas: 1 shows the group, 0 hides it.
    mask_name : str
        Name of the mask for messages, such as its file.
    origin : str
        Start of errors about it, such as "scene.toml, line 14: layer 2 (bunny)". Default: its name.
    """

    layers: tuple[Layer | LayerGroup, ...]
    options: GroupOptions = field(default_factory=GroupOptions)
    mask: Float32 | None = None
    mask_name: str = ""
    origin: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "layers", as_layers(self.layers, f"the layers of {self.name or 'a group'}"))
        if not self.layers:
            raise InputError(f"{self.name}: a group needs at least one layer")
        if self.mask is not None:
            object.__setattr__(self, "mask", read_only(as_float32(self.mask, f"the mask of {self.name}")))
            check_mask(self.mask, self.name, self.mask.shape, self.mask_name)

    @property
    def name(self) -> str:
        """The name for messages."""
        return self.options.name

    def _line(self) -> str:
        return f"{self.name}: {counted(len(self.layers), 'layer')}"


@contextmanager
def errors_about(layer: Layer | LayerGroup) -> Iterator[None]:
    """Begin errors that are raised within with the origin of a layer, if it has one."""
    try:
        yield
    except NmaptoolError as error:
        if not layer.origin:
            raise
        raise type(error)(f"{layer.origin}: {str(error).removeprefix(f'{layer.name}: ')}") from None


LayerLike: TypeAlias = Layer | LayerGroup | NormalsLike


def as_layers(values: Any, what: str = "the layers") -> tuple[Layer | LayerGroup, ...]:
    """Return layers and groups unchanged, and maps and arrays as layers with the default options.

    Raises
    ------
    UsageError
        If the value is not a list of these.
    """
    if isinstance(values, Layer | LayerGroup | NormalMap | str) or not isinstance(values, Iterable):
        raise UsageError(f"{what} must be a list of Layer objects, found {type(values).__name__}")
    return tuple(each if isinstance(each, Layer | LayerGroup) else Layer(each) for each in values)


def check_mask(mask: Float32, name: str, shape: tuple[int, ...], mask_name: str = "") -> None:
    """Refuse a mask that has another shape, has values outside [0, 1] or not finite, or is entirely black.

    Raises
    ------
    InputError
        The message names the layer, ``name``, and the file of the mask, ``mask_name``, if there is one.
    """
    check_mask_size(name, mask.shape, shape, mask_name)
    check_mask_values(mask, name, mask_name)
    if not mask.any():
        raise mask_is_black(name, mask_name)


def check_mask_values(mask: Float32, name: str, mask_name: str = "") -> None:
    """Refuse a mask that has values outside [0, 1] or not finite.

    Raises
    ------
    InputError
        As `check_mask`.
    """
    low, high = float(mask.min()), float(mask.max())
    if not (low >= 0 and high <= 1):  # also for NaN
        raise InputError(
            f"{_mask_of(name, mask_name)} must lie between 0 and 1, but holds {low:g} to {high:g}; scale its values"
        )


def check_mask_size(name: str, found: tuple[int, ...], shape: tuple[int, ...], mask_name: str = "") -> None:
    """Refuse a mask that has another shape than the layer.

    Raises
    ------
    InputError
        As `check_mask`.
    """
    if found != shape:
        size, wanted = (f"{s[1]} x {s[0]}" if len(s) == 2 else str(s) for s in (found, shape))
        raise InputError(
            f"{_mask_of(name, mask_name)} is {size}, expected {wanted}, the size of what it masks; resize it"
        )


def mask_is_black(name: str, mask_name: str = "") -> InputError:
    """The error about a mask without white."""
    return InputError(
        f"{_mask_of(name, mask_name)} is entirely black, which hides everything; paint what to show white"
    )


def _mask_of(name: str, mask_name: str) -> str:
    return f"{mask_name}: the mask of {name}" if mask_name else f"the mask of {name}"
