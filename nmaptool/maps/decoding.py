"""A raw picture to a normal map: which channels, which sign, which zero, which background; and what was decided."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.errors import InputError, UsageError
from nmaptool.core.vectors import FLAT, unit
from nmaptool.maps import background as bg
from nmaptool.maps import codec
from nmaptool.maps import fringe as rim
from nmaptool.maps.conventions import SURE_CURL_RATIO, green_evidence
from nmaptool.maps.two_channel import as_three_channels, completed, find_components, is_unsigned_pair, pair_of_channels
from nmaptool.options import ReadOptions
from nmaptool.types.inputs import RasterLike, as_raster
from nmaptool.types.normal_map import Decoding, NormalMap
from nmaptool.types.picture import RasterImage

LENGTH_OFF = 0.1
# where so many vectors are not of unit length, the picture is something else
NOT_NORMALS_SHARE = 0.5


def color_channels(image: RasterImage) -> NDArray[Any]:
    """The three colour channels as stored.

    Raises
    ------
    InputError
        If the picture has fewer than three.
    """
    if not {"R", "G", "B"} <= set(image.channels):
        two = "; if the two are x and y, say --components xy" if len(image.channels) == 2 else ""
        raise InputError(
            f"{image.name}: has {len(image.channels)} channel(s) ({', '.join(image.channels)}); "
            f"a normal map needs red, green and blue; a grey picture is a height or depth image{two}"
        )
    if image.channels[:3] == ("R", "G", "B"):
        return image.pixels[..., :3]
    return image.pixels[..., [image.channels.index(c) for c in "RGB"]]


def _check_finite(image: RasterImage, rgb: NDArray[Any]) -> NDArray[Any]:
    """Refuse NaN and infinity where the map is defined; where alpha is 0 they are nobody's business."""
    if not image.is_float:
        return rgb
    alpha = image.alpha
    if alpha is not None and not np.isfinite(alpha).all():
        raise InputError(f"{image.name}: alpha holds NaN or infinite values; write it again with alpha in 0..1")
    bad = ~np.isfinite(rgb).all(axis=-1)
    if not bad.any():
        return rgb
    if alpha is not None:
        bad &= alpha > 0
    if bad.any():
        row, col = np.argwhere(bad)[0]
        raise InputError(
            f"{image.name}: {int(bad.sum())} pixel(s) hold NaN or infinite values, the first at x={col}, y={row}; "
            "repair them or make them transparent (alpha 0)"
        )
    finite: NDArray[Any] = np.nan_to_num(rgb, nan=0.0, posinf=0.0, neginf=0.0)
    return finite


