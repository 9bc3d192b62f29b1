"""Read windows of a large normal map: the decisions are made once, from a sample, and hold for every window."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.errors import InputError, UsageError
from nmaptool.maps.background import span_of
from nmaptool.maps.decoding import Decoded, decode_as_stored
from nmaptool.maps.doubts import as_warning, check_facing
from nmaptool.maps.layouts import arranged
from nmaptool.maps.orders import OrderEvidence, find_evidence
from nmaptool.maps.two_channel import blue_varies
from nmaptool.maps.zero_code import ZERO_CODES
from nmaptool.options import ReadOptions
from nmaptool.options.fields import option
from nmaptool.types.inspection import Finding
from nmaptool.types.normal_map import Decoding
from nmaptool.types.picture import RasterImage

# the largest value of codes of 8 bits in floats
_IN_FLOATS = 255
# squared change of a vector within a pixel, beyond which more does not count
_LARGEST_CHANGE = 0.25
Windows = Sequence[tuple[slice, slice]]
_FLAT = Finding(
    "background-missing",
    "its edges look like a flat background, which is read as surface, because a large map is read by windows",
    "give a mask of the motif, or use `background_color='none'` if the flat area belongs to the surface",
)


@dataclass(frozen=True)
class SettledReading(ReadOptions):
    """Options for reading a large map with all decisions made, so that every window is read alike.

    Parameters
    ----------
    narrowed_by:
        16-bit codes are 8-bit codes times this, 257 or 256, or floats are 8-bit codes divided by 255; 0 if neither.
    lowest:
        The stored value of -1 by which colours of a background are recognised: -1 or 0.
    keeps_grey:
        Whether the grey background of a map of two components is recognised by its own blue.
    """

    narrowed_by: int = option(0)
    lowest: float = option(0.0)
    keeps_grey: bool = option(False)


def settle(sample: RasterImage, windows: Windows, options: ReadOptions) -> tuple[SettledReading, Decoding]:
    """Decide how to read a large map.

    Parameters
    ----------
    sample : RasterImage
        Windows of the map, joined. Those at its edges lie at the edges of the map.
    windows : sequence of (slice, slice)
        The places of the windows in the sample.
    options : ReadOptions
        As given by the user.

    Returns
    -------
    options : SettledReading
    decoding : Decoding
        What was decided, with doubts about the map.

    Raises
    ------
    InputError, UsageError
        As `nmaptool.decode_normal_map`; also for the background "flat", which only the whole picture shows.
    """
    if options.background_color == "flat":
        raise UsageError(
            f"{sample.name}: `background_color='flat'`: needs the whole picture, but a large map is read by windows; "
            "give a mask of the motif, or the colour of the background"
        )

    def look(normals: Float32, foreground: Mask, defined: Mask, step: float) -> OrderEvidence:
        return _evidence(normals, foreground, defined, step, windows)

    decoded = decode_as_stored(sample, options, look)
    findings = decoded.findings
    if decoded.background.kind == "flat":
        decoded = decode_as_stored(sample, replace(options, background_color="none"), look)
        findings = (*decoded.findings, _FLAT)
    wanted = options.background_color
    if wanted not in ("auto", "none"):
        told = [found for found in findings if found.code != "background-missing"]
        findings = (*told, *_missing(wanted)) if not decoded.background.mask.any() else findings
    check_facing(decoded.normal_map, findings, options)
    decoding = replace(
        decoded.normal_map.decoding,
        background_from="found" if options.background_color == "auto" else "given",
        warnings=tuple(as_warning(found) for found in findings),
    )
    return _settled(sample, decoded, decoding, options), decoding


def _settled(sample: RasterImage, decoded: Decoded, decoding: Decoding, options: ReadOptions) -> SettledReading:
    channels = decoded.channels
    zero_code: Any = decoding.zero_code if decoding.zero_code in ZERO_CODES else "127.5"
    wanted = options.background_color
    as_read, _ = arranged(sample, channels.asked, channels.components)
    given = {field.name: getattr(options, field.name) for field in fields(ReadOptions)}
    settled: dict[str, Any] = {
        "from_": "auto",
        "green": decoding.green,
        "swizzle": decoding.swizzle,
        "zero_code": zero_code,
        "encoding": decoding.encoding,
        "components": decoding.components,
        "background_color": decoding.background if wanted == "auto" else wanted,
    }
    return SettledReading(
        **{**given, **settled},
        narrowed_by=_narrowed_by(sample, channels.image) if options.curve == "none" else 0,
        lowest=span_of(channels.image, channels.xyz).low,
        keeps_grey=decoding.components != "xyz" and blue_varies(as_read, channels.order),
    )


def _missing(wanted: str) -> Iterator[Finding]:
    yield Finding(
        "background-missing",
        f"no background that is {wanted} shows in the windows that were looked at",
        "check its colour; if there is none, use `background_color='none'`",
    )


def _narrowed_by(image: RasterImage, narrow: RasterImage) -> int:
    """What makes the stored values of the narrow picture."""
    if narrow.pixels.dtype == image.pixels.dtype:
        return 0
    if image.is_float:
        return _IN_FLOATS
    return 257 if not (image.pixels % 257).any() else 256


def narrowed_as_settled(image: RasterImage, settled: SettledReading) -> RasterImage:
    """Return the picture as the 8-bit codes that the sample of the map holds; unchanged if it holds others.

    Raises
    ------
    InputError
        If the window holds other values.
    """
    factor = settled.narrowed_by
    if not factor:
        return image
    codes = image.pixels * np.float32(factor) if image.is_float else image.pixels // factor
    whole: NDArray[Any] = np.rint(codes).clip(0, 255) if image.is_float else codes
    tolerance = 2e-3 if image.bits == 32 else 0.07
    bad = ~(np.abs(codes - whole) < tolerance) if image.is_float else image.pixels % factor != 0
    if image.alpha is not None and image.is_float:
        bad &= (image.alpha > 0)[..., None]
    if bad.any():
        how = "floats" if image.is_float else "16 bits"
        raise InputError(
            f"{image.name}: holds 8-bit codes in {how} in some places and finer values in others; save all of it in "
            "one way"
        )
    return replace(image, pixels=np.nan_to_num(whole).astype(np.uint8))


def _evidence(normals: Float32, foreground: Mask, defined: Mask, step: float, windows: Windows) -> OrderEvidence:
    """What the windows tell together, each on its own, so that the seams between them do not count."""
    if len(windows) == 1:
        return find_evidence(normals, foreground, defined, step)
    seen, weights = [], []
    for window in windows:
        part, motif = normals[window], np.ascontiguousarray(foreground[window])
        if motif.any():
            seen.append(find_evidence(part, motif, np.ascontiguousarray(defined[window]), step))
            change = np.square(np.diff(part, axis=1)).sum(axis=2)[motif[:, 1:] & motif[:, :-1]]
            weights.append(float(np.minimum(change, _LARGEST_CHANGE).sum(dtype=np.float64)) + 1e-12)
    if not seen:
        return find_evidence(normals[windows[0]], foreground[windows[0]], defined[windows[0]], step)
    telling = [(one.curl2, weight) for one, weight in zip(seen, weights, strict=True) if one.curl2]
    total = sum(weight for _, weight in telling)
    outlines = [one.outline for one in seen if one.outline is not None]
    return OrderEvidence(
        curl2={axes: sum(curl2[axes] * weight for curl2, weight in telling) / total for axes in telling[0][0]}
        if telling
        else {},
        outline=np.mean(outlines, axis=0) if outlines else None,
        away=np.mean([one.away for one in seen], axis=0),
        mean=np.mean([one.mean for one in seen], axis=0),
    )
