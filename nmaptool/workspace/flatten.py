"""Flatten a workspace into one picture, for programs that do not show layers."""

from __future__ import annotations

import numpy as np

from nmaptool.core.arrays import Float32
from nmaptool.core.vectors import FLAT
from nmaptool.maps.codec import encode_shares, stored_shares
from nmaptool.types.workspace import Workspace, mask_over, overlap


def flattened(workspace: Workspace) -> Float32:
    """Paint every visible layer over those below, as an editor shows them: a preview, not a blend of vectors.

    Returns
    -------
    (H, W, 4) float32
        Codes as shares of the largest (0 to 1), and unassociated alpha; flat where there is no layer.
    """
    frame = workspace.frame
    color = np.zeros((*frame.shape, 3), np.float32)
    alpha = np.zeros(frame.shape, np.float32)
    for layer in workspace.layers:
        if not layer.shown:
            continue
        there, own = overlap(layer.left, layer.top, layer.size, frame)
        opacity = layer.opacity * float(np.prod([group.opacity for group in layer.groups]))
        over = (layer.alpha * mask_over(layer))[own] * np.float32(opacity)
        codes = stored_shares(layer.pixels[own], layer.signed)
        under = alpha[there] * (1 - over)
        total = over + under
        share = np.divide(over, total, out=np.zeros_like(over), where=total > 0)[..., None]
        color[there] = color[there] * (1 - share) + codes * share
        alpha[there] = total
    color[alpha <= 0] = encode_shares(np.array(FLAT))
    return np.dstack([color, alpha])
