"""The coverage of a decoded picture, which depends on the kind of its background, and the repair of its rim."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nmaptool.core.arrays import Float32, Mask
from nmaptool.core.vectors import FLAT
from nmaptool.maps.background import Background
from nmaptool.maps.channels import Channels
from nmaptool.maps.codec import decode_color
from nmaptool.maps.fringe import repair_rim

# alpha up to this is background, not rim
_SEE_THROUGH = 0.02


class Covered(NamedTuple):
    """Vectors with the rim repaired, and their coverage.

    Attributes
    ----------
    vectors : (H, W, 3) float32
        Not normalised; those of the background still as stored.
    coverage : (H, W) float32
    background : (H, W) bool
    rim : (H, W) bool
        Pixels whose vector was replaced.
    """

    vectors: Float32
    coverage: Float32
    background: Mask
    rim: Mask


def cover(
    vectors: Float32, mixed: Float32, channels: Channels, background: Background, *, in_window: bool = False
) -> Covered:
    """Compute the coverage of a picture, and remove the background that anti-aliasing mixed into its rim.

    Parameters
    ----------
    vectors : (H, W, 3) float32
        As stored, in file order of channels and signs; not changed.
    mixed : (H, W, K) float32
        The stored components that anti-aliasing mixed: the vectors, or the two components they were computed from.
    channels : Channels
    background : Background
    in_window : bool
        The picture is a window of a large map, see `repair_rim`.
    """
    everywhere = np.ones(vectors.shape[:2], np.float32)
    alpha = channels.image.alpha
    if background.kind == "none" or (background.kind == "alpha" and alpha is None):
        return Covered(vectors, everywhere, background.mask, np.zeros(everywhere.shape, bool))
    if background.kind == "flat":
        return _on_flat(vectors, everywhere, background.mask)
    if background.kind == "alpha":
        assert alpha is not None
        vectors, _, rim = repair_rim(vectors, alpha <= _SEE_THROUGH, None, in_window=in_window)
        return Covered(vectors, alpha.copy(), background.mask, rim)
    # a colour that is not a normal
    assert background.codes is not None
    behind = decode_color(background.codes, channels.coding)[: mixed.shape[2]]
    vectors, coverage, rim = repair_rim(vectors, background.mask, behind, mixed=mixed, in_window=in_window)
    return Covered(vectors, coverage, background.mask, rim)


def _on_flat(vectors: Float32, everywhere: Float32, background: Mask) -> Covered:
    """A flat background is a defined part of the map; rim pixels that are mostly background become part of it."""
    flat = np.array(FLAT, np.float32)
    vectors, share, rim = repair_rim(vectors, background, flat, is_normal=True)
    background = background | (share < 0.5)
    return Covered(vectors, everywhere, background, rim)
