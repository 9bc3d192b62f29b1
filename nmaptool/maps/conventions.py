"""Decide how the channels of a map point, and compare that with the orders that fit."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from nmaptool.maps.codec import Swizzle, format_swizzle, parse_swizzle
from nmaptool.maps.orders import AS_READ, SURE_CURL_RATIO, SURE_OUTLINE, Order, OrderEvidence, find_evidence
from nmaptool.options import ReadOptions
from nmaptool.types.normal_map import Decoding, NormalMap
from nmaptool.types.picture import RasterImage

GREEN_DOWN: Order = ((0, 1), (1, -1), (2, 1))
_RED_LEFT: Order = ((0, -1), (1, 1), (2, 1))
# where curl is silent, only an outline as clear as this decides the sign of green
_CLEAR_OUTLINE = 0.5
# with more orders than this, nothing is known
MOST_FITS = 2


class Directions(NamedTuple):
    """Where red and green point, and the sources of these decisions.

    Attributes
    ----------
    green, green_from : str
        As in `Decoding`.
    red_left : bool
        Whether red was found to point left, although no swizzle says so.
    """

    green: str
    green_from: str
    red_left: bool = False


def find_directions(
    image: RasterImage, given: ReadOptions, options: ReadOptions, seen: OrderEvidence, background: str
) -> Directions:
    """Decide where red and green point.

    Parameters
    ----------
    image : RasterImage
    given, options : ReadOptions
        As given, and with the values of a preset.
    seen : OrderEvidence
        Of the map read with the swizzle and green up.
    background : str
        Its kind.
    """
    stated = image.attributes.get("green")
    if given.green != "auto":
        return Directions(given.green, "given")
    if stated in ("up", "down"):
        return Directions(stated, "file")
    if options.green != "auto":
        return Directions(options.green, "preset")
    if given.swizzle is not None:  # a swizzle already sets the sign of y
        return Directions("up", "given")
    fits = seen.fitting()
    if fits and fits[0][2] != AS_READ[2]:  # the axes are others, so green is not y
        return Directions("up", "assumed")
    ratio = seen.curl_ratio(GREEN_DOWN, AS_READ)
    if ratio is not None and ratio < 1 / SURE_CURL_RATIO:
        # the curl of red left is that of green down; only an outline tells them apart: a motif that was cut out is
        # raised, but what stands on flat ground may be sunken, such as letters, panels and dents of DirectX textures
        red_left = fits == (_RED_LEFT,) and background != "flat"
        return Directions("up" if red_left else "down", "found", red_left)
    if ratio is not None and ratio > SURE_CURL_RATIO:
        return Directions("up", "found")
    down, up = (seen.outline_sign(order) or 0.0 for order in (GREEN_DOWN, AS_READ))
    if fits == (GREEN_DOWN,) and down >= _CLEAR_OUTLINE and up < down - _CLEAR_OUTLINE:
        return Directions("down", "found")
    return Directions("up", "assumed")


def fitting_swizzles(seen: OrderEvidence, swizzle: Swizzle, *, z_known: bool) -> tuple[str, ...]:
    """The orders that fit, as swizzles of the file with green up.

    Parameters
    ----------
    seen : OrderEvidence
        Of the map read with the swizzle and green up.
    swizzle : tuple of (channel, sign)
    z_known : bool
        Whether z was computed from x and y.
    """
    found = seen.fitting(z_known=z_known)
    return tuple(
        format_swizzle(tuple((swizzle[axis][0], sign * swizzle[axis][1]) for axis, sign in order)) for order in found
    )


def with_signs(swizzle: Swizzle, x: int = 1, y: int = 1) -> Swizzle:
    """The swizzle with x and y multiplied by these signs."""
    (red, red_sign), (green, green_sign), z = swizzle
    return (red, x * red_sign), (green, y * green_sign), z


def swizzle_in_use(decoding: Decoding) -> Swizzle:
    """The swizzle of a map with its green folded in: green down negates y.

    >>> format_swizzle(swizzle_in_use(Decoding(swizzle="-r,g,b", green="down")))
    '-r,-g,b'
    """
    return with_signs(parse_swizzle(decoding.swizzle), y=-1 if decoding.green == "down" else 1)


def to_type(decoding: Decoding, swizzle: str) -> str:
    """The swizzle that reads the file in this order if green stays as the user gave it."""
    keeps_down = decoding.green == "down" and decoding.green_from == "given"
    return format_swizzle(with_signs(parse_swizzle(swizzle), y=-1 if keeps_down else 1))


def upright_swizzle(decoding: Decoding) -> str:
    """The swizzle that makes an inverted relief a raised one: x and y change sign.

    If green was detected as down, y keeps its sign: giving a swizzle switches that detection off.

    >>> upright_swizzle(Decoding(swizzle="-g,r,b"))
    'g,-r,b'
    """
    return to_type(decoding, format_swizzle(with_signs(swizzle_in_use(decoding), -1, -1)))


def is_inverted(sign: float | None) -> bool:
    """Whether an outline sign means that the motif is sunken instead of raised."""
    return sign is not None and sign <= -SURE_OUTLINE


def better_swizzle(decoding: Decoding) -> str | None:
    """The order that fits the map if that in use does not, as the swizzle to give; None if there is none."""
    fits = decoding.fits or ()
    if not fits or format_swizzle(swizzle_in_use(decoding)) in fits:
        return None
    return to_type(decoding, fits[0])


def better_remedy(decoding: Decoding, better: str) -> str:
    """How to read a map with an order that fits better, and with its inside-out if that fits as well."""
    opposite = format_swizzle(with_signs(parse_swizzle(better), -1, -1))
    if len(decoding.fits or ()) < MOST_FITS:
        return f"read it with `swizzle={better!r}`"
    return f"read it with `swizzle={better!r}` or, if it then comes out inside out, `swizzle={opposite!r}`"


def inside_out_swizzle(decoding: Decoding) -> str | None:
    """The order that fits as well as that in use and gives its inside-out; None if the outline tells them apart."""
    fits, own = decoding.fits or (), swizzle_in_use(decoding)
    other = format_swizzle(with_signs(own, -1, -1))
    if len(fits) != MOST_FITS or format_swizzle(own) not in fits or other not in fits:
        return None
    return to_type(decoding, other)


def green_is_wrong(decoding: Decoding) -> bool:
    """Whether green is given, but only the other direction fits."""
    fits = decoding.fits or ()
    other = format_swizzle(with_signs(swizzle_in_use(decoding), y=-1))
    return decoding.green_from in ("given", "file", "preset") and better_swizzle(decoding) is not None and other in fits


def with_evidence(normal_map: NormalMap) -> Decoding:
    """The decoding of a map with the orders that fit it, measured if they are not known."""
    decoding = normal_map.decoding
    if decoding.fits is not None:
        return decoding
    seen = find_evidence(normal_map.normals, normal_map.foreground, normal_map.coverage >= 0.5)
    fits = fitting_swizzles(seen, swizzle_in_use(decoding), z_known=decoding.components != "xyz")
    return replace(decoding, fits=fits, outline_sign=seen.outline_sign(AS_READ))
