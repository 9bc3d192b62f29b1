"""Normal maps: unit normals in eye space, and where they are defined."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float32, Mask, read_only
from nmaptool.core.errors import InputError
from nmaptool.core.parallel import for_each_band
from nmaptool.types.picture import Frame
from nmaptool.types.plain_arrays import as_mask, unit_normals
from nmaptool.types.shown import Pictured

UNIT_TOLERANCE = 1e-3


_VECTORS_AT_ONCE = 1 << 16


@dataclass(frozen=True)
class Decoding:
    """How codes were decoded into normals, and the source of each decision: a record for messages and reports.

    Reliefs, compositions and depth maps never depend on it.

    Attributes hold a value and, with the suffix ``_from``, its source: ``given`` (an option), ``preset`` (of the
    program that wrote the file), ``file`` (its metadata), ``found`` (detected in the picture) or ``assumed`` (the
    default).

    Attributes
    ----------
    curl_ratio : float or None
        Root mean square curl with green down over that with green up; None if nothing tells.
    preset, preset_from : str or None, str
        The program whose conventions were used.
    fits : tuple of str or None
        The orders that fit the map, as swizzles with green up, the most likely first; several if nothing tells them
        apart; None if this was not measured.
    outline_sign : float or None
        Mean of n . outward over the outline: near +1 for a raised motif, negative for an inverted one; None without an
        outline.
    notes : tuple of str
        What is unusual about the file, as in `nmaptool.RasterImage`.
    repeats : bool
        Whether opposite edges of the picture continue each other, as those of a tileable texture do.
    away_share : float
        Share of the motif that faces away from the viewer (nz <= 0).
    """

    green: str = "up"
    green_from: str = "assumed"
    curl_ratio: float | None = None
    swizzle: str = "r,g,b"
    swizzle_from: str = "assumed"
    preset: str | None = None
    preset_from: str = "assumed"
    fits: tuple[str, ...] | None = None
    outline_sign: float | None = None
    away_share: float = 0.0
    curve: str = "none"
    notes: tuple[str, ...] = ()
    repeats: bool = False
    zero_code: str = "127.5"
    zero_code_from: str = "assumed"
    encoding: str = "unsigned"
    components: str = "xyz"
    components_from: str = "assumed"
    background: str = "none"
    background_from: str = "found"
    rim_pixels: int = 0
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False, repr=False)
class NormalMap(Pictured):
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
        Pixels of the motif. Default: coverage of at least one half. It differs from that if the background is a
        defined, flat part of the map.
    name : str
        Name of the map for messages.
    decoding : Decoding
        How its file was read.
    flat_background : bool
        Whether the area outside the motif is a defined, flat part of the map, such as the plate behind raised letters.
        A relief then has no height term on flat patches inside the motif: only the slopes around them decide whether
        they are raised or sunken.

    Raises
    ------
    InputError
        If a shape or type is wrong, a value is not finite, a normal is not of unit length or coverage is outside [0,
        1].
    """

    normals: Float32
    coverage: Float32
    frame: Frame
    foreground: Mask = None  # type: ignore[assignment]
    name: str = "normal map"
    decoding: Decoding = field(default_factory=Decoding)
    flat_background: bool = False

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
            raise InputError(
                f"{self.name}: normals must be finite and of unit length; scale them with nmaptool.core.vectors.unit"
            )
        if not (self.coverage.min() >= 0 and self.coverage.max() <= 1):
            raise InputError(f"{self.name}: coverage must lie in [0, 1]")
        if self.foreground is None:
            object.__setattr__(self, "foreground", self.coverage >= 0.5)
        elif self.foreground.shape != shape or self.foreground.dtype != np.bool_:
            raise InputError(f"{self.name}: foreground must be bool of shape {shape}")
        for name in ("normals", "coverage", "foreground"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @classmethod
    def from_array(
        cls, normals: Any, mask: Any = None, pitch_mm: float | None = None, name: str = "normals"
    ) -> NormalMap:
        """Make a normal map from plain arrays.

        Parameters
        ----------
        normals : (H, W, 3) float of any type
            Vectors in eye space: x right, y up, z towards the viewer, row 0 at the top. They are scaled to unit
            length; float32 vectors already of unit length to rounding keep their bits.
        mask : (H, W) bool or float in [0, 1], optional
            Where normals are defined; becomes the coverage. Outside it (0), vectors may have any value and become flat.
        pitch_mm : float, optional
            Millimetres per pixel.
        name : str
            Name of the map for messages.

        Returns
        -------
        NormalMap

        Raises
        ------
        InputError
            If the array does not hold normals, the mask has another size or values outside [0, 1], or a vector inside
            the mask has zero length or is not finite.
        UsageError
            If a value is not an array of numbers.

        Examples
        --------
        >>> normals = np.zeros((4, 6, 3))
        >>> normals[:, :3] = 0, 3, 4
        >>> nm.NormalMap.from_array(normals, mask=normals[..., 2] > 0, pitch_mm=0.5)
        <NormalMap normals: 6 x 4 px, 0.5 mm per px, 50% covered>
        """
        unit, coverage = unit_normals(normals, None if mask is None else as_mask(mask, f"{name}: the mask"), name)
        rows, cols = coverage.shape
        return cls(unit, coverage, Frame(rows, cols, pitch_mm), name=name)

    def _line(self) -> str:
        return f"{self.name}: {self.frame.with_pitch}, {self.coverage.mean():.0%} covered"


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
        for_each_band(len(normals), max(1, _VECTORS_AT_ONCE // normals.shape[1]), look)
    return not any(off)
