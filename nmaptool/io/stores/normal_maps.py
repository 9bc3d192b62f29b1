"""Read normal maps larger than memory by windows."""

from __future__ import annotations

from functools import partial

import numpy as np

from nmaptool.core.errors import UsageError
from nmaptool.io.pictures.normal_maps import options_like
from nmaptool.io.stores.opening import open_picture
from nmaptool.io.stores.sampling import sample_of
from nmaptool.io.stores.windows import bounds, widened, within
from nmaptool.maps.channels import finite
from nmaptool.maps.settled import SettledReading, settle
from nmaptool.maps.windows import WINDOW_MARGIN_PX, decode_window
from nmaptool.options import ReadOptions
from nmaptool.types.normal_map import Decoding, NormalMap
from nmaptool.types.picture import Frame, RasterImage
from nmaptool.types.windows import PictureStore


class NormalMapStore:
    """A normal map that is read by windows.

    Attributes
    ----------
    name : str
    rows, cols : int
    pitch_mm : float or None
    chunk : (int, int)
        Rows and columns that the store reads at once.
    settled : SettledReading
        How it is read, with all decisions made.
    decoding : Decoding
        What was decided, and doubts about the map.
    picture : PictureStore
        The stored picture.
    """

    def __init__(self, picture: PictureStore, settled: SettledReading, decoding: Decoding) -> None:
        self.picture = picture
        self.name = picture.name
        self.rows, self.cols = picture.rows, picture.cols
        self.pitch_mm = picture.pitch_mm
        self.chunk = picture.chunk
        self.settled = settled
        self.decoding: Decoding = decoding

    def window(self, rows: slice, cols: slice) -> NormalMap:
        """Return a part of the map, decoded as the whole would be.

        Parameters
        ----------
        rows, cols : slice
            Without a step.

        Raises
        ------
        InputError
            If a chunk is missing or damaged, or holds NaN or infinity where the map is defined.
        UsageError
            If the window does not lie in the map.
        """
        shape = (self.rows, self.cols)
        wanted = bounds(self.name, rows, cols, shape)
        margin = 0 if self.settled.background_color == "none" else WINDOW_MARGIN_PX
        around = widened(wanted, margin, shape)
        image = self.picture.read(*around)
        whole = decode_window(image, self.settled, self.decoding, (around[0].start, around[1].start))
        if around == wanted:
            return whole
        place = within(wanted, around)
        coverage = np.ascontiguousarray(whole.coverage[place])
        return NormalMap(
            normals=np.ascontiguousarray(whole.normals[place]),
            coverage=coverage,
            frame=Frame(coverage.shape[0], coverage.shape[1], whole.frame.pitch_mm),
            foreground=np.ascontiguousarray(whole.foreground[place]),
            name=whole.name,
            decoding=self.decoding,
        )

    def stamp(self) -> str:
        """Return a text that changes when the stored pixels change."""
        return self.picture.stamp()


def open_normal_map(
    name: str, options: ReadOptions | None = None, like: NormalMap | NormalMapStore | None = None
) -> NormalMapStore:
    """Open a normal map to read it by windows.

    Its conventions are found in 4 x 4 windows of 512 px: along the edges, and where the map varies most.

    Parameters
    ----------
    name : str
        As for `nmaptool.io.stores.opening.open_picture`.
    options : ReadOptions, optional
    like : NormalMap or NormalMapStore, optional
        The original to which this map belongs, as for `nmaptool.read_normal_map`.

    Raises
    ------
    InputError
        If it cannot be read or is not a normal map.
    UsageError
        If the background is to be "flat", which only the whole picture shows.
    """
    options = options or ReadOptions()
    picture = open_picture(name, options.layer, max_megapixels=options.max_megapixels)
    sample, windows = sample_of(picture, partial(_refuse_gaps, options))
    settled, decoding = settle(sample, windows, options_like(sample, options, like))
    return NormalMapStore(picture, settled, decoding)


def _refuse_gaps(options: ReadOptions, image: RasterImage, first: tuple[int, int]) -> None:
    """Refuse NaN and infinity in a window of the sample, with its place in the map."""
    if image.is_float:
        three = {"R", "G", "B"} <= set(image.channels) and options.components in ("auto", "xyz")
        finite(image, image.pixels[..., : 3 if three else 2], first)


def reopen_normal_map(name: str, settled: ReadOptions, decoding: Decoding | None = None) -> NormalMapStore:
    """Open a normal map again, such as in another process, without looking for its conventions.

    Parameters
    ----------
    name : str
    settled : SettledReading
        That of a `NormalMapStore`.
    decoding : Decoding, optional
        The record for the maps that it returns.

    Raises
    ------
    InputError
        If it cannot be read.
    UsageError
        If the options are not settled.
    """
    if not isinstance(settled, SettledReading):
        raise UsageError(f"{name}: these options leave decisions open; use those of open_normal_map")
    known = Decoding(
        green=settled.green,
        green_from="given",
        swizzle=settled.swizzle or "r,g,b",
        zero_code=settled.zero_code,
        encoding=settled.encoding,
        components=settled.components,
        background=settled.background_color,
    )
    picture = open_picture(name, settled.layer, max_megapixels=settled.max_megapixels)
    return NormalMapStore(picture, settled, decoding or known)
