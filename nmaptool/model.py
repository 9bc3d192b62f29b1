"""The values that travel between the steps: raw pictures, normal maps and heights, checked once at construction.

Eye space throughout: +x right, +y up, +z to the viewer, picture row 0 at the top. Lengths carry their unit in the name.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.arrays import Float32, Float64, Mask, read_only
from nmaptool.bands import each_band
from nmaptool.errors import InputError
from nmaptool.grid import corner_mean, touching

UNIT_TOLERANCE = 1e-3
_VECTORS_AT_ONCE = 1 << 16
DEFAULT_LONGER_SIDE_MM = 100.0


@dataclass(frozen=True)
class Frame:
    """The picture's grid: its size in pixels and, where known, the size of a pixel.

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


@dataclass(frozen=True, eq=False)
class RasterImage:
    """A picture as its file stores it, before any meaning is given to its channels.

    Parameters
    ----------
    pixels : (H, W, C) uint8, uint16 or float32
        Stored codes, alpha unassociated.
    channels : tuple of str
        Names, one per channel: R, G, B, A (or Y for grey).
    name : str
        What to call it in messages: a file name.
    bits : int
        Bits per channel in the file: 8, 16 or 32 (16 with float pixels is half).
    lossy : bool
        Whether the format changes codes (JPEG).
    attributes : mapping
        nmaptool's own metadata found in the file, keys without prefix.
    color_chunks : tuple of str
        Colour-management data found in the file, such as sRGB, gAMA, iCCP.
    layer : str or None
        Name of the layer that was read.
    """

    pixels: NDArray[Any]
    channels: tuple[str, ...]
    name: str = "image"
    bits: int = 8
    lossy: bool = False
    attributes: Mapping[str, str] = field(default_factory=dict)
    color_chunks: tuple[str, ...] = ()
    layer: str | None = None

    def __post_init__(self) -> None:
        if self.pixels.ndim != 3 or self.pixels.shape[2] != len(self.channels):
            raise InputError(f"{self.name}: pixels of shape {self.pixels.shape} do not fit channels {self.channels}")
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
        return 1 if self.is_float else int(np.iinfo(self.pixels.dtype).max)

    @property
    def alpha(self) -> Float32 | None:
        """(H, W) float32 alpha in [0, 1], or None."""
        if "A" not in self.channels:
            return None
        alpha = self.pixels[..., self.channels.index("A")]
        share: Float32 = alpha.astype(np.float32)
        share /= np.float32(self.max_code)
        return share.clip(0, 1, out=share) if self.is_float else share


@dataclass(frozen=True)
class Decoding:
    """What was decided when codes became normals, and from what.

    Attributes name the value and, with ``_from``, its source: ``given`` (an option), ``file`` (its metadata),
    ``found`` (read off the picture) or ``assumed`` (the default).
    """

    green: str = "up"
    green_from: str = "assumed"
    curl_ratio: float | None = None
    swizzle: str = "r,g,b"
    zero_code: str = "127.5"
    zero_code_from: str = "assumed"
    encoding: str = "unsigned"
    components: str = "xyz"
    components_from: str = "assumed"
    background: str = "none"
    background_from: str = "found"
    rim_pixels: int = 0
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class NormalMap:
    """Unit normals in eye space and where they are defined.

    Parameters
    ----------
    normals : (H, W, 3) float32
        Unit vectors; (0, 0, 1) where coverage is 0.
    coverage : (H, W) float32 in [0, 1]
        Where the map is defined.
    frame : Frame
        Size and pitch.
    foreground : (H, W) bool, optional
        Where the motif is. Default: coverage of one half or more. It differs where the background is a defined, flat
        part of the map.
    name : str
        What to call the map in messages.
    decoding : Decoding
        How its file was read.

    Raises
    ------
    InputError
        If shapes or types do not fit, a value is not finite, a normal is not unit length or coverage leaves [0, 1].
    """

    normals: Float32
    coverage: Float32
    frame: Frame
    foreground: Mask = None  # type: ignore[assignment]
    name: str = "normal map"
    decoding: Decoding = field(default_factory=Decoding)

    def __post_init__(self) -> None:
        shape = self.frame.shape
        if self.normals.shape != (*shape, 3) or self.normals.dtype != np.float32:
            raise InputError(
                f"{self.name}: normals are {self.normals.dtype} {self.normals.shape}, expected float32 {(*shape, 3)}"
            )
        if self.coverage.shape != shape or self.coverage.dtype != np.float32:
            raise InputError(
                f"{self.name}: coverage is {self.coverage.dtype} {self.coverage.shape}, expected float32 {shape}"
            )
        if not _are_unit(self.normals):
            raise InputError(f"{self.name}: normals must be finite and of unit length; use nmaptool.vectors.unit")
        if not (self.coverage.min() >= 0 and self.coverage.max() <= 1):
            raise InputError(f"{self.name}: coverage must lie in [0, 1]")
        if self.foreground is None:
            object.__setattr__(self, "foreground", self.coverage >= 0.5)
        elif self.foreground.shape != shape or self.foreground.dtype != np.bool_:
            raise InputError(f"{self.name}: foreground must be bool of shape {shape}")
        for name in ("normals", "coverage", "foreground"):
            object.__setattr__(self, name, read_only(getattr(self, name)))


