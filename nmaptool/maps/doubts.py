"""Doubts about a picture that was decoded as a normal map, each with its remedy."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.errors import InputError
from nmaptool.maps.background import Background, alpha_is_data
from nmaptool.maps.channels import Channels
from nmaptool.maps.conventions import better_remedy, better_swizzle
from nmaptool.maps.coverage import Covered
from nmaptool.maps.layouts import LENGTH_OFF, find_curve, is_premultiplied
from nmaptool.maps.orders import MOST_AWAY, SURE_CURL_RATIO
from nmaptool.options import ReadOptions
from nmaptool.types.inspection import Finding
from nmaptool.types.normal_map import Decoding, NormalMap
from nmaptool.types.picture import RasterImage

# codes of the findings
DOUBTS = (
    "orientation",
    "premultiplied",
    "background-missing",
    "alpha-ignored",
    "wrong-curve",
    "not-normals",
    "scaled",
    "facing-away",
)
# if this share of the vectors is not of unit length, the picture is not a normal map
NOT_NORMALS_SHARE = 0.5
# if more than this share faces away, the map was made for another order of axes
_REFUSED_AWAY = 0.5
_SAMPLE = 100_000
# the cause of odd lengths is looked for if this share is off
_LEAST_OFF = 0.1
# a map was scaled if the lengths in the middle half of its vectors differ by no more than this factor
_SIMILAR = 1.6
_SHORTEST, _LONGEST = 0.2, 1.8
# how each curve shows
_CURVES = {
    "srgb": "its codes look gamma-encoded (sRGB), as if it were a photograph",
    "linear": "its codes look linearised, as if a photograph had been decoded",
    "video": "its codes look squeezed to 16 to 235, as in video",
}


def find_doubts(
    image: RasterImage,
    channels: Channels,
    background: Background,
    covered: Covered,
    decoding: Decoding,
    options: ReadOptions,
) -> tuple[Finding, ...]:
    """What a user must know about a map before using it."""
    found = (
        *_orientation_doubts(image),
        *_alpha_doubts(image, channels),
        *_background_doubts(channels, background, options.background_color),
        *_length_doubts(channels, covered, options, decoding.curl_ratio),
    )
    return (*found, *facing_doubts(decoding.away_share, decoding, found))


def as_warning(found: Finding) -> str:
    """A finding on one line."""
    return f"{found.message}; {found.remedy}"


def _orientation_doubts(image: RasterImage) -> Iterator[Finding]:
    """A picture that viewers turn; turning does not turn its vectors."""
    if image.orientation != 1:
        yield Finding(
            "orientation",
            f"its EXIF orientation ({image.orientation}) is ignored, because turning the picture would not turn its "
            "vectors",
            "export it upright, or turn it with nmap compose transform, which turns the vectors, too",
        )


def _alpha_doubts(image: RasterImage, channels: Channels) -> Iterator[Finding]:
    """Colours that were multiplied by alpha."""
    if not channels.coding.signed and channels.components == "xyz" and is_premultiplied(image):
        yield Finding(
            "premultiplied",
            "its colours are multiplied by alpha (premultiplied), which bends the normals along the outline",
            "export with straight (unassociated) alpha",
        )


def _background_doubts(channels: Channels, background: Background, wanted: str) -> Iterator[Finding]:
    """Doubts about the background that was found."""
    if wanted not in ("auto", "none") and not background.mask.any():
        yield Finding(
            "background-missing",
            f"no background found that is {wanted}: every pixel is treated as surface",
            "leave `background_color` out, or give the colour of the background",
        )
    if background.warning is not None:
        message, _, remedy = background.warning.partition("; ")
        yield Finding("background-missing", message, remedy)
    if wanted == "auto" and alpha_is_data(channels.image):
        yield Finding(
            "alpha-ignored",
            "alpha looks like data (a height or gloss channel), not coverage; it is ignored",
            "if it is coverage, use `background_color='alpha'`",
        )


def _length_doubts(
    channels: Channels, covered: Covered, options: ReadOptions, curl_ratio: float | None
) -> Iterator[Finding]:
    """Vectors that are not of unit length, with the cause if it shows."""
    lengths = _lengths(covered.vectors, covered.background)
    share = float((np.abs(lengths - 1) > LENGTH_OFF).mean()) if len(lengths) else 0.0
    if share < _LEAST_OFF:
        return
    if _is_grey(channels):
        remedy = "turn it into normals: nmap compose depth"
        remedy += "; or, if x is in alpha, use `from_='dxt5nm'`" if alpha_is_data(channels.image) else ""
        yield Finding("not-normals", "is a grey picture: heights or depths, not normals", remedy)
        return
    if channels.components == "xyz" and options.curve == "none":
        curve = find_curve(channels.image, covered.background)
        if curve is not None:
            yield Finding(
                "wrong-curve",
                f"{_CURVES[curve]}: {share:.0%} of its vectors are not of unit length",
                f"read it with `curve={curve!r}`, or export it again as raw (non-colour) data",
            )
            return
    if share < NOT_NORMALS_SHARE:
        return
    low, middle, high = np.percentile(lengths, (25, 50, 75))
    is_surface = curl_ratio is not None and not 1 / SURE_CURL_RATIO <= curl_ratio <= SURE_CURL_RATIO
    if is_surface and _SHORTEST < middle < _LONGEST and high <= _SIMILAR * low:
        yield Finding(
            "scaled",
            f"its vectors are about {middle:.2g} long, not 1: the map looks blended or scaled as a picture",
            "they are normalised; where a map without that step exists, use it",
        )
        return
    yield Finding(
        "not-normals",
        f"does not look like a normal map: {share:.0%} of its vectors are not of unit length",
        "check that this is the normal map, not a colour, height or ambient-occlusion picture",
    )


def _is_grey(channels: Channels) -> bool:
    """Whether red, green and blue are equal everywhere."""
    x, y, z = (channels.xyz[..., axis] for axis in range(3))
    return channels.components == "xyz" and bool(np.array_equal(x, y) and np.array_equal(x, z))


def _lengths(vectors: Float32, outside: Mask) -> NDArray[Any]:
    """Lengths of a sample of the vectors not ``outside``."""
    inside = np.flatnonzero(~outside)
    sample = vectors.reshape(-1, 3)[inside[:: max(1, len(inside) // _SAMPLE)]].astype(np.float64)
    return np.asarray(np.linalg.norm(sample, axis=1))


def facing_doubts(
    share: float, decoding: Decoding, others: Iterable[Finding], most: float = MOST_AWAY
) -> Iterator[Finding]:
    """A motif of which more than ``most`` faces away, unless other doubts say that the picture holds no normals."""
    if share > most and _not_normals(others) is None:
        yield Finding("facing-away", _away(share), _facing_remedy(decoding))


def _facing_remedy(decoding: Decoding) -> str:
    """What to do with a map that faces away."""
    better = better_swizzle(decoding)
    if better is not None:
        return better_remedy(decoding, better)
    if decoding.fits == ():
        return (
            "no order of its channels faces the viewer, as in an object-space or world-space map; bake it again in "
            "tangent space or in the space of the camera"
        )
    return "their slopes are reduced to the slope cap; render the map again from the camera that sees the model"


def check_facing(normal_map: NormalMap, findings: Iterable[Finding], options: ReadOptions) -> None:
    """Refuse a map of which more than half faces away, unless forced.

    Parameters
    ----------
    normal_map : NormalMap
    findings : iterable of Finding
        The doubts about it. If it is another kind of picture, the error says that.
    options : ReadOptions

    Raises
    ------
    InputError
    """
    decoding = normal_map.decoding
    if options.force or decoding.away_share <= _REFUSED_AWAY:
        return
    other = _not_normals(findings)
    told = f"{_away(decoding.away_share)}; {_facing_remedy(decoding)}" if other is None else as_warning(other)
    raise InputError(f"{normal_map.name}: {told}, or go on with `force`")


def _not_normals(findings: Iterable[Finding]) -> Finding | None:
    return next((found for found in findings if found.code == "not-normals"), None)


def _away(share: float) -> str:
    shown = f"{share:.0%}" if share > MOST_AWAY else f"{share:.1%}"
    return f"{shown} of the motif faces away from the viewer (nz <= 0)"
