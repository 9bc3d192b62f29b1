"""Decode a raw picture into a normal map: find channels, signs, zero code and background; record the decisions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.vectors import make_flat, unit
from nmaptool.maps.background import Background, find_background
from nmaptool.maps.channels import Channels, find_channels
from nmaptool.maps.codec import apply_signs, decode_map, format_swizzle, parse_swizzle, signs_of
from nmaptool.maps.conventions import GREEN_DOWN, find_directions, fitting_swizzles, with_signs
from nmaptool.maps.coverage import Covered, cover
from nmaptool.maps.doubts import as_warning, check_facing, find_doubts
from nmaptool.maps.layouts import Layout, settle_layout
from nmaptool.maps.orders import AS_READ, OrderEvidence, find_evidence, repeats
from nmaptool.maps.two_channel import completed
from nmaptool.options import ReadOptions
from nmaptool.types.inputs import RasterLike, as_raster
from nmaptool.types.inspection import Finding
from nmaptool.types.normal_map import Decoding, NormalMap
from nmaptool.types.picture import RasterImage
from nmaptool.types.shown import OneLine

Look: TypeAlias = Callable[[Float32, Mask, Mask, float], OrderEvidence]


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
    findings : tuple of Finding
        Doubts about the map; its decoding has the same as warnings.
    """

    stored: Float32
    background: Background
    normal_map: NormalMap
    channels: Channels
    findings: tuple[Finding, ...] = ()

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
    decoded = decode_as_stored(as_raster(image), options or ReadOptions())
    decoding = decoded.normal_map.decoding
    signs = signs_of(parse_swizzle(decoding.swizzle), decoding.green)
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
        If the picture has too few channels, or NaN or infinity where it is defined, or most of it faces away from the
        viewer and ``force`` is not set.
    UsageError
        If the swizzle is not possible, or the picture is neither a RasterImage nor an array.

    Examples
    --------
    >>> codes = np.full((2, 2, 3), (128, 128, 255), np.uint8)
    >>> nm.decode_normal_map(codes, nm.ReadOptions(background_color="none")).normals[0, 0].tolist()
    [0.0, 0.0, 1.0]
    """
    options = options or ReadOptions()
    decoded = decode_as_stored(as_raster(image), options)
    check_facing(decoded.normal_map, decoded.findings, options)
    return decoded.normal_map


def decode_as_stored(image: RasterImage, given: ReadOptions, look: Look = find_evidence) -> Decoded:
    """Decode a picture; its stored vectors still have the signs of the file.

    Parameters
    ----------
    image : RasterImage
    given : ReadOptions
    look : callable
        How to measure the order of the channels, as `find_evidence` does.
    """
    layout = settle_layout(image, given)
    options = layout.options
    channels = find_channels(image, options)
    vectors, mixed = _vectors_of(channels)
    wanted = options.background_color
    background = find_background(channels.image, channels.xyz, wanted, channels.order, mixed.shape[2])
    covered = cover(vectors, mixed, channels, background)
    normal_map = _normal_map(image, given, layout, channels, covered, background.kind, look)
    findings = find_doubts(image, channels, background, covered, normal_map.decoding, options)
    decoding = replace(normal_map.decoding, warnings=tuple(as_warning(found) for found in findings))
    return Decoded(vectors, background, replace(normal_map, decoding=decoding), channels, findings)


def _vectors_of(channels: Channels) -> tuple[Float32, Float32]:
    """Vectors as stored, with the signs of the file, and the two or three stored components that they come from."""
    vectors = decode_map(channels.xyz, channels.coding)
    if channels.components == "xyz":
        return vectors, vectors
    pair = vectors[..., :2]
    return completed(pair, channels.components), pair


def _normal_map(
    image: RasterImage,
    given: ReadOptions,
    layout: Layout,
    channels: Channels,
    covered: Covered,
    background: str,
    look: Look,
) -> NormalMap:
    """Normalise the vectors, convert them to eye space, and record all decisions."""
    normals = unit(covered.vectors)
    swizzle_signs = signs_of(channels.asked)
    if -1 in swizzle_signs:
        apply_signs(normals, swizzle_signs, out=normals)
    make_flat(normals, covered.background if background == "flat" else covered.coverage <= 0)
    foreground = (covered.coverage >= 0.5) & ~covered.background
    seen = look(normals, foreground, covered.coverage >= 0.5, channels.coding.step)
    towards = find_directions(image, given, layout.options, seen, background)
    signs = (-1 if towards.red_left else 1, -1 if towards.green == "down" else 1, 1)
    if -1 in signs:
        apply_signs(normals, signs, out=normals)
    in_use = tuple((axis, sign) for axis, sign in enumerate(signs))
    decoding = Decoding(
        green=towards.green,
        green_from=towards.green_from,
        curl_ratio=seen.curl_ratio(((0, signs[0]), *GREEN_DOWN[1:]), ((0, signs[0]), *AS_READ[1:])),
        swizzle=format_swizzle(with_signs(channels.asked, signs[0])),
        swizzle_from=_swizzle_from(given, layout, red_left=towards.red_left),
        preset=layout.preset,
        preset_from=layout.source,
        fits=fitting_swizzles(seen, channels.asked, z_known=channels.components != "xyz"),
        outline_sign=seen.outline_sign(in_use),
        away_share=_away_share(normals, foreground, channels.components),
        curve=layout.options.curve,
        notes=image.notes,
        repeats=repeats(normals),
        zero_code=channels.zero_code,
        zero_code_from=_preset_or(channels.zero_code_from, given.zero_code, layout),
        encoding=channels.encoding,
        components=channels.components,
        components_from=_preset_or(channels.components_from, given.components, layout),
        background=background,
        background_from="found" if given.background_color == "auto" else "given",
        rim_pixels=int(np.count_nonzero(covered.rim)),
    )
    flat_background = background == "flat"
    return NormalMap(normals, covered.coverage, image.frame, foreground, image.name, decoding, flat_background)


def _swizzle_from(given: ReadOptions, layout: Layout, *, red_left: bool) -> str:
    if given.swizzle is not None:
        return "given"
    if layout.preset is not None:
        return "preset"
    return "found" if red_left else "assumed"


def _preset_or(source: str, given: str, layout: Layout) -> str:
    """The source of a value: that of a preset if only the preset gave it."""
    if source != "given" or given != "auto":
        return source
    return "found" if layout.source == "found" else "preset"


def _away_share(normals: Float32, foreground: Mask, components: str) -> float:
    """Share of the foreground with nz <= 0; never where z was computed from x and y."""
    if components == "xy":
        return 0.0
    away = int(np.count_nonzero((normals[..., 2] <= 0) & foreground))
    return away / max(1, int(np.count_nonzero(foreground)))