def _are_unit(normals: Float32) -> bool:
    """Whether all (H, W, 3) vectors are finite and of unit length."""
    off: list[bool] = []

    def look(band: slice) -> None:
        x, y, z = (normals[band, :, axis] for axis in range(3))
        length2 = x * x
        length2 += y * y
        length2 += z * z
        # also True for NaN
        off.append(not (length2.min() >= 1 - 2 * UNIT_TOLERANCE and length2.max() <= 1 + 2 * UNIT_TOLERANCE))

    with np.errstate(over="ignore", invalid="ignore"):
        each_band(len(normals), max(1, _VECTORS_AT_ONCE // normals.shape[1]), look)
    return not any(off)


@dataclass(frozen=True, eq=False)
class Height:
    """A height field on the corners of the pixels, in millimetres.

    Parameters
    ----------
    z_mm : (H+1, W+1) float64
        Heights at vertices; 0 where no pixel of the domain touches.
    domain : (H, W) bool
        Pixels (faces) that belong to the surface.
    frame : Frame
        Size and pitch (known).
    """

    z_mm: Float64
    domain: Mask
    frame: Frame

    def __post_init__(self) -> None:
        rows, cols = self.frame.shape
        if self.frame.pitch_mm is None:
            raise InputError("a height field needs the size of a pixel in mm")
        if self.z_mm.shape != (rows + 1, cols + 1) or self.z_mm.dtype != np.float64:
            raise InputError(
                f"heights are {self.z_mm.dtype} {self.z_mm.shape}, expected float64 {(rows + 1, cols + 1)}"
            )
        if self.domain.shape != (rows, cols) or self.domain.dtype != np.bool_:
            raise InputError(f"domain is {self.domain.dtype} {self.domain.shape}, expected bool {(rows, cols)}")
        if not np.all(np.isfinite(self.z_mm)):
            raise InputError("heights must be finite")
        if not self.domain.any():
            raise InputError("the height field has no pixel in its domain")
        object.__setattr__(self, "z_mm", read_only(self.z_mm))
        object.__setattr__(self, "domain", read_only(self.domain))

    @property
    def pitch_mm(self) -> float:
        """Millimetres per pixel."""
        assert self.frame.pitch_mm is not None  # checked at construction
        return self.frame.pitch_mm

    @property
    def vertex_mask(self) -> Mask:
        """(H+1, W+1) bool: vertices that touch the domain."""
        return touching(self.domain)

    @property
    def range_mm(self) -> tuple[float, float]:
        """Lowest and highest vertex of the domain."""
        inside = self.z_mm[self.vertex_mask]
        return float(inside.min()), float(inside.max())

    def at_pixels(self) -> Float64:
        """(H, W) float64 heights in mm at pixel centres (mean of the corners), NaN outside the domain."""
        centre = corner_mean(self.z_mm)
        centre[~self.domain] = np.nan
        return centre
