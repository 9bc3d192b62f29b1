"""Layered workspaces for image editors: layers of codes with positions, masks and groups."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32
from nmaptool.core.errors import InputError
from nmaptool.types.picture import Frame, largest_code
from nmaptool.types.shown import OneLine, counted

# the mode that paints one layer over another; every other mode computes with codes as if they were colours
NORMAL_BLEND = "normal"
# the mode of a group that only keeps layers together: each blends with what is below the group
PASS_THROUGH = "pass through"
MASK_SUFFIX = " [mask]"


@dataclass(frozen=True, eq=False, repr=False)
class WorkspaceMask(OneLine):
    """A grey picture that hides parts of a layer.

    Parameters
    ----------
    values : (h, w) uint8, uint16 or float32
        White (the largest code, or 1) shows, black hides.
    left, top : int
        Position on the canvas, px; may be negative.
    outside : float
        Value outside its rectangle, 0 to 1.
    enabled : bool
        Whether the editor applies it.
    """

    values: NDArray[Any]
    left: int = 0
    top: int = 0
    outside: float = 0.0
    enabled: bool = True

    def __post_init__(self) -> None:
        if self.values.ndim != 2 or self.values.dtype not in (np.uint8, np.uint16, np.float32):
            raise InputError(
                f"a layer's mask is {self.values.dtype} {self.values.shape}; expected grey codes or floats"
            )


@dataclass(frozen=True, eq=False)
class WorkspaceGroup:
    """A group of layers; two groups with the same name are different groups.

    Parameters
    ----------
    name : str
    visible : bool
    opacity : float
        0 to 1.
    blend_mode : str
        As the editor names it: ``normal`` mixes its layers first, ``pass through`` only keeps them together.
    """

    name: str
    visible: bool = True
    opacity: float = 1.0
    blend_mode: str = NORMAL_BLEND


@dataclass(frozen=True, eq=False, repr=False)
class WorkspaceLayer(OneLine):
    """One layer as an image editor stores it.

    Parameters
    ----------
    name : str
    pixels : (h, w, 4) uint8, uint16 or float32
        R, G, B and unassociated alpha: codes, or signed normals if float32 and ``signed``.
    left, top : int
        Position of its top left pixel on the canvas, px; may be negative or outside the canvas.
    visible : bool
    opacity : float
        0 to 1.
    blend_mode : str
        As the editor names it; ``normal`` paints over what is below.
    mask : WorkspaceMask or None
    groups : tuple of WorkspaceGroup
        The groups that contain it, outermost first.
    facts : mapping
        nmaptool's metadata of the layer; empty if an editor dropped it.
    signed : bool
        Whether floats hold n itself, not (n + 1)/2.
    """

    name: str
    pixels: NDArray[Any]
    left: int = 0
    top: int = 0
    visible: bool = True
    opacity: float = 1.0
    blend_mode: str = NORMAL_BLEND
    mask: WorkspaceMask | None = None
    groups: tuple[WorkspaceGroup, ...] = ()
    facts: Mapping[str, Any] = field(default_factory=dict)
    signed: bool = False

    def __post_init__(self) -> None:
        if self.pixels.ndim != 3 or self.pixels.shape[2] != 4 or min(self.pixels.shape[:2]) < 1:
            raise InputError(f"layer {self.name!r}: pixels of shape {self.pixels.shape}; expected (h, w, 4), not empty")
        if self.pixels.dtype not in (np.uint8, np.uint16, np.float32):
            raise InputError(f"layer {self.name!r}: pixels of type {self.pixels.dtype}; expected codes or float32")
        if not 0 <= self.opacity <= 1:
            raise InputError(f"layer {self.name!r}: opacity {self.opacity:g}; expected 0 to 1")

    @property
    def size(self) -> tuple[int, int]:
        """(rows, cols)."""
        return self.pixels.shape[0], self.pixels.shape[1]

    @property
    def max_code(self) -> int:
        """Largest code (255 or 65535); 1 for floats."""
        return largest_code(self.pixels)

    @property
    def alpha(self) -> Float32:
        """(h, w) float32 in [0, 1]."""
        alpha = np.nan_to_num(self.pixels[..., 3].astype(np.float32)) / np.float32(self.max_code)
        return np.asarray(alpha.clip(0, 1), np.float32)

    @property
    def shown(self) -> bool:
        """Whether it and all its groups are visible."""
        return self.visible and all(group.visible for group in self.groups)

    def _line(self) -> str:
        rows, cols = self.size
        return f"{self.name}: {cols} x {rows} px at {self.left}, {self.top}, {'shown' if self.shown else 'hidden'}"


@dataclass(frozen=True, eq=False, repr=False)
class Workspace(OneLine):
    """Layers on a canvas.

    Parameters
    ----------
    frame : Frame
        Size of the canvas, and mm per px if known.
    layers : tuple of WorkspaceLayer
        Bottom to top.
    bits : int
        Bits per channel: 8, 16 or 32 (16 with ``half``).
    half : bool
        Whether floats are stored in half precision.
    name : str
        Name for messages: a file name.
    metadata : mapping or None
        nmaptool's metadata of the whole file; None if an editor dropped it.
    color_profile : str or None
        Colour profile that the file carries.
    skipped : tuple of (name, what)
        Layers without pixels, such as adjustments.
    """

    frame: Frame
    layers: tuple[WorkspaceLayer, ...]
    bits: int = 16
    half: bool = False
    name: str = "workspace"
    metadata: Mapping[str, Any] | None = None
    color_profile: str | None = None
    skipped: tuple[tuple[str, str], ...] = ()

    def __post_init__(self) -> None:
        if not self.layers:
            raise InputError(f"{self.name}: has no layer with pixels")

    def _line(self) -> str:
        return f"{self.name}: {self.frame.with_pitch}, {self.bits} bits, {counted(len(self.layers), 'layer')}"


def overlap(
    left: int, top: int, size: tuple[int, int], frame: Frame
) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
    """The part of a canvas that a picture of ``size`` at (left, top) covers: slices of the canvas and of the picture.

    Both are empty if the picture lies outside the canvas.

    >>> overlap(-2, 1, (4, 5), Frame(10, 10))
    ((slice(1, 5, None), slice(0, 3, None)), (slice(0, 4, None), slice(2, 5, None)))
    """
    spans = []
    for start, length, limit in ((top, size[0], frame.rows), (left, size[1], frame.cols)):
        low = min(max(start, 0), limit)
        high = max(min(start + length, limit), low)
        spans.append((slice(low, high), slice(low - start, high - start)))
    return (spans[0][0], spans[1][0]), (spans[0][1], spans[1][1])


def mask_over(layer: WorkspaceLayer) -> Float32:
    """(h, w) float32 in [0, 1]: the layer's mask over its own rectangle; 1 everywhere if it has none."""
    mask = layer.mask
    if mask is None or not mask.enabled:
        return np.ones(layer.size, np.float32)
    out = np.full(layer.size, mask.outside, np.float32)
    there, own = overlap(mask.left - layer.left, mask.top - layer.top, mask.values.shape, Frame(*layer.size))
    shown = np.nan_to_num(mask.values[own].astype(np.float32), posinf=1.0, neginf=0.0)
    out[there] = (shown / np.float32(largest_code(mask.values))).clip(0, 1)
    return out


def unique_names(names: list[str], taken: tuple[str, ...] = ()) -> list[str]:
    """Make names unique: drop control characters, fill in empty names, number repeated ones.

    >>> unique_names(["a", "a", ""])
    ['a', 'a 2', 'layer']
    """
    seen = {name.casefold() for name in taken}
    out = []
    for name in names:
        plain = "".join(c for c in name if c.isprintable()).strip() or "layer"
        found, number = plain, 2
        while found.casefold() in seen:
            found, number = f"{plain} {number}", number + 1
        seen.add(found.casefold())
        out.append(found)
    return out


@dataclass(frozen=True)
class WorkspaceFinding:
    """A change that an editor made to a workspace, and its remedy.

    Parameters
    ----------
    code : str
        Kind of the finding, such as ``turned`` or ``eight-bit``.
    layer : str or None
        Name of the layer; None for the whole file.
    message, remedy : str
    """

    code: str
    layer: str | None
    message: str
    remedy: str
