"""Connected patches of masks: big ones, those that reach the edge, and small holes."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Mask

# smallest patch of an impossible colour that counts as background; smaller holes are specks
_MIN_PATCH_PIXELS = 16
_MIN_PATCH_SHARE = 2e-4
SPECK_MARGIN_PX = _MIN_PATCH_PIXELS


def without_specks(mask: Mask) -> Mask:
    """The mask with its small holes filled."""
    sizes, specks = _sized_patches(~mask)
    return np.asarray(mask | (sizes < _MIN_PATCH_PIXELS)[specks])


def large_patches(mask: Mask) -> Mask:
    """The mask without its small patches.

    Whether a pixel belongs to a small patch depends on those within ``SPECK_MARGIN_PX`` only.
    """
    sizes, labels = _sized_patches(mask)
    keep = sizes >= _MIN_PATCH_PIXELS
    keep[0] = False
    return np.asarray(keep[labels])


def _sized_patches(mask: Mask) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """Number of pixels of each patch of a mask, and labels; patch 0 is what is not in the mask, of infinite size."""
    _, labels, statistics, _ = cv2.connectedComponentsWithStats(mask.view(np.uint8), connectivity=8, ltype=cv2.CV_32S)
    sizes = statistics[:, cv2.CC_STAT_AREA].astype(np.int64)
    sizes[0] = np.iinfo(np.int64).max
    return sizes, np.asarray(labels, np.int32)


def _patches(mask: Mask) -> tuple[int, NDArray[np.int32]]:
    """Labels of the patches of a mask, 0 around them, and the count of labels."""
    count, labels = cv2.connectedComponents(mask.view(np.uint8), connectivity=8, ltype=cv2.CV_32S)
    return count, labels


def big_patches(mask: Mask) -> Mask:
    """The patches large enough to be a background."""
    least = max(_MIN_PATCH_PIXELS, _MIN_PATCH_SHARE * mask.size)
    if np.count_nonzero(mask) < least:
        return np.zeros(mask.shape, bool)
    sizes, labels = _sized_patches(mask)
    keep = sizes >= least
    keep[0] = False
    return np.asarray(keep[labels])


def edge_patches(mask: Mask, sides: int) -> Mask:
    """The patches that reach the picture's edge if one of them reaches ``sides`` sides; otherwise nothing."""
    count, labels = _patches(mask)
    reached = np.zeros(count, int)
    for side in (labels[0], labels[-1], labels[:, 0], labels[:, -1]):
        reached[np.unique(side)] += 1
    reached[0] = 0
    if reached.max(initial=0) < sides:
        return np.zeros(mask.shape, bool)
    return np.asarray((reached > 0)[labels])
