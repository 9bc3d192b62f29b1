"""Read heights larger than memory by windows, and create stores for them."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import DTypeLike, NDArray

from nmaptool.core.errors import InputError
from nmaptool.io.pictures.array_files import header_of
from nmaptool.io.pictures.height_arrays import CORNER_RECORD, is_height_array
from nmaptool.io.pictures.heights import heights_in_mm
from nmaptool.io.stores.opening import open_picture
from nmaptool.io.stores.windows import bounds
from nmaptool.io.stores.zarr_writing import CHUNK, INNER, ZarrWriter, create_picture
from nmaptool.types.picture import DepthFacts
from nmaptool.types.windows import PictureStore

_PLACES = ("centers", "corners")


class HeightStore:
    """Heights in mm in a picture that is read by windows; a `nmaptool.io.stores.height_windows.HeightSource`.

    Attributes
    ----------
    name : str
    rows, cols : int
        Of the stored heights.
    pitch_mm : float
    at : str
        "centers" of the pixels, or their "corners", one more down and across.
    chunk : (int, int)
        Rows and columns that the store reads at once.
    """

    def __init__(self, picture: PictureStore, facts: DepthFacts, pitch_mm: float) -> None:
        self._picture = picture
        self._facts = facts
        self.name = picture.name
        self.rows, self.cols, self.chunk = picture.rows, picture.cols, picture.chunk
        self.pitch_mm = pitch_mm
        self.at = facts.at

    def window(self, rows: slice, cols: slice) -> NDArray[np.floating[Any]]:
        """(h, w) heights in mm, NaN outside the surface.

        Raises
        ------
        InputError
            If a chunk is missing or damaged, or heights are infinite or stored as the value for no data.
        UsageError
            If the window does not lie in the picture.
        """
        image = self._picture.read(*bounds(self.name, rows, cols, (self.rows, self.cols)))
        z_mm = heights_in_mm(image, self._facts)
        if image.alpha is not None:
            z_mm = np.where(image.alpha > 0, z_mm, np.nan)
        if np.isinf(z_mm).any():
            raise InputError(f"{self.name}: holds infinite heights; use NaN for what is not surface")
        return z_mm.astype(np.float32) if image.is_float else z_mm

    def stamp(self) -> str:
        """Return a text that changes when the stored heights change."""
        return self._picture.stamp()


class MappedHeights:
    """Heights in an .npy file, read by windows; attributes as of `HeightStore`."""

    def __init__(self, path: Path, pitch_mm: float) -> None:
        self.name = str(path)
        header = header_of(path)
        is_plain = header.kind.names is None and header.kind.kind in "fiu"
        if not is_height_array(path) or not (is_plain or header.kind == CORNER_RECORD):
            raise InputError(f"{path}: must hold one (rows, columns) array of heights in mm")
        try:
            self._values: NDArray[Any] = np.load(path, mmap_mode="r", allow_pickle=False)
        except (OSError, ValueError):
            raise InputError(f"{path}: is not a NumPy array file, or is truncated; save it again") from None
        self.rows, self.cols = (int(side) for side in self._values.shape)
        self.chunk = (min(self.rows, INNER), self.cols)
        self.pitch_mm = pitch_mm
        self.at = "centers" if is_plain else "corners"

    def window(self, rows: slice, cols: slice) -> NDArray[np.floating[Any]]:
        """(h, w) heights in mm, NaN outside the surface."""
        rows, cols = bounds(self.name, rows, cols, (self.rows, self.cols))
        if self.at == "centers":
            return np.asarray(self._values[rows, cols], np.float64)
        top, left = max(0, rows.start - 1), max(0, cols.start - 1)
        part = self._values[top : rows.stop, left : cols.stop]
        inside = np.pad(part["inside"], ((1 - (rows.start - top), 0), (1 - (cols.start - left), 0)))
        near = inside[1:, 1:] | inside[:-1, 1:] | inside[1:, :-1] | inside[:-1, :-1]
        z_mm = part["z_mm"][rows.start - top :, cols.start - left :]
        return np.asarray(np.where(near, z_mm, np.nan), np.float64)


def open_heights(name: str, *, pitch_mm: float | None = None) -> HeightStore | MappedHeights:
    """Open heights to read them by windows.

    Parameters
    ----------
    name : str
        A Zarr array, a folder of tiles or a picture file of heights in mm, or of codes with their range in mm in the
        metadata; or an .npy file.
    pitch_mm : float, optional
        Size of a pixel if the file does not state it.

    Raises
    ------
    InputError
        If it does not hold heights, or the size of a pixel is not known.
    """
    path = Path(name)
    if path.suffix.lower() == ".npy" and path.is_file():
        return MappedHeights(path, _known(name, pitch_mm))
    picture = open_picture(name, holds="depth")
    if picture.channels[0] != "Y":
        raise InputError(f"{name}: has channels {', '.join(picture.channels)}; heights have one grey channel")
    corner = picture.read(slice(0, 1), slice(0, 1))
    facts = corner.depth_facts if corner.depth_facts is not None else DepthFacts("height")
    if facts.at not in _PLACES:
        raise InputError(f"{name}: declares heights at {facts.at!r}; accepted values are {' and '.join(_PLACES)}")
    if not corner.is_float:
        heights_in_mm(corner, facts)  # refuses codes without a range
    return HeightStore(picture, facts, _known(name, picture.pitch_mm or pitch_mm))


def create_heights(
    name: str,
    rows: int,
    cols: int,
    pitch_mm: float,
    *,
    at: Literal["centers", "corners"] = "corners",
    range_mm: tuple[float, float] | None = None,
    dtype: DTypeLike = np.float32,
    chunk: int = CHUNK,
    inner: int = INNER,
    overwrite: bool = False,
) -> ZarrWriter:
    """Create a Zarr array for heights in mm, NaN outside the surface.

    Parameters
    ----------
    name : str
    rows, cols : int
        Of the heights: of the pixels for heights at centers, one more of both for heights at corners.
    pitch_mm : float
    at : str
    range_mm : (float, float), optional
        Lowest and highest height.
    dtype, chunk, inner, overwrite
        As for `nmaptool.io.stores.zarr_writing.create_picture`.

    Raises
    ------
    OutputError, InputError, UsageError
        As `nmaptool.io.stores.zarr_writing.create_picture`.
    """
    attributes = {"kind": "height", "unit": "mm", "at": at}
    if range_mm is not None:
        attributes |= {"height_min_mm": repr(range_mm[0]), "height_max_mm": repr(range_mm[1])}
    return create_picture(
        name,
        rows,
        cols,
        ("Y",),
        dtype,
        chunk=chunk,
        inner=inner,
        pitch_mm=pitch_mm,
        attributes=attributes,
        overwrite=overwrite,
    )


def _known(name: str, pitch_mm: float | None) -> float:
    if pitch_mm is None:
        raise InputError(f"{name}: does not state the size of a pixel; give `pitch_mm`")
    return pitch_mm
