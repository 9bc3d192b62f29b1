"""Inspect a normal map before it is carved: measure it, and report each problem with a remedy."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import Any

import numpy as np

from nmaptool.core.arrays import Mask
from nmaptool.core.errors import InputError
from nmaptool.core.grid import dilated
from nmaptool.core.vectors import mean_abs_curl
from nmaptool.maps import codec
from nmaptool.maps.blocks import shows_blocks
from nmaptool.maps.channels import Channels, as_read, color_channels
from nmaptool.maps.conventions import better_swizzle
from nmaptool.maps.decoding import decode_image
from nmaptool.maps.doubts import facing_doubts
from nmaptool.maps.inspection_rules import RULES
from nmaptool.maps.layouts import LENGTH_OFF
from nmaptool.maps.zero_code import detect_zero_code, zero_and_scale
from nmaptool.options import ReadOptions
from nmaptool.types.inputs import MaskLike, RasterLike, as_raster
from nmaptool.types.inspection import Finding, Inspection
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.picture import RasterImage
from nmaptool.types.plain_arrays import as_mask, check_sizes

# an inspection tells of fewer vectors that face away than a warning does
_LEAST_AWAY = 0.002


def inspect_map(image: RasterLike, options: ReadOptions | None = None, *, mask: MaskLike | None = None) -> Inspection:
    """Measure a raw picture as a normal map and list its problems.

    Parameters
    ----------
    image : RasterImage, or (H, W, 3 or 4) uint8, uint16 or float
        Codes or floats as a file stores them, red, green and blue first, then alpha.
    options : ReadOptions, optional
        How to read it: green, zero code, components, background.
    mask : (H, W) bool or float in [0, 1], optional
        Restricts the detected foreground to where this is at least 0.5.

    Returns
    -------
    Inspection
        Measurements, detected properties, and findings, each with a remedy.

    Raises
    ------
    InputError
        If `nmaptool.decode_normal_map` refuses the picture, or the mask has another size or selects nothing.
    UsageError
        If the picture is neither a RasterImage nor an array, or an option is not accepted.

    Examples
    --------
    >>> flat = np.full((64, 64, 3), (128, 128, 255), np.uint8)
    >>> [finding.code for finding in nm.inspect_map(flat).findings]
    ['no-foreground']
    """
    options = options or ReadOptions()
    image = as_raster(image)
    decoded = decode_image(image, options)
    normal_map = decoded.normal_map
    foreground = _foreground(normal_map, mask)
    # without the repaired rim, whose short vectors are not a fault of the surface
    core = foreground & ~dilated(~foreground, 2)
    core = core if core.any() else foreground
    error = np.abs(np.linalg.norm(decoded.stored[core].astype(np.float64), axis=1) - 1)
    facts = Inspection(
        name=image.name,
        cols=image.frame.cols,
        rows=image.frame.rows,
        bits=image.bits,
        channels=image.channels,
        layer=image.layer,
        pitch_mm=image.frame.pitch_mm,
        decoding=normal_map.decoding,
        foreground_share=float(foreground.mean()),
        coverage_mean=float(normal_map.coverage.mean()),
        unit_length_error=_mean(error),
        off_length_share=_mean(error > LENGTH_OFF),
        away_share=_mean(normal_map.normals[..., 2][core] <= 0),
        neutral_bias_px=_neutral_bias_px(image, decoded.channels),
        mean_abs_curl=mean_abs_curl(normal_map.normals, core),
        outline_sign=normal_map.decoding.outline_sign,
        better_swizzle=better_swizzle(normal_map.decoding),
        premultiplied=any(found.code == "premultiplied" for found in decoded.findings),
        eight_bit_data=_is_eight_bit_data(image),
        lossy=image.lossy,
        has_blocks=image.pixels.dtype == np.uint8 and shows_blocks(color_channels(as_read(image, decoded.channels))),
        is_float=image.is_float,
        coarse=image.coarse,
        color_chunks=image.color_chunks,
    )
    return with_findings(facts, decoded.findings)


def with_findings(facts: Inspection, doubts: Iterable[Finding]) -> Inspection:
    """Measurements with all findings: doubts of the decoder, and what follows from the measurements."""
    found = [doubt for doubt in doubts if doubt.code != "facing-away" and doubt.code not in RULES]
    found += facing_doubts(facts.away_share, facts.decoding, found, _LEAST_AWAY)
    return dataclasses.replace(facts, findings=(*found, *_findings(facts)))


def _foreground(normal_map: NormalMap, mask: MaskLike | None) -> Mask:
    """(H, W) bool: the map's foreground, narrowed by the mask."""
    if mask is None:
        return normal_map.foreground
    chosen = as_mask(mask)
    check_sizes(normal_map.name, normal_map.frame.shape, {"the mask": chosen.shape})
    if not (chosen >= 0.5).any():
        raise InputError("the mask selects nothing: paint the motif white (0.5 or more) on black")
    return normal_map.foreground & (chosen >= 0.5)


def _mean(values: Any) -> float:
    return float(np.mean(values)) if np.size(values) else 0.0


def _neutral_bias_px(image: RasterImage, channels: Channels) -> float | None:
    if image.is_float:
        return None
    zero_code = detect_zero_code(color_channels(as_read(image, channels)))
    if zero_code is None:
        return None
    code, _ = zero_and_scale(zero_code, image.max_code)
    middle, scale = zero_and_scale("127.5", image.max_code)
    return (code - middle) / scale * image.frame.longer_side


def _is_eight_bit_data(image: RasterImage) -> bool:
    return image.pixels.dtype == np.uint16 and codec.narrowed(image) is not image


def _findings(facts: Inspection) -> list[Finding]:
    """All findings that follow from the measurements."""
    told = ((code, rule(facts)) for code, rule in RULES.items())
    return [Finding(code, *words) for code, words in told if words is not None]
