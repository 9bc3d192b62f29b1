"""Options for cropping, mirroring, resizing, rotating and padding a map."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from nmaptool.core.errors import UsageError
from nmaptool.core.units import Length, Offset
from nmaptool.options.fields import Options, choice_of, option
from nmaptool.options.kinds import Number, SignedText, Switch, parse_size
from nmaptool.options.length_kinds import LengthText, ScaleText, parse_distances, parse_scale

NewGround = Literal["auto", "clear", "flat"]
ROTATION = Number("30", -3600, 3600)
HEIGHT_FACTOR = Number("1", -1e3, 1e3)
_LARGEST_NUMBER = 1e6
# smallest accepted determinant over the square of the largest entry
_SINGULAR = 1e-6


@dataclass(frozen=True)
class TransformOptions(Options, group="Transform"):
    """Edits of a map, applied in this order.

    Parameters
    ----------
    crop:
        Part to keep: across,down,width,height from the top left corner, such as 10%,10%,80%,50% or 0,0,40mm,30mm.
    flip_h:
        Mirror left to right.
    flip_v:
        Mirror top to bottom.
    resize:
        New size, columns x rows in pixels, such as 2000x1800. The width in mm and the slopes stay the same. If the
        picture is stretched, heights and the pixel size stay the same and the slopes change.
    scale:
        One scale factor, two (across,down), or a new width, such as 30mm. The pixel size stays the same.
    rotate:
        Rotate counter-clockwise by this many degrees. Quarter turns move pixels without resampling.
    affine:
        Apply any other linear map a,b,c,d: a point x,y (y points down) moves to ax + by, cx + dy.
    keep_size:
        Keep the picture's size and centre when it is rotated, instead of making room for the corners.
    pad:
        Add a border: one width for all sides, or left,top,right,bottom.
    height_factor:
        Multiply heights in px by this factor. Default: the scale, which keeps slopes; 1 if the picture is stretched or
        sheared.
    vectors_only:
        Rotate or mirror the vectors but leave the pixels in place. Repairs a map that was mirrored or rotated in an
        image editor.
    ground:
        What fills new corners and borders: "clear" (transparent), "flat", or "auto" (flat if the map has a flat
        background, otherwise clear).
    width:
        Width of the whole picture before the edit, such as 100mm, so that lengths can be given in mm. Default: the
        width stored in the file.
    """

    crop: str | None = option(None, SignedText("10%,10%,80%,50%"))
    flip_h: bool = option(False, Switch())
    flip_v: bool = option(False, Switch())
    resize: str | None = option(None, SignedText("2000x1800"))
    scale: str = option("1", ScaleText())
    rotate: float = option(0.0, ROTATION)
    affine: str | None = option(None, SignedText("1,0.2,0,1"))
    keep_size: bool = option(False, Switch())
    pad: str | None = option(None, SignedText("20px"))
    height_factor: float | None = option(None, HEIGHT_FACTOR)
    vectors_only: bool = option(False, Switch())
    ground: NewGround = option("auto", choice_of(NewGround))
    width: Length | None = option(None, LengthText("100mm", absolute=True))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.resize is not None and self.scale != "1":
            raise UsageError("`resize` and `scale` both set the size of the result; give one of them")
        if self.vectors_only and (self.crop or self.resize or self.pad):
            raise UsageError("`vectors_only` does not move pixels; crop, resize and pad in a separate run")
        _ = self.factors, self.window, self.borders, self.new_size, self.matrix

    @property
    def factors(self) -> tuple[float, float] | Length:
        """Scale across and down, or the new width."""
        return parse_scale(self.scale)

    @property
    def new_size(self) -> tuple[int, int] | None:
        """Columns and rows to resize to."""
        return None if self.resize is None else parse_size("resize", self.resize)

    @property
    def window(self) -> tuple[Offset, Offset, Offset, Offset] | None:
        """Left, top, width and height to keep."""
        if self.crop is None:
            return None
        left, top, across, down = parse_distances("crop", self.crop, (4,), "10%,10%,80%,50%")
        if min(across.value, down.value) <= 0:
            raise UsageError(f"`crop={self.crop!r}`: width and height must be greater than zero")
        return left, top, across, down

    @property
    def borders(self) -> tuple[Offset, ...]:
        """Left, top, right and bottom borders."""
        if self.pad is None:
            return (Offset(0.0, "px"),) * 4
        given = parse_distances("pad", self.pad, (1, 4), "20px or 10px,20px,10px,20px")
        if min(border.value for border in given) < 0:
            raise UsageError(f"`pad={self.pad!r}`: must be zero or more; cut with `crop`")
        return given if len(given) == 4 else given * 4

    @property
    def matrix(self) -> tuple[float, float, float, float]:
        """``affine`` as numbers; the identity if it is not given."""
        if self.affine is None:
            return (1.0, 0.0, 0.0, 1.0)
        try:
            a, b, c, d = (float(part) for part in self.affine.split(","))
        except ValueError:
            raise UsageError(f"`affine={self.affine!r}`: expected four numbers a,b,c,d, such as 1,0.2,0,1") from None
        largest = max(abs(n) for n in (a, b, c, d))
        if not all(math.isfinite(n) for n in (a, b, c, d)) or largest > _LARGEST_NUMBER:
            raise UsageError(f"`affine={self.affine!r}`: must be numbers of at most {_LARGEST_NUMBER:g}")
        if abs(a * d - b * c) <= _SINGULAR * largest * largest:
            raise UsageError(
                f"`affine={self.affine!r}`: is singular: it flattens the picture to a line; a*d - b*c must not be 0"
            )
        return a, b, c, d
