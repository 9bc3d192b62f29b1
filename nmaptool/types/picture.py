"""Pictures as stored in files, and the pixel grid."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, read_only
from nmaptool.core.errors import InputError
from nmaptool.types.shown import OneLine


@dataclass(frozen=True)
class Frame:
    """The grid of a picture: its size in pixels and, if known, the size of a pixel.

    Parameters
    ----------
    rows, cols : int
        Pixels down and across, each at least 1.
    pitch_mm : float or None
        Millimetres per pixel.
    """

    rows: int
    cols: int
    pitch_mm: float | None = None

    def __post_init__(self) -> None:
        if self.rows < 1 or self.cols < 1:
            raise InputError(f"a picture of {self.cols} x {self.rows} pixels is empty")
        if self.pitch_mm is not None and not (math.isfinite(self.pitch_mm) and self.pitch_mm > 0):
            raise InputError(f"pitch of {self.pitch_mm} mm per pixel: must be greater than zero")

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, cols)."""
        return (self.rows, self.cols)

    @property
    def longer_side(self) -> int:
        """Pixels on the longer side."""
        return max(self.rows, self.cols)

    def __str__(self) -> str:
        return f"{self.cols} x {self.rows}"

    @property
    def with_pitch(self) -> str:
        """Size and pitch as text, such as "96 x 64 px, 0.5 mm per px"."""
        pitch = "pitch unknown" if self.pitch_mm is None else f"{self.pitch_mm:.4g} mm per px"
        return f"{self} px, {pitch}"


def largest_code(pixels: NDArray[Any]) -> int:
    """The stored value of white: 255 or 65535; 1 for floats."""
    return 1 if pixels.dtype == np.float32 else int(np.iinfo(pixels.dtype).max)


@dataclass(frozen=True)
class DepthFacts:
    """What a depth or height file states about its values.

    Parameters
    ----------
    kind : str
        ``depth`` (distance from the eye, in floats; in integers, white is near) or ``height``.
    black_mm, white_mm : float or None
        Depth or height of code 0 and of the largest integer code; None if the file does not state it.
    fov_deg : float or None
        Field of view, across the longer side, of the camera that rendered the depths; 0 if it was orthographic.
    at : str
        Positions of the heights: the ``centers`` of the pixels, or their ``corners``, one more down and across.
    """

    kind: Literal["depth", "height"]
    black_mm: float | None = None
    white_mm: float | None = None
    fov_deg: float | None = None
    at: str = "centers"


# how to show a picture by its EXIF orientation: whether rows become columns, then the steps through rows and columns
_UPRIGHT = {
    2: (False, 1, -1),
    3: (False, -1, -1),
    4: (False, -1, 1),
    5: (True, 1, 1),
    6: (True, 1, -1),
    7: (True, -1, -1),
    8: (True, -1, 1),
}


@dataclass(frozen=True, eq=False, repr=False)
class RasterImage(OneLine):
    """A picture as stored in its file, before its channels are interpreted.

    Parameters
    ----------
    pixels : (H, W, C) uint8, uint16 or float32
        Stored codes, alpha unassociated.
    channels : tuple of str
        Names, one per channel: R, G, B, A (or Y for grey).
    name : str
        Name for messages: a file name.
    bits : int
        Bits per channel in the file: 8, 16 or 32 (16 with float pixels is half).
    lossy : bool
        Whether the format changes codes (JPEG).
    attributes : mapping
        nmaptool's own metadata found in the file, keys without prefix.
    depth_facts : DepthFacts or None
        What that metadata states about depths or heights.
    color_chunks : tuple of str
        Colour-management data found in the file, such as sRGB, gAMA, iCCP.
    layer : str or None
        Name of the layer that was read.
    nodata : float or None
        Stored value that means "no data", as the file states it, such as the tag of an elevation model.
    orientation : int
        EXIF orientation that the file states, 1 to 8; the pixels are as stored, not turned.
    notes : tuple of str
        What is unusual about the file, each a clause for a message, such as "its colours are a palette of 256".
    coarse : bool
        Whether its values are coarser than ``bits`` says: a palette, fewer bits per channel, block compression, inks.
    """

    pixels: NDArray[Any]
    channels: tuple[str, ...]
    name: str = "image"
    bits: int = 8
    lossy: bool = False
    attributes: Mapping[str, str] = field(default_factory=dict)
    color_chunks: tuple[str, ...] = ()
    layer: str | None = None
    depth_facts: DepthFacts | None = None
    nodata: float | None = None
    orientation: int = 1
    notes: tuple[str, ...] = ()
    coarse: bool = False

    def __post_init__(self) -> None:
        if self.pixels.ndim != 3 or self.pixels.shape[2] != len(self.channels):
            raise InputError(f"{self.name}: pixels of shape {self.pixels.shape} do not match channels {self.channels}")
        if self.pixels.dtype not in (np.uint8, np.uint16, np.float32):
            raise InputError(f"{self.name}: pixels of type {self.pixels.dtype}; expected uint8, uint16 or float32")

    @property
    def frame(self) -> Frame:
        """Size, and the pitch that the file states."""
        rows, cols = self.pixels.shape[:2]
        try:
            pitch = float(self.attributes["pitch_mm"])
        except (KeyError, ValueError):
            pitch = None
        return Frame(rows, cols, pitch if pitch is not None and math.isfinite(pitch) and pitch > 0 else None)

    @property
    def is_float(self) -> bool:
        """Whether the file stores floating-point numbers."""
        return self.pixels.dtype == np.float32

    @property
    def max_code(self) -> int:
        """Largest integer code (255 or 65535); 1 for floating point."""
        return largest_code(self.pixels)

    @cached_property
    def alpha(self) -> Float32 | None:
        """(H, W) float32 alpha in [0, 1], read-only; None without alpha."""
        if "A" not in self.channels:
            return None
        alpha = self.pixels[..., self.channels.index("A")]
        share: Float32 = alpha.astype(np.float32)
        share /= np.float32(self.max_code)
        return read_only(share.clip(0, 1, out=share) if self.is_float else share)

    def upright(self) -> RasterImage:
        """The picture as viewers show it: turned or mirrored by its EXIF orientation.

        >>> RasterImage(np.zeros((2, 3, 1), np.uint8), ("Y",), orientation=6).upright().frame.shape
        (3, 2)
        """
        if self.orientation not in _UPRIGHT:
            return self
        transposed, rows, cols = _UPRIGHT[self.orientation]
        pixels = self.pixels.swapaxes(0, 1) if transposed else self.pixels
        return replace(self, pixels=np.ascontiguousarray(pixels[::rows, ::cols]), orientation=1)

    def _line(self) -> str:
        kind = f"{self.bits}-bit {'float' if self.is_float else 'codes'}"
        return f"{self.name}: {self.frame.with_pitch}, channels {', '.join(self.channels)}, {kind}"
