"""A sample of a large depth picture and its mask: windows on a regular grid."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nmaptool.core.arrays import Float32
from nmaptool.depth.settled import SampledImage
from nmaptool.io.stores.grey import GreyStore, open_grey
from nmaptool.io.stores.sampling import spread_windows
from nmaptool.types.picture import Frame
from nmaptool.types.plain_arrays import check_sizes
from nmaptool.types.windows import PictureStore


@dataclass(frozen=True, eq=False)
class DepthSample:
    """Windows of a depth picture, joined.

    Attributes
    ----------
    image : SampledImage
    mask : (h, w) float32 or None
    windows : list of (slice, slice)
        Their places in the sample.
    """

    image: SampledImage
    mask: Float32 | None
    windows: list[tuple[slice, slice]]


def opened_mask(image: str, mask: str | None, frame: Frame) -> GreyStore | None:
    """The mask, which must have the size of the picture; None if there is none."""
    if mask is None:
        return None
    opened = open_grey(mask)
    check_sizes(image, frame.shape, {"the mask": (opened.rows, opened.cols)})
    return opened


def sample_of_depths(picture: PictureStore, frame: Frame, mask: GreyStore | None) -> DepthSample:
    """Read windows that are spread over the picture and its mask."""
    windows = list(spread_windows(frame.rows, frame.cols))
    across = len({cols.start for _, cols in windows})
    parts = [picture.read(*window) for window in windows]

    def joined(arrays: Sequence[Any]) -> Any:
        rows = [np.concatenate(arrays[at : at + across], axis=1) for at in range(0, len(arrays), across)]
        return np.concatenate(rows, axis=0)

    first = parts[0]
    image = SampledImage(
        joined([part.pixels for part in parts]),
        first.channels,
        picture.name,
        first.bits,
        first.lossy,
        first.attributes,
        layer=first.layer,
        depth_facts=first.depth_facts,
        nodata=first.nodata,
        orientation=first.orientation,
        notes=first.notes,
        whole=frame,
    )
    ends_down = np.cumsum([0, *(window[0].stop - window[0].start for window in windows[::across])])
    ends_across = np.cumsum([0, *(window[1].stop - window[1].start for window in windows[:across])])
    places = [
        (slice(int(top), int(bottom)), slice(int(left), int(right)))
        for top, bottom in itertools.pairwise(ends_down)
        for left, right in itertools.pairwise(ends_across)
    ]
    shown = None if mask is None else joined([mask.window(*window) for window in windows])
    return DepthSample(image, shown, places)
