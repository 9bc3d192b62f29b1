"""Check the inputs of a relief: sizes, weights, motif, curved background, pitch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float32, Float64, Mask
from nmaptool.core.errors import InputError, UsageError
from nmaptool.core.grid import touching_vertices
from nmaptool.options import ReliefOptions
from nmaptool.options.kinds import LARGEST_WEIGHT
from nmaptool.reliefs.integrate import integrate
from nmaptool.types.height import DEFAULT_LONGER_SIDE_MM, Height
from nmaptool.types.inputs import NormalsLike, as_normal_map
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.plain_arrays import as_float32, as_mask, check_sizes, is_array

SAME_PITCH = 1e-3


def check_weights(maps: dict[str, Any]) -> dict[str, Float32 | None]:
    """Return weight maps as float32.

    Raises
    ------
    InputError
        If a value is not finite, too large, or negative in a map other than delta.
    """
    checked: dict[str, Float32 | None] = {}
    for name, values in maps.items():
        if values is None:
            checked[name] = None
            continue
        array = as_float32(values, f"the {name} map")
        bad = not np.isfinite(array).all() or np.abs(array).max() > LARGEST_WEIGHT
        if bad or (name != "delta" and array.min() < 0):
            sign = "" if name == "delta" else ", not negative"
            raise InputError(f"the {name} map: values must be finite{sign} and at most {LARGEST_WEIGHT:g}")
        checked[name] = array
    return checked


@dataclass(frozen=True, eq=False)
class ReliefMaps:
    """The checked inputs of a relief, all of the same size.

    Attributes
    ----------
    original : NormalMap
    detail : NormalMap or None
    mask : (H, W) float32 or None
    walls : (H, W) float32 or None
        Where the motif stands with walls.
    surface : NormalMap or Height or None
    mu, beta, delta : (H, W) float32 or None
        Factors on mu, beta and delta.
    """

    original: NormalMap
    detail: NormalMap | None
    mask: Float32 | None
    walls: Float32 | None
    surface: Any
    mu: Float32 | None
    beta: Float32 | None
    delta: Float32 | None

    @property
    def coverage(self) -> Float32:
        """(H, W) float32: share of each pixel that is motif."""
        covered = self.original.coverage
        return covered if self.mask is None else covered * self.mask


def check_maps(
    original: Any,
    detail: Any,
    mask: Any,
    surface: Any,
    mu_map: Any,
    beta_map: Any,
    delta_map: Any,
    wall_mask: Any,
) -> ReliefMaps:
    """Check and convert the inputs of a relief.

    Raises
    ------
    InputError
        If sizes differ, or a map has bad values.
    UsageError
        If an input has the wrong type, or there is a mu map without a detail map.
    """
    coverage = None if mask is None else as_mask(mask)
    original = as_normal_map(original, "the original", coverage)
    others: dict[str, tuple[int, ...]] = {}
    if detail is not None:
        detail = as_normal_map(detail, "the detail map", coverage)
        others[f"the detail map {detail.name}"] = detail.frame.shape
    elif mu_map is not None:
        raise UsageError("`mu_map`: has no effect without a detail map; give one with `detail`")
    if coverage is not None:
        others["the mask"] = coverage.shape
    walls = None if wall_mask is None else as_mask(wall_mask)
    if walls is not None:
        others["the wall mask"] = walls.shape
    if is_array(surface):
        surface = as_normal_map(surface, "the curved background")
    if isinstance(surface, NormalMap | Height):
        others["the curved background"] = surface.frame.shape
    checked = check_weights({"mu": mu_map, "beta": beta_map, "delta": delta_map})
    others |= {f"the {name} map": values.shape for name, values in checked.items() if values is not None}
    check_sizes(original.name, original.frame.shape, others)
    return ReliefMaps(original, detail, coverage, walls, surface, **checked)


def pitch_of(original: NormalsLike, options: ReliefOptions | None = None) -> tuple[float, str]:
    """Return the pitch of a relief and where it comes from.

    Parameters
    ----------
    original : NormalMap or (H, W, 3) float of any type
    options : ReliefOptions, optional
        Its width overrides the pitch of the map.

    Returns
    -------
    pitch_mm : float
        Millimetres per pixel.
    pitch_from : str
        ``given``, ``file``, or ``assumed`` for a longer side of 100 mm.

    Raises
    ------
    InputError, UsageError
        As for `nmaptool.NormalMap.from_array`, if ``original`` is not a NormalMap.

    Examples
    --------
    >>> flat = np.zeros((20, 50, 3))
    >>> flat[..., 2] = 1
    >>> nm.pitch_of(flat), nm.pitch_of(flat, nm.ReliefOptions(width=nm.length("10mm")))
    ((2.0, 'assumed'), (0.2, 'given'))
    """
    original, options = as_normal_map(original, "the original"), options or ReliefOptions()
    frame = original.frame
    if options.width is not None:
        return options.width.to_mm(1.0, frame.longer_side) / frame.cols, "given"
    if frame.pitch_mm is not None:
        return frame.pitch_mm, "file"
    return DEFAULT_LONGER_SIDE_MM / frame.longer_side, "assumed"


def base_of(surface: Any, frame_pitch_mm: float, options: ReliefOptions) -> tuple[Float64 | None, Mask | None]:
    """Return the (H+1, W+1) heights in px of the curved background and its (H, W) mask; None for other modes.

    For motifs that overhang its edge, it is continued outwards at the height of the edge.

    Raises
    ------
    UsageError
        If a curved background is missing, or given in another mode.
    InputError
        If it has holes, or another pitch.
    """
    if options.background != "surface":
        if surface is not None:
            raise UsageError(f"`surface`: needs `background='surface'`, found {options.background}")
        return None, None
    if surface is None:
        raise UsageError("`background='surface'`: needs the curved background, such as `surface='background.png'`")
    if isinstance(surface, NormalMap):
        ground = surface.coverage >= 0.5
        return _extended(integrate(surface, slope_cap=options.slope_cap, tolerance=options.tolerance), ground), ground
    if not isinstance(surface, Height):
        raise UsageError(f"the curved background must be a NormalMap or a Height, found {type(surface).__name__}")
    if not surface.domain.all():
        raise InputError("the curved background has holes; it must be defined everywhere")
    if abs(surface.pitch_mm - frame_pitch_mm) > SAME_PITCH * frame_pitch_mm:
        raise InputError(
            f"the curved background has {surface.pitch_mm:.4g} mm per pixel but the relief {frame_pitch_mm:.4g}; "
            "give both the same `width`"
        )
    return surface.z_mm / frame_pitch_mm, surface.domain


def _extended(z: Float64, ground: Mask) -> Float64:
    """Return heights in which each vertex off the ground has the height of the nearest vertex on it."""
    if ground.all():
        return z
    from scipy import ndimage  # takes long to load

    nearest = ndimage.distance_transform_edt(~touching_vertices(ground), return_distances=False, return_indices=True)
    extended: Float64 = z[tuple(nearest)]
    return extended


def radius_px_of(options: ReliefOptions, pitch_mm: float) -> float:
    """Return the radius of rounded corners in px; 0 if corners stay."""
    return 0.0 if options.outline_round is None else options.outline_round.to_mm(pitch_mm, 0) / pitch_mm
