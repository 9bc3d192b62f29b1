"""Smaller versions of pictures by area averaging, window by window: overviews, and the levels of pyramids."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float32, Float64
from nmaptool.core.vectors import unit
from nmaptool.io.stores.windows import grid_windows
from nmaptool.maps import codec
from nmaptool.maps.zero_code import ZERO_CODES
from nmaptool.types.picture import RasterImage
from nmaptool.types.windows import PictureStore

# pixels that are averaged at once are at most about this side squared
_SIDE_PX = 1024


def reduced_shape(rows: int, cols: int, factor: int) -> tuple[int, int]:
    """The size of a picture whose pixels are squares of ``factor`` px; those at its edges may be smaller.

    >>> reduced_shape(10, 8, 4)
    (3, 2)
    """
    return -(-rows // factor), -(-cols // factor)


@dataclass(frozen=True)
class Reducer:
    """Averages squares of pixels of one picture.

    Colours are weighted by alpha. In normal maps that nmaptool wrote, vectors are averaged and scaled to unit length;
    in pictures of heights, NaN does not count.

    Parameters
    ----------
    picture : PictureStore
    factor : int
        Side of a square in px.
    """

    picture: PictureStore
    factor: int

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the smaller picture."""
        return reduced_shape(self.picture.rows, self.picture.cols, self.factor)

    def window(self, rows: slice, cols: slice) -> NDArray[np.generic]:
        """(h, w, C): a window of the smaller picture, of the type that the picture has.

        Parameters
        ----------
        rows, cols : slice
            In the smaller picture; both ends are given.

        Raises
        ------
        InputError
            If the picture cannot be read.
        """
        count = max(1, _SIDE_PX // self.factor)
        shape = (rows.stop - rows.start, cols.stop - cols.start)
        out: NDArray[np.generic] | None = None
        for down, across in grid_windows(shape, (count, count)):
            part = self._block(
                slice(rows.start + down.start, rows.start + down.stop),
                slice(cols.start + across.start, cols.start + across.stop),
            )
            if out is None:
                out = np.empty((*shape, part.shape[2]), part.dtype)
            out[down, across] = part
        assert out is not None
        return out

    def _block(self, rows: slice, cols: slice) -> NDArray[np.generic]:
        k, picture = self.factor, self.picture
        image = picture.read(
            slice(rows.start * k, min(rows.stop * k, picture.rows)),
            slice(cols.start * k, min(cols.stop * k, picture.cols)),
        )
        return reduced(image, k)


def reduced(image: RasterImage, factor: int) -> NDArray[np.generic]:
    """(h, w, C): the means of squares of a picture's pixels, of its type; see `Reducer`."""
    if factor == 1:
        return image.pixels.astype(np.float16) if image.is_float and image.bits == 16 else image.pixels
    alpha = image.alpha
    if _is_own_map(image.attributes) and "R" in image.channels:
        return _reduced_map(image, alpha, factor)
    colors = [place for place, name in enumerate(image.channels) if name != "A"]
    values = image.pixels[..., colors].astype(np.float64)
    weights = np.ones(values.shape[:2]) if alpha is None else alpha.astype(np.float64)
    if image.is_float:
        known = np.asarray(np.isfinite(values).all(axis=2))
        values, weights = np.where(known[..., None], values, 0), np.where(known, weights, 0)
    sums = _squares(values * weights[..., None], factor)
    total = _squares(weights, factor)
    nothing = np.nan if image.is_float and alpha is None else 0.0
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(total[..., None] > 0, sums / total[..., None], nothing)
    out = np.empty((*mean.shape[:2], len(image.channels)))
    out[..., colors] = mean
    if alpha is not None:
        out[..., image.channels.index("A")] = image.max_code * total / _squares(np.ones(alpha.shape), factor)
    return _as_stored(out, image)


def _reduced_map(image: RasterImage, alpha: Float32 | None, factor: int) -> NDArray[np.generic]:
    """Means of unit vectors, as codes."""
    signed = image.is_float and image.attributes.get("encoding") == "signed"
    zero_code = image.attributes.get("zero_code", "127.5")
    coding = codec.Coding(image.max_code, zero_code if zero_code in ZERO_CODES else "127.5", signed, image.is_float)
    xyz = image.pixels[..., [image.channels.index(name) for name in "RGB"]]
    weights = np.ones(xyz.shape[:2]) if alpha is None else alpha.astype(np.float64)
    vectors = codec.decode_map(xyz, coding) * weights[..., None]
    mean = unit(_squares(vectors, factor))
    coverage = None
    if alpha is not None:
        share = _squares(weights, factor) / _squares(np.ones(weights.shape), factor)
        coverage = share.astype(np.float32)
    if image.is_float and not signed:
        mean = codec.encode_shares(mean)
    bits = 32 if image.is_float else image.bits
    codes = codec.encode_map(mean, coverage, bits, zero_code=coding.zero_code)
    return codes.astype(np.float16) if image.is_float and image.bits == 16 else codes


def _squares(values: NDArray[np.floating], factor: int) -> Float64:
    """Sums over squares of (H, W) or (H, W, C) values; the last ones may be cut off by the edge."""
    down = np.add.reduceat(values, np.arange(0, values.shape[0], factor), axis=0, dtype=np.float64)
    out: Float64 = np.add.reduceat(down, np.arange(0, values.shape[1], factor), axis=1)
    return out


def _as_stored(values: Float64, image: RasterImage) -> NDArray[np.generic]:
    """Means as numbers of the type that the picture is stored in."""
    if image.is_float:
        return values.astype(np.float16 if image.bits == 16 else np.float32)
    return np.floor(values + 0.5).clip(0, image.max_code).astype(image.pixels.dtype)


def _is_own_map(attributes: Mapping[str, str]) -> bool:
    return attributes.get("kind") == "normal"
