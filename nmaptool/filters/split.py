"""Split a normal map without a mesh into base and detail."""

from __future__ import annotations

import dataclasses
import time

import numpy as np

from nmaptool.core.errors import InputError, UsageError
from nmaptool.core.progress import Progress
from nmaptool.core.units import Length
from nmaptool.core.vectors import mean_abs_curls, mean_angle_deg
from nmaptool.filters.image import rolling_guidance_image
from nmaptool.filters.mixture import fit_mixture
from nmaptool.maps.detail import encode_detail
from nmaptool.maps.masks import motif_coverage
from nmaptool.options import SplitOptions
from nmaptool.options.plain_values import plain_values
from nmaptool.types.inputs import NormalsLike, as_normal_map
from nmaptool.types.layer_set import LayerReport, LayerSet
from nmaptool.types.picture import Frame

_SMALLEST_PX = 0.3


def split(
    normal_map: NormalsLike, options: SplitOptions | None = None, *, progress: Progress | None = None
) -> LayerSet:
    """Split a normal map into base and detail: the filter of the paper (Sec. 3.1) with pixels as faces.

    Parameters
    ----------
    normal_map : NormalMap or (H, W, 3) float of any type
        The map; pixels that are not covered are ignored.
    options : SplitOptions, optional
        The filter, its parameters and the detail encoding.
    progress : callable, optional
        Called with the name of the stage and the share done, 0 to 1.

    Returns
    -------
    LayerSet
        Original (the map itself), base and detail; no depth and no face numbers.

    Raises
    ------
    UsageError
        If sigma_s is in mm and the pitch of the map is unknown, sigma_s is below 0.3 px, or the map is neither a
        NormalMap nor an array.
    InputError
        If the map covers nothing, or a normal of an array has no direction.

    Examples
    --------
    >>> x = np.arange(32) + np.zeros((32, 1))
    >>> normals = np.dstack([0.3 * np.sin(x), np.zeros_like(x), np.ones_like(x)])
    >>> nm.split(normals, nm.SplitOptions(sigma_s=nm.length("3px")))
    <LayerSet map: 32 x 32 px, pitch unknown, 47% detail>
    """
    options = options or SplitOptions()
    start = time.perf_counter()
    normal_map = as_normal_map(normal_map)
    original = normal_map.normals
    # keeps the motif and a defined background from affecting each other
    coverage = motif_coverage(normal_map)
    seen = coverage > 0
    if not seen.any():
        raise InputError(f"{normal_map.name}: no pixel is covered, so there is nothing to split")
    sigma_s_px = sigma_in_px(options.sigma_s, normal_map.frame, normal_map.name)
    filtered = rolling_guidance_image(
        original,
        coverage,
        sigma_s_px=sigma_s_px,
        sigma_r=options.sigma_r,
        iterations=options.iterations,
        progress=progress,
    )
    residual = original.astype(np.float64) - filtered
    length = np.sqrt(np.einsum("ijk,ijk->ij", residual, residual))
    mixture = fit_mixture(length[seen], coverage[seen].astype(np.float64))
    is_detail = seen & (length > mixture.theta)
    replaced = is_detail if options.filter == "grnf" else seen
    base = np.where(replaced[..., None], filtered, original)
    detail = encode_detail(original, base, options.detail_encoding)
    report = LayerReport(
        options=plain_values(options),
        mixture=mixture,
        detail_share=float(coverage[is_detail].sum() / coverage.sum()),
        detail_angle_deg=mean_angle_deg(original[seen], base[seen]),
        pitch_from="file" if normal_map.frame.pitch_mm is not None else "",
        sigma_s_px=sigma_s_px,
        curl=mean_abs_curls({"original": original, "base": base, "detail": detail}, seen),
        seconds={"split": round(time.perf_counter() - start, 4)},
    )
    base_map = dataclasses.replace(normal_map, normals=base, name=f"{normal_map.name}: base")
    detail_map = dataclasses.replace(normal_map, normals=detail, name=f"{normal_map.name}: detail")
    return LayerSet(normal_map, base_map, detail_map, report)


def sigma_in_px(sigma_s: Length, frame: Frame, name: str) -> float:
    """Return the size of detail in px.

    Raises
    ------
    UsageError
        If it is in mm and the pitch is unknown, or less than 0.3 px.
    """
    if sigma_s.is_absolute and frame.pitch_mm is None:
        raise UsageError(
            f"`sigma_s='{sigma_s}'`: the size of a pixel in {name} is not known; give px or %, such as `sigma_s='1%'`"
        )
    pitch = frame.pitch_mm or 1.0
    sigma_s_px = sigma_s.to_mm(pitch, frame.longer_side) / pitch
    if sigma_s_px < _SMALLEST_PX:
        raise UsageError(f"`sigma_s='{sigma_s}'`: is only {sigma_s_px:.2g} px here; use at least {_SMALLEST_PX}px")
    return sigma_s_px
