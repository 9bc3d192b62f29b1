"""Decode a raw picture into a normal map: find channels, signs, zero code and background; record the decisions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.vectors import FLAT, unit
from nmaptool.maps.background import Background, alpha_is_data, find_background
from nmaptool.maps.channels import Channels, code_step, find_channels
from nmaptool.maps.codec import apply_signs, decode_map, format_swizzle, signs_of
from nmaptool.maps.conventions import SURE_CURL_RATIO, green_evidence
from nmaptool.maps.coverage import Covered, cover
from nmaptool.maps.two_channel import completed
from nmaptool.options import ReadOptions
from nmaptool.types.inputs import RasterLike, as_raster
from nmaptool.types.normal_map import Decoding, NormalMap
from nmaptool.types.picture import RasterImage
from nmaptool.types.shown import OneLine

LENGTH_OFF = 0.1
# if this share of the vectors is not of unit length, the picture is not a normal map
NOT_NORMALS_SHARE = 0.5
_SAMPLE = 100_000


@dataclass(frozen=True, eq=False, repr=False)
class Decoded(OneLine):
    """A picture decoded as a normal map, with intermediate results.

    Attributes
    ----------
    stored : (H, W, 3) float32
        The vectors as the file stores them, in eye space: the signs of the swizzle and of green are applied, lengths
        and the rim are unchanged. For maps of two components, the third is computed.
    background : Background
        The background that was found.
    normal_map : NormalMap
    channels : Channels
        The stored values, and how they encode vectors.
    """

    stored: Float32
    background: Background
    normal_map: NormalMap
    channels: Channels

    def _line(self) -> str:
        return f"{self.normal_map.name}: {self.normal_map.frame.with_pitch}, background {self.background.kind}"


def decode_image(image: RasterLike, options: ReadOptions | None = None) -> Decoded:
    """Decode a raw picture into a normal map, and keep the vectors as stored.

    Parameters
    ----------
    image : RasterImage, or (H, W, 2 to 4) uint8, uint16 or float
        As for `decode_normal_map`.
    options : ReadOptions, optional
        As for `decode_normal_map`.

    Returns
    -------
    Decoded
        Takes 12 bytes per pixel more than its normal map; use `decode_normal_map` if you only need the map.

    Raises
    ------
    InputError, UsageError
        As `decode_normal_map`.

    Examples
    --------
    >>> codes = np.full((2, 2, 3), (128, 128, 200), np.uint8)
    >>> decoded = nm.decode_image(codes, nm.ReadOptions(background_color="none"))
    >>> short, unit = decoded.stored[0, 0], decoded.normal_map.normals[0, 0]
    >>> f"{np.linalg.norm(short):.2f} {np.linalg.norm(unit):.2f}"
    '0.57 1.00'
    """
    decoded = _decode(as_raster(image), options or ReadOptions())
    signs = signs_of(decoded.channels.swizzle, decoded.normal_map.decoding.green)
    apply_signs(decoded.stored, signs, out=decoded.stored)
    return decoded


def decode_normal_map(image: RasterLike, options: ReadOptions | None = None) -> NormalMap:
    """Decode a raw picture into unit normals in eye space.

    Parameters
    ----------
    image : RasterImage, or (H, W, 2 to 4) uint8, uint16 or float
        Channels R, G, B(, A), or two channels with x and y or octahedral codes.
    options : ReadOptions, optional
        Green, zero code, components, background; what is not given is detected.

    Returns
    -------
    NormalMap
        Its ``decoding`` records the decisions and their sources.

    Raises
    ------
    InputError
        If the picture has too few channels, or NaN or infinity where it is defined.
    UsageError
        If the swizzle is not possible, or the picture is neither a RasterImage nor an array.

    Examples
    --------
    >>> codes = np.full((2, 2, 3), (128, 128, 255), np.uint8)
    >>> nm.decode_normal_map(codes, nm.ReadOptions(background_color="none")).normals[0, 0].tolist()
    [0.0, 0.0, 1.0]
    """
    return _decode(as_raster(image), options or ReadOptions()).normal_map


def _decode(image: RasterImage, options: ReadOptions) -> Decoded:
    """Decode a picture; its stored vectors still have the signs of the file."""
    channels = find_channels(image, options)
    vectors, mixed = _vectors_of(channels)
    wanted = options.background_color
    background = find_background(channels.image, channels.xyz, wanted, channels.order, mixed.shape[2])
    covered = cover(vectors, mixed, channels, background)
    warnings = (
        *_background_warnings(channels, background, wanted),
        *_length_warnings(covered.vectors, covered.background),
    )
    return Decoded(
        vectors, background, _normal_map(image, options, channels, covered, background.kind, warnings), channels
    )


def _vectors_of(channels: Channels) -> tuple[Float32, Float32]:
    """Vectors as stored, with the signs of the file, and the two or three stored components that they come from."""
    vectors = decode_map(channels.xyz, channels.coding)
    if channels.components == "xyz":
        return vectors, vectors
    pair = vectors[..., :2]
    return completed(pair, channels.components), pair


def _normal_map(
    image: RasterImage,
    options: ReadOptions,
    channels: Channels,
    covered: Covered,
    background: str,
    warnings: tuple[str, ...],
) -> NormalMap:
    """Normalise the vectors, convert them to eye space, and record all decisions."""
    normals = unit(covered.vectors)
    swizzle_signs = signs_of(channels.swizzle)
    if -1 in swizzle_signs:
        apply_signs(normals, swizzle_signs, out=normals)
    normals[covered.coverage <= 0] = FLAT
    foreground = (covered.coverage >= 0.5) & ~covered.background
    curl_ratio = green_evidence(normals, foreground, code_step(channels.image))
    green, green_from = _find_green(image, options, curl_ratio)
    if green == "down":
        apply_signs(normals, signs_of(green=green), out=normals)
    decoding = Decoding(
        green=green,
        green_from=green_from,
        curl_ratio=curl_ratio,
        swizzle=format_swizzle(channels.swizzle),
        zero_code=channels.zero_code,
        zero_code_from=channels.zero_code_from,
        encoding=channels.encoding,
        components=channels.components,
        components_from=channels.components_from,
        background=background,
        background_from="found" if options.background_color == "auto" else "given",
        rim_pixels=covered.rim_pixels,
        warnings=warnings,
    )
    flat_background = background == "flat"
    return NormalMap(normals, covered.coverage, image.frame, foreground, image.name, decoding, flat_background)


def _background_warnings(channels: Channels, background: Background, wanted: str) -> tuple[str, ...]:
    """Doubts about the background that was found."""
    warnings: list[str] = []
    if wanted not in ("auto", "none") and not background.mask.any():
        warnings.append(f"no background found that is {wanted}: every pixel is treated as surface")
    if background.warning is not None:
        warnings.append(background.warning)
    if wanted == "auto" and alpha_is_data(channels.image):
        warnings.append("alpha looks like data (a height or gloss channel), not coverage; it is ignored")
    return tuple(warnings)


def _length_warnings(vectors: Float32, background: Mask) -> tuple[str, ...]:
    share = off_length_share(vectors, background)
    if share < NOT_NORMALS_SHARE:
        return ()
    return (f"does not look like a normal map: {share:.0%} of its vectors are not of unit length",)


def _find_green(image: RasterImage, options: ReadOptions, curl_ratio: float | None) -> tuple[str, str]:
    """The direction of green, and its source."""
    stated = image.attributes.get("green")
    if options.green != "auto":
        return options.green, "given"
    if stated in ("up", "down"):
        return stated, "file"
    if options.swizzle is not None:  # a swizzle already sets the sign of y
        return "up", "given"
    if curl_ratio is not None and curl_ratio < 1 / SURE_CURL_RATIO:
        return "down", "found"
    if curl_ratio is not None and curl_ratio > SURE_CURL_RATIO:
        return "up", "found"
    return "up", "assumed"


def off_length_share(vectors: Float32, outside: Mask) -> float:
    """Share of (H, W, 3) stored vectors not ``outside`` whose length is more than 0.1 off 1, found from a sample."""
    inside = np.flatnonzero(~outside)
    sample = vectors.reshape(-1, 3)[inside[:: max(1, len(inside) // _SAMPLE)]].astype(np.float64)
    return float((np.abs(np.linalg.norm(sample, axis=1) - 1) > LENGTH_OFF).mean()) if len(sample) else 0.0
