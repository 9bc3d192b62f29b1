"""The motif of a relief: from the map's background, from masks, from a coverage with rounded corners."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.errors import InputError
from nmaptool.options import ReliefOptions
from nmaptool.types.normal_map import NormalMap

# a mask that changes by less than this per px is a ramp to fade along, not a smoothed edge to cut at 0.5
_RAMP_PER_PX = 0.2
_FAINTEST = 0.02
# smaller slopes cannot be told from flat in 8-bit codes
_FLAT_TILT = 1.5 / 127


def motif_of(original: NormalMap, mask: Float32 | None, fading: bool) -> Mask:
    """Return the motif as (H, W) bool, from the map's background or from a mask.

    Parameters
    ----------
    original : NormalMap
    mask : (H, W) float32 or None
        Motif where 0.5 or more; with ``fading``, slow ramps of the mask belong to the motif entirely.
    fading : bool
        Whether the motif may fade into a held background.

    Raises
    ------
    InputError
        If the motif is empty.
    """
    motif, chosen = motif_in(original, mask, fading)
    if not motif.any():
        raise no_motif(original.name, original.decoding.background, None if mask is None else bool(chosen.any()))
    return motif


def motif_in(original: NormalMap, mask: Float32 | None, fading: bool) -> tuple[Mask, Mask]:
    """Return the motif as (H, W) bool, which may be empty, and what the mask selects of it and of the background."""
    if mask is None:
        return original.foreground, original.foreground
    chosen = mask >= 0.5
    if fading and min(mask.shape) > 1:
        down, across = np.gradient(mask)
        chosen |= (mask > _FAINTEST) & (np.hypot(down, across) < _RAMP_PER_PX)
    return np.asarray(chosen & (original.coverage >= 0.5)), chosen


def no_motif(name: str, background: str, selected: bool | None) -> InputError:
    """The error for an empty motif.

    Parameters
    ----------
    name, background : str
        The map, and the kind of its background.
    selected : bool or None
        Whether the mask selects anything; None without a mask.
    """
    if selected is None:
        return InputError(
            f"{name}: every pixel is background ({background}), so there is no motif; if the whole map is a "
            "surface, use `background_color='none'`"
        )
    if not selected:
        return InputError("the mask selects nothing: paint the motif white (0.5 or more) on black")
    return InputError(
        f"the mask selects only background ({background}) of {name}; check whether it is inverted or upside down"
    )


def walled(motif: Mask, walls: Float32 | None) -> Mask:
    """(H, W) bool: the part of a motif that stands with walls: where a mask is 0.5 or more, or all of it.

    Raises
    ------
    InputError
        If the mask selects nothing of the motif.
    """
    chosen: Mask = motif if walls is None else motif & (walls >= 0.5)
    if not chosen.any():
        raise InputError("the wall mask selects nothing of the motif: paint what stands with walls white")
    return chosen


def rounded_motif(coverage: Float32, options: ReliefOptions) -> Mask:
    """(H, W) bool: the motif of a coverage whose corners were rounded.

    Raises
    ------
    InputError
        If nothing is left.
    """
    motif: Mask = coverage >= 0.5
    if not motif.any():
        raise InputError(
            f"`outline_round='{options.outline_round}'`: no part of the motif is twice as wide; use a smaller radius"
        )
    return motif


def height_term_mask(original: NormalMap, motif: Mask, mask: Float32 | None) -> Mask:
    """Return where the height term acts: the motif, without the flat patches of a map with a flat background.

    In such a map, only the slopes around a flat patch inside the motif show whether it is raised or sunk. The height
    term would pull it up and fill the insides of letters.
    """
    if mask is not None or not original.flat_background:
        return motif
    sloping = motif & (np.hypot(original.normals[..., 0], original.normals[..., 1]) > _FLAT_TILT)
    return np.asarray(sloping) if sloping.any() else motif
