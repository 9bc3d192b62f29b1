"""The findings about normal maps: each rule turns the measurements into a message and its remedy."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from nmaptool.maps.conventions import SURE_CURL_RATIO, is_inverted, upright_swizzle
from nmaptool.maps.decoding import NOT_NORMALS_SHARE

if TYPE_CHECKING:
    from nmaptool.types.inspection import Inspection

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


def _not_normals(f: Inspection) -> Told:
    if f.off_length_share < NOT_NORMALS_SHARE:
        return None
    return (
        f"does not look like a normal map: {f.off_length_share:.0%} of its vectors are not of unit length",
        "check that this is the normal map, not a colour, height or ambient-occlusion picture",
    )


def _off_length(f: Inspection) -> Told:
    if not 0.02 <= f.off_length_share < NOT_NORMALS_SHARE:
        return None
    return (
        f"{f.off_length_share:.1%} of the vectors are more than 10 % off unit length",
        "they are normalised on reading; resizing, blurring or blending as colours in an image editor causes them",
    )


def _facing_away(f: Inspection) -> Told:
    if f.away_share < 0.002:
        return None
    return (
        f"{f.away_share:.1%} of the foreground faces away from the viewer (nz <= 0)",
        "their slopes are reduced to the slope cap; render the map again from the camera that sees the model",
    )


def _turned(f: Inspection) -> Told:
    if f.better_swizzle is None:
        return None
    return (
        "its channels look rotated or mirrored: another order has far less curl",
        f"read it with `swizzle={f.better_swizzle!r}`",
    )


def _inverted(f: Inspection) -> Told:
    if f.better_swizzle is not None or not is_inverted(f.outline_sign):
        return None
    return (
        "looks inverted: the normals along the outline point inwards, which turns bumps into dents",
        f"for an engraving use `delta=-30`; for a raised motif read it with `swizzle={upright_swizzle(f.decoding)!r}`",
    )


def _green_down(f: Inspection) -> Told:
    d = f.decoding
    if f.better_swizzle is not None or d.green != "down" or d.green_from != "found":
        return None
    ratio = 1 / d.curl_ratio if d.curl_ratio else float("inf")
    return (
        f"green points down (DirectX): green up would have {ratio:.1f} times the curl",
        "it is read with green down; to be certain, set `green='up'` or `green='down'`",
    )


def _green_wrong(f: Inspection) -> Told:
    d = f.decoding
    if f.better_swizzle is not None or d.green_from not in ("given", "file") or d.curl_ratio is None:
        return None
    against = d.curl_ratio < 1 / SURE_CURL_RATIO if d.green == "up" else d.curl_ratio > SURE_CURL_RATIO
    if not against:
        return None
    other = "down" if d.green == "up" else "up"
    return (f"green is given as {d.green}, but {other} has far less curl", f"try `green={other!r}`")


def _two_components(f: Inspection) -> Told:
    if f.decoding.components_from != "found":
        return None
    what = "its blue is constant and cannot be z" if "B" in f.channels else "it has no blue"
    return (
        f"holds x and y only: {what}",
        "z is computed on reading; nmap compose convert writes all three components for programs that need them",
    )


def _truncated_codes(f: Inspection) -> Told:
    if f.decoding.zero_code != "127" or f.neutral_bias_px is None:
        return None
    return (
        f"its codes were truncated, not rounded; with zero in the middle it tilts by {abs(f.neutral_bias_px):.1f} px",
        "code 127 is read as zero; export the map again with rounding, preferably in 16 bits",
    )


def _color_managed(f: Inspection) -> Told:
    if not f.color_chunks:
        return None
    return (
        f"contains colour-management data ({', '.join(f.color_chunks)}), as if it were a photograph",
        "it is ignored here, but editors may convert the values: export without a profile, as raw or non-colour data",
    )


def _alpha_ignored(f: Inspection) -> Told:
    for warning in f.decoding.warnings:
        if warning.startswith("alpha"):
            return (warning, "if it is coverage, use `background_color='alpha'`")
    return None


def _background_missing(f: Inspection) -> Told:
    for warning in f.decoding.warnings:
        if warning.startswith("no background"):
            return (warning, "leave `background_color` out, or give the colour of the background")
        if "if that is the background" in warning:
            return (warning.partition(";")[0], warning.partition("; ")[2])
    return None


RULES: dict[str, Rule] = {
    "no-foreground": _no_foreground,
    "not-normals": _not_normals,
    "off-length": _off_length,
    "facing-away": _facing_away,
    "turned": _turned,
    "inverted": _inverted,
    "green-down": _green_down,
    "green-wrong": _green_wrong,
    "two-components": _two_components,
    "truncated-codes": _truncated_codes,
    "premultiplied": _when(
        lambda f: f.premultiplied,
        "its colours are multiplied by alpha (premultiplied), which bends the normals along the outline",
        "export with straight (unassociated) alpha",
    ),
    "eight-bit-data": _when(
        lambda f: f.eight_bit_data,
        "is a 16-bit file that holds 8-bit data: smooth areas will show steps",
        "export from the source in true 16 bits or as float EXR",
    ),
    "color-managed": _color_managed,
    "alpha-ignored": _alpha_ignored,
    "background-missing": _background_missing,
}
