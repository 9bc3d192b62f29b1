"""The four backgrounds: which faces act, where the height term acts, which vertices are held and at what height."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nmaptool.core.arrays import Float32, Float64, Mask
from nmaptool.core.grid import touching_vertices


@dataclass(frozen=True, eq=False)
class Domain:
    """Where a relief is solved.

    Attributes
    ----------
    surface : (H, W) bool
        Faces of the finished surface.
    acting : (H, W) bool
        Faces whose normals count.
    foreground : (H, W) bool
        Faces on which the height term acts.
    held : (H+1, W+1) bool
        Vertices held at the height of the background.
    base_px : (H+1, W+1) float64 or None
        Height of the background in px, from which delta is measured; None: 0 everywhere.
    share : (H, W) float32 or None
        Share of each face that is motif; the rest is held background (soft edges). None: 1 everywhere.
    """

    surface: Mask
    acting: Mask
    foreground: Mask
    held: Mask
    base_px: Float64 | None = None
    share: Float32 | None = None


def build_domain(
    mode: str,
    foreground: Mask,
    covered: Mask,
    share: Float32 | None = None,
    base_px: Float64 | None = None,
    pulled: Mask | None = None,
    ground: Mask | None = None,
    raised: Mask | None = None,
) -> Domain:
    """Return the domain of a background mode.

    ``plane`` and ``surface`` hold every vertex that touches a background face, including those on the outline: if the
    outline were free, the flat face outside and the steep face inside would pull it below the plate and carve a groove
    around the motif. ``free`` and ``cut`` hold nothing.

    Parameters
    ----------
    mode : {"plane", "free", "cut", "surface"}
    foreground : (H, W) bool
        The motif.
    covered : (H, W) bool
        Where the map is defined.
    share : (H, W) float32, optional
        Share of each face that is motif, for ``plane`` and ``surface``: it reduces the slopes of soft edges.
    base_px : (H+1, W+1) float64, optional
        Height of the curved background, for ``surface``.
    pulled : (H, W) bool, optional
        Where the height term acts. Default: the motif.
    ground : (H, W) bool, optional
        Where the curved background is, for ``surface``. Default: everywhere.
    raised : (H, W) bool, optional
        Part of the motif that stands on its plate with walls, so that its outline is free.
    """
    rows, cols = foreground.shape
    pulled = foreground if pulled is None else pulled
    if raised is not None:
        held = touching_vertices(~foreground) & ~touching_vertices(raised)
        soft = None if share is None else np.where(raised, np.float32(1), share)
        return Domain(np.ones(foreground.shape, bool), foreground, pulled, held, None, soft)
    if mode in ("plane", "surface"):
        everywhere = np.ones(foreground.shape, bool) if ground is None else ground | foreground
        # faces with only held vertices have no effect; leaving them out keeps separate motifs separate
        return Domain(everywhere, foreground, pulled, touching_vertices(~foreground), base_px, share)
    acting = foreground if mode == "cut" else covered | foreground
    return Domain(acting, acting, pulled, np.zeros((rows + 1, cols + 1), bool), base_px)