def is_unsigned_float(rgb: NDArray[Any]) -> bool:
    """Whether floats hold (n + 1)/2: none is negative and 2v - 1 is closer to unit length than v."""
    if float(rgb.min()) < -1e-3:
        return False
    # white, grey and black backgrounds say nothing
    telling = rgb[np.ptp(rgb, axis=-1) > 1e-3]
    if not telling.size:
        return False
    sample = telling[:: max(1, len(telling) // 100_000)].astype(np.float64)
    as_signed = np.abs(np.linalg.norm(sample, axis=1) - 1)
    as_unsigned = np.abs(np.linalg.norm(2 * sample - 1, axis=1) - 1)
    return bool(np.median(as_unsigned) < np.median(as_signed))


def _to_vectors(image: RasterImage, xyz: NDArray[Any], options: ReadOptions, facts: dict[str, Any]) -> Float32:
    """Codes to vectors in file order of components, noting encoding and zero code in ``facts``."""
    if image.is_float:
        unsigned = options.encoding == "unsigned" or (options.encoding == "auto" and is_unsigned_float(xyz))
        facts.update(encoding="unsigned" if unsigned else "signed", zero_code="0.5" if unsigned else "0")
        return xyz.astype(np.float32) * 2 - 1 if unsigned else xyz.astype(np.float32)
    stated = image.attributes.get("zero_code")
    found = codec.detect_zero_code(xyz) if options.zero_code == "auto" and stated not in codec.ZERO_CODES else None
    if options.zero_code != "auto":
        facts.update(zero_code=options.zero_code, zero_code_from="given")
    elif stated in codec.ZERO_CODES:
        facts.update(zero_code=stated, zero_code_from="file")
    elif found is not None:
        facts.update(zero_code=found, zero_code_from="found")
    else:
        facts.update(zero_code="127.5", zero_code_from="assumed")
    return codec.decode_codes(xyz, facts["zero_code"])


def _settle_green(image: RasterImage, options: ReadOptions, facts: dict[str, Any], ratio: float | None) -> None:
    stated = image.attributes.get("green")
    facts["curl_ratio"] = ratio
    if options.green != "auto":
        facts.update(green=options.green, green_from="given")
    elif stated in ("up", "down"):
        facts.update(green=stated, green_from="file")
    elif options.swizzle is not None:  # a swizzle already says which way y points
        facts.update(green="up", green_from="given")
    elif ratio is not None and ratio < 1 / SURE_CURL_RATIO:
        facts.update(green="down", green_from="found")
    elif ratio is not None and ratio > SURE_CURL_RATIO:
        facts.update(green="up", green_from="found")
    else:
        facts.update(green="up", green_from="assumed")


def code_step(image: RasterImage) -> float:
    """Smallest step of a normal's component that the file can hold."""
    return 1e-3 * 2**-8 if image.is_float else 2 / image.max_code


def decode_normal_map(image: RasterLike, options: ReadOptions | None = None) -> NormalMap:
    """Turn a raw picture into unit normals in eye space.

    Parameters
    ----------
    image : RasterImage, or (H, W, 2 to 4) uint8, uint16 or float
        Channels R, G, B(, A), or two where it holds x and y or octahedral codes.
    options : ReadOptions, optional
        Green, zero code, components, background; what is not said is found out.

    Returns
    -------
    NormalMap
        Its ``decoding`` says what was decided and from what.

    Raises
    ------
    InputError
        If it has too few channels, or NaN or infinity where it is defined.
    UsageError
        If the swizzle cannot be meant, or the picture is neither a RasterImage nor an array.

    Examples
    --------
    >>> codes = np.full((2, 2, 3), (128, 128, 255), np.uint8)
    >>> nm.decode_normal_map(codes, nm.ReadOptions(background_color="none")).normals[0, 0].tolist()
    [0.0, 0.0, 1.0]
    """
    image = as_raster(image)
    options = options or ReadOptions()
    swizzle = codec.parse_swizzle("r,g,b" if options.swizzle is None else options.swizzle)
    facts: dict[str, Any] = {"swizzle": codec.format_swizzle(swizzle), "warnings": ()}
    if options.encoding != "signed":
        image = codec.narrowed(image)
    order = tuple(channel for channel, _ in swizzle)
    facts["components"], facts["components_from"] = find_components(image, options.components, order)
    if facts["components"] == "xy" and swizzle[2][1] < 0:
        raise UsageError(f"--swizzle {options.swizzle!r}: z is made from x and y and points up; give it no minus sign")
    image, options = _with_blue(image, order, facts["components"], options)
    xyz = _check_finite(image, color_channels(image))
    if order != (0, 1, 2):
        xyz = xyz[..., list(order)]
    stored = vectors = _to_vectors(image, xyz, options, facts)
    if facts["components"] != "xyz":
        stored = stored[..., :2]
        vectors = completed(stored, facts["components"])
    found = bg.find_background(image, xyz, options.background_color, order, stored.shape[2])
    facts.update(background=found.kind, background_from="found" if options.background_color == "auto" else "given")
    alpha = image.alpha
    if options.background_color not in ("auto", "none") and not found.mask.any():
        facts["warnings"] += (f"no background is {options.background_color}: every pixel is taken for surface",)
    if found.warning is not None:
        facts["warnings"] += (found.warning,)
    if alpha is not None and options.background_color == "auto" and bg.alpha_is_data(image):
        facts["warnings"] += ("alpha looks like data (a height or gloss channel), not coverage: ignored",)
    vectors, coverage, outside = _cover(vectors, stored, found, alpha, facts, _decode_like(image, facts))
    off = off_length_share(vectors, outside)
    if off >= NOT_NORMALS_SHARE:
        facts["warnings"] += (f"does not look like a normal map: {off:.0%} of its vectors are not of unit length",)
    normals = unit(vectors)
    for axis, (_, sign) in enumerate(swizzle):
        if sign < 0:
            normals[..., axis] = -normals[..., axis] + np.float32(0)  # + 0: flat gives 0, not -0
    normals[coverage <= 0] = FLAT
    foreground = (coverage >= 0.5) & ~outside
    _settle_green(image, options, facts, green_evidence(normals, foreground, code_step(image)))
    if facts["green"] == "down":
        normals[..., 1] = -normals[..., 1] + np.float32(0)
    return NormalMap(normals, coverage, image.frame, foreground, image.name, Decoding(**facts))


def off_length_share(vectors: Float32, outside: Mask) -> float:
    """Share of (H, W, 3) stored vectors not ``outside`` whose length is more than 0.1 off 1; a sample is enough."""
    inside = np.flatnonzero(~outside)
    sample = vectors.reshape(-1, 3)[inside[:: max(1, len(inside) // 100_000)]].astype(np.float64)
    return float((np.abs(np.linalg.norm(sample, axis=1) - 1) > LENGTH_OFF).mean()) if len(sample) else 0.0


def raw_vectors(image: RasterImage, decoding: Decoding) -> Float32:
    """(H, W, 3) float32 stored vectors by a decoding already settled, neither normalised nor repaired."""
    if decoding.encoding != "signed":
        image = codec.narrowed(image)
    xyz = color_channels(in_three_channels(image, decoding))[..., list(_order(decoding))]
    if image.is_float:
        vectors: Float32 = np.nan_to_num(xyz, nan=0.0, posinf=0.0, neginf=0.0)
        vectors = vectors * 2 - 1 if decoding.encoding == "unsigned" else vectors
    else:
        vectors = codec.decode_codes(xyz, decoding.zero_code)
    return vectors if decoding.components == "xyz" else completed(vectors[..., :2], decoding.components)


def _order(decoding: Decoding) -> tuple[int, ...]:
    return tuple(channel for channel, _ in codec.parse_swizzle(decoding.swizzle))


def in_three_channels(image: RasterImage, decoding: Decoding) -> RasterImage:
    """A picture of two components with the blue that one of three would have, others as they are."""
    if decoding.components == "xyz":
        return image
    return as_three_channels(image, decoding.components, _order(decoding), decoding.encoding)


def _with_blue(
    image: RasterImage, order: tuple[int, ...], components: str, options: ReadOptions
) -> tuple[RasterImage, ReadOptions]:
    """A picture of two components as one of three, and options that say how its floats are to be read."""
    if components == "xyz":
        return image, options
    encoding = options.encoding
    if image.is_float and encoding == "auto":
        encoding = "unsigned" if is_unsigned_pair(pair_of_channels(image, order)) else "signed"
    image = as_three_channels(image, components, order, encoding)
    return image, replace(options, encoding=encoding)


def _decode_like(image: RasterImage, facts: Mapping[str, Any]) -> Any:
    """One stored colour to the vector that this file's decoding gives it."""

    def decode(codes: tuple[float, ...]) -> Float32:
        if image.is_float:
            vector = np.array(codes, np.float32)
            return vector * 2 - 1 if facts["encoding"] == "unsigned" else vector
        zero, scale = codec.zero_and_scale(facts["zero_code"], image.max_code)
        return ((np.array(codes) - zero) / scale).astype(np.float32)

    return decode


def _cover(
    vectors: Float32, stored: Float32, found: bg.Background, alpha: Float32 | None, facts: dict[str, Any], decode: Any
) -> tuple[Float32, Float32, Mask]:
    """Vectors with the rim repaired, coverage by the kind of background, and where it is background in the end."""
    everywhere = np.ones(vectors.shape[:2], np.float32)
    if found.kind == "none":
        return vectors, everywhere, found.mask
    if found.kind == "flat":  # it is a defined part of the map; a rim that is mostly background joins it
        flat = np.array(FLAT, np.float32)
        vectors, share, facts["rim_pixels"] = rim.repair_rim(vectors, found.mask, flat, is_normal=True)
        outside = found.mask | (share < 0.5)
        return np.where(outside[..., None], flat, vectors), everywhere, outside
    if found.kind == "alpha":
        if alpha is None:
            return vectors, everywhere, found.mask
        vectors, _, facts["rim_pixels"] = rim.repair_rim(vectors, alpha <= 0.02, None)
        return vectors, alpha.copy(), found.mask
    assert found.codes is not None
    behind = decode(found.codes)[: stored.shape[2]]
    vectors, coverage, facts["rim_pixels"] = rim.repair_rim(vectors, found.mask, behind, mixed=stored)
    return vectors, coverage, found.mask
