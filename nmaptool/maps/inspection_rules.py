"""The findings about normal maps: each rule turns the measurements into a message and its remedy."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from nmaptool.maps.doubts import DOUBTS, NOT_NORMALS_SHARE
from nmaptool.maps.order_doubts import order_doubt

if TYPE_CHECKING:
    from nmaptool.types.inspection import Inspection

# a tilt of less than this over the longer side does not show
_VISIBLE_TILT_PX = 0.05

Told = tuple[str, str] | None
Rule = Callable[["Inspection"], Told]


def _when(holds: Callable[[Inspection], bool], message: str, remedy: str) -> Rule:
    """A rule with a fixed message."""
    return lambda f: (message, remedy) if holds(f) else None


def _no_foreground(f: Inspection) -> Told:
    if f.foreground_share > 0:
        return None
    return (
        f"every pixel is background ({f.decoding.background})",
        "if it is a surface, use `background_color='none'`",
    )


def _off_length(f: Inspection) -> Told:
    if not 0.02 <= f.off_length_share < NOT_NORMALS_SHARE:
        return None
    return (
        f"{f.off_length_share:.1%} of the vectors are more than 10 % off unit length",
        "they are normalised on reading; resizing, blurring or blending as colours in an image editor causes them",
    )


def _about_order(code: str) -> Rule:
    """The rule for one kind of doubt about the order of the channels."""

    def told(f: Inspection) -> Told:
        doubt = order_doubt(f.decoding)
        return (doubt.message, doubt.remedy) if doubt is not None and doubt.code == code else None

    return told


def _two_components(f: Inspection) -> Told:
    if f.decoding.components_from != "found":
        return None
    if f.decoding.preset == "dxt5nm":
        what = "x is in alpha and y in green (DXT5nm)"
    else:
        what = (
            f"holds x and y only: {'its blue is constant and cannot be z' if 'B' in f.channels else 'it has no blue'}"
        )
    remedy = "z is computed on reading; nmap compose convert writes all three components for programs that need them"
    return what, remedy


def _truncated_codes(f: Inspection) -> Told:
    if f.decoding.zero_code != "127" or f.neutral_bias_px is None or abs(f.neutral_bias_px) < _VISIBLE_TILT_PX:
        return None
    return (
        f"its codes were truncated, not rounded; with zero in the middle it tilts by {abs(f.neutral_bias_px):.1f} px",
        "code 127 is read as zero; export the map again with rounding, preferably in 16 bits",
    )


def _coarse_values(f: Inspection) -> Told:
    if not f.coarse:
        return None
    remedy = "smooth areas show its steps; export it with 8 or 16 bits per channel, uncompressed, as PNG or EXR"
    return "; ".join(f.decoding.notes), remedy


def _color_managed(f: Inspection) -> Told:
    if not f.color_chunks:
        return None
    return (
        f"contains colour-management data ({', '.join(f.color_chunks)}), as if it were a photograph",
        "it is ignored here, but editors may convert the values: export without a profile, as raw or non-colour data",
    )


RULES: dict[str, Rule] = {
    "no-foreground": _no_foreground,
    "off-length": _off_length,
    **{code: _about_order(code) for code in ("turned", "inverted", "green-down", "red-left", "green-wrong")},
    "two-components": _two_components,
    "truncated-codes": _truncated_codes,
    "eight-bit-data": _when(
        lambda f: f.eight_bit_data,
        "is a 16-bit file that holds 8-bit data: smooth areas will show steps",
        "export from the source in true 16 bits or as float EXR",
    ),
    "lossy-blocks": _when(
        lambda f: f.has_blocks,
        "shows the 8 x 8 blocks of lossy compression (JPEG), which roughen smooth areas",
        "export it from the source as PNG or EXR; converting the file does not restore it",
    ),
    "coarse-values": _coarse_values,
    "color-managed": _color_managed,
}
# codes of all findings
CODES = (*DOUBTS, *RULES)
