"""Blend a detail map with a base map."""

from __future__ import annotations

import dataclasses
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.composition.blend_vectors import blend_normals
from nmaptool.composition.edges import detail_weight
from nmaptool.composition.placement import Piece, is_uneven, map_piece
from nmaptool.core.arrays import Float32
from nmaptool.core.errors import InputError
from nmaptool.core.vectors import mean_abs_curl
from nmaptool.options import BlendOptions
from nmaptool.options.plain_values import plain_values
from nmaptool.types.composition import ComposeReport, Composition
from nmaptool.types.inputs import MaskLike, NormalsLike, as_normal_map
from nmaptool.types.layers import check_mask
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.plain_arrays import as_float32


def blend(
    base: NormalsLike,
    detail: NormalsLike,
    options: BlendOptions | None = None,
    *,
    mask: MaskLike | None = None,
    mask_name: str = "",
) -> Composition:
    """Blend a detail map with a base map of the same size.

    Parameters
    ----------
    base, detail : NormalMap or (H, W, 3) float of any type
        The detail acts in proportion to its coverage. The result has the coverage of the base.
    options : BlendOptions, optional
        Mode, strength, and whether to stretch a detail map of another size.
    mask : (H, W) bool or float in [0, 1], optional
        Factor on the strength.
    mask_name : str
        Name of the mask for messages, such as its file name.

    Returns
    -------
    Composition
        A flat detail or a strength of 0 leaves the base bit-for-bit unchanged (in the modes linear and overlay, only a
        strength of 0 does).

    Raises
    ------
    InputError
        If the sizes differ and ``options.fit`` is False, the mask has another size, or a normal of an array has no
        direction.
    UsageError
        If a value is neither a NormalMap nor an array.

    Examples
    --------
    Slopes of 0.25 and 0.5 add up to 0.75:

    >>> base, detail = np.zeros((2, 4, 4, 3))
    >>> base[...], detail[...] = (-0.25, 0, 1), (-0.5, 0, 1)
    >>> normals = nm.blend(base, detail, nm.BlendOptions(mode="pd")).normal_map.normals
    >>> round(float(-normals[0, 0, 0] / normals[0, 0, 2]), 6)
    0.75
    """
    options = options or BlendOptions()
    start = time.perf_counter()
    base, detail = as_normal_map(base, "the base"), as_normal_map(detail, "the detail map")
    warnings = _warnings(base, detail)
    detail = _of_one_size(base, detail, options.fit)
    if mask is not None:
        mask = as_float32(mask, "the mask")
        check_mask(mask, detail.name, base.frame.shape, mask_name)
    if not (detail.coverage * base.coverage).any():
        warnings += (f"{detail.name}: does not overlap {base.name}, so it changes nothing",)
    normals, strength = blend_pixels(base, detail, options, mask)
    result = dataclasses.replace(base, normals=normals, name=f"{base.name} with {detail.name}")
    shown = np.broadcast_to(np.asarray(strength, np.float32) > 0, base.frame.shape)
    defined = base.coverage >= 0.5
    layer = {"name": detail.name, "mode": options.mode, "strength": options.strength, "share": float(shown.mean())}
    report = ComposeReport(
        command="blend",
        options=plain_values(options),
        layers=(layer,),
        curl_before=mean_abs_curl(base.normals, defined),
        curl_after=mean_abs_curl(normals, defined),
        seconds={"blend": round(time.perf_counter() - start, 4)},
        warnings=warnings,
    )
    placed = np.broadcast_to(np.asarray(strength, np.float32).clip(0, 1), base.frame.shape) * base.coverage
    return Composition(result, placed, report)


def blend_pixels(
    base: NormalMap, detail: NormalMap, options: BlendOptions, mask: Float32 | None = None
) -> tuple[Float32, NDArray[Any] | float]:
    """Blend maps of the same size; each pixel depends on itself alone.

    Returns
    -------
    normals : (H, W, 3) float32
    strength : (H, W) float32 or float
        How strongly the detail acts.
    """
    strength: NDArray[Any] | float = options.strength
    if mask is not None or (detail.coverage < 1).any():
        masked = detail.coverage if mask is None else detail.coverage * mask
        strength = detail_weight(masked, detail.coverage, base.coverage) * np.float32(options.strength)
    normals = blend_normals(base.normals, detail.normals, options.mode, strength)
    return _flat_outside(normals, base), strength


def _flat_outside(normals: Float32, base: NormalMap) -> Float32:
    """Restore the normals of the base where its coverage is 0."""
    nothing = base.coverage <= 0
    if nothing.any():
        normals[nothing] = base.normals[nothing]
    return normals


def _warnings(base: NormalMap, detail: NormalMap) -> tuple[str, ...]:
    """Return warnings about effects that may be unintended: heights kept when a detail is stretched."""
    across, down = (a / b for a, b in zip(detail.frame.shape[::-1], base.frame.shape[::-1], strict=True))
    if not is_uneven((across, down)):
        return ()
    stated = (
        f"{detail.name}: is stretched unevenly and keeps its heights, so its slopes are multiplied by {across:.3g} "
        f"across and {down:.3g} down; compensate with `strength`"
    )
    return (stated,)


def _of_one_size(base: NormalMap, detail: NormalMap, fit: bool) -> NormalMap:
    """Return the detail, stretched to the size of the base if ``fit``."""
    if detail.frame.shape == base.frame.shape:
        return detail
    if not fit:
        raise InputError(
            f"{detail.name} is {detail.frame}, but {base.name} is {base.frame}; stretch it with `fit`, or place it "
            "with paste"
        )
    rows, cols = base.frame.shape
    matrix = np.array([[cols / detail.frame.cols, 0.0, 0.0], [0.0, rows / detail.frame.rows, 0.0]])
    piece = map_piece(
        Piece(detail.normals, detail.coverage, detail.foreground), matrix, (0, 0, cols, rows), name=detail.name
    )
    return dataclasses.replace(
        detail, normals=piece.normals, coverage=piece.coverage, frame=base.frame, foreground=piece.foreground
    )
