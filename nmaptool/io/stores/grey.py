"""Read masks and maps of weights larger than memory by windows, with the values of `nmaptool.read_grey`."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np

from nmaptool.core.arrays import Float32
from nmaptool.io.pictures.normal_maps import grey_channel, grey_values, only_zero_and_one
from nmaptool.io.stores.opening import open_picture
from nmaptool.io.stores.sampling import spread_windows
from nmaptool.io.stores.windows import bounds, grid_windows
from nmaptool.io.stores.zarr_pictures import ZarrPicture
from nmaptool.types.picture import RasterImage
from nmaptool.types.windows import PictureStore

_LOOK_PX = 2048


class GreyStore:
    """A grey picture that is read by windows.

    Attributes
    ----------
    name : str
    rows, cols : int
    chunk : (int, int)
        Rows and columns that the store reads at once.
    white : int
        The stored value that becomes 1.
    of_alpha : bool
        Whether the values are those of alpha, because nothing else varies.
    picture : PictureStore
    """

    def __init__(self, picture: PictureStore, white: int, *, of_alpha: bool) -> None:
        self.picture = picture
        self.name = picture.name
        self.rows, self.cols = picture.rows, picture.cols
        self.chunk = picture.chunk
        self.white = white
        self.of_alpha = of_alpha

    def window(self, rows: slice, cols: slice) -> Float32:
        """(h, w) float32: a part of the picture.

        Raises
        ------
        InputError
            If it is coloured, holds NaN or infinite values, or a chunk is missing or damaged.
        UsageError
            If the window does not lie in the picture.
        """
        image = self.picture.read(*bounds(self.name, rows, cols, (self.rows, self.cols)))
        values = grey_values(image, grey_channel(image), self.white)
        return image.alpha if self.of_alpha and image.alpha is not None else values

    def stamp(self) -> str:
        """Return a text that changes when the stored pixels change."""
        return self.picture.stamp()


def open_grey(name: str) -> GreyStore:
    """Open a mask or a map of weights to read it by windows.

    Parameters
    ----------
    name : str
        As for `nmaptool.io.stores.opening.open_picture`.

    Raises
    ------
    InputError
        As `nmaptool.read_grey`. In Zarr arrays, the codes 0 and 1 are accepted as a mask.
    """
    picture = open_picture(name, holds="grey")
    seen = _Range()
    for rows, cols in _in_order(picture):
        image = picture.read(rows, cols)
        seen.add(image)
        if seen.is_sure(image):
            return GreyStore(picture, image.max_code, of_alpha=False)
    # here everything was looked at
    white = image.max_code
    if seen.highest == 1 and not image.is_float and not image.lossy:
        if not isinstance(picture, ZarrPicture):
            raise only_zero_and_one(image)
        white = 1
    of_alpha = seen.lowest == seen.highest and seen.most_clear < seen.most_opaque
    return GreyStore(picture, white, of_alpha=of_alpha)


class _Range:
    """The range of the stored values and of alpha in what was looked at."""

    def __init__(self) -> None:
        self.lowest, self.highest, self.most_clear, self.most_opaque = np.inf, -np.inf, np.inf, -np.inf

    def add(self, image: RasterImage) -> None:
        """Look at a window."""
        grey = grey_channel(image)
        self.lowest, self.highest = min(self.lowest, float(grey.min())), max(self.highest, float(grey.max()))
        if image.alpha is not None:
            self.most_clear = min(self.most_clear, float(image.alpha.min()))
            self.most_opaque = max(self.most_opaque, float(image.alpha.max()))

    def is_sure(self, image: RasterImage) -> bool:
        """Whether nothing in the rest of the picture can change how its values are read."""
        codes_known = image.is_float or image.lossy or self.highest > 1
        return codes_known and ("A" not in image.channels or self.lowest < self.highest)


def _in_order(picture: PictureStore) -> Iterator[tuple[slice, slice]]:
    """Windows of a picture: some that are spread over it, then all."""
    rows, cols = picture.chunk
    across = max(cols, _LOOK_PX // cols * cols)
    most = min(_LOOK_PX, max(1, _LOOK_PX**2 // across))
    everything = grid_windows((picture.rows, picture.cols), (max(rows, most // rows * rows), across))
    return itertools.chain(spread_windows(picture.rows, picture.cols), everything)
