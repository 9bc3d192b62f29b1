"""Open pictures by their names, whatever holds them: Zarr stores, folders of tiles, large TIFF files, other files."""

from __future__ import annotations

from pathlib import Path

from nmaptool.io.pictures.layer_names import Holds
from nmaptool.io.stores.names import is_zarr, split_name
from nmaptool.io.stores.tiff_files import TiffPicture, tiff_layout
from nmaptool.io.stores.tiles import TileFolder, is_tile_folder
from nmaptool.io.stores.whole_files import WholeFile
from nmaptool.io.stores.zarr_pictures import ZarrPicture
from nmaptool.io.stores.zarr_writing import create_picture, open_writable
from nmaptool.options import ReadOptions
from nmaptool.types.windows import PictureStore

__all__ = ["create_picture", "is_store", "open_picture", "open_writable"]

_LIMIT = ReadOptions().max_megapixels
# a TIFF in tiles that is larger is not decoded as a whole
_WHOLE_MEGAPIXELS = 16.0


def is_store(name: str, max_megapixels: float = _LIMIT) -> bool:
    """Whether a name is that of a picture to read by windows.

    Parameters
    ----------
    name : str
        A Zarr array or group, which is a folder or a URL, or a path that ends in .zarr; a folder of tiles; or a TIFF
        file, which counts only if it is large.
    max_megapixels : float
        A TIFF is large if it has more than this.
    """
    place, _ = split_name(name)
    if is_zarr(place) or is_tile_folder(Path(place)):
        return True
    return tiff_layout(Path(place))[0] > max_megapixels


def open_picture(
    name: str, layer: str | None = None, *, holds: Holds = "normals", max_megapixels: float = _LIMIT
) -> PictureStore:
    """Open a picture to read it by windows.

    Parameters
    ----------
    name : str
        A Zarr array or group (a folder or a URL), a folder of tiles, a TIFF file, or any other picture file, which is
        read as a whole. An array, layer or page may follow after a colon.
    layer : str, optional
        The same.
    holds : str
        What the picture is read for, "normals", "depth" or "grey": chooses between the layers of a file.
    max_megapixels : float
        Refuse larger files that are read as a whole.

    Returns
    -------
    PictureStore
        May be pickled: it is then opened again by its name.

    Raises
    ------
    InputError
        If it does not exist, is not a picture, or the extra is not installed.
    LimitError
        If a file that is read as a whole is too large.
    """
    place, _ = split_name(name)
    if is_zarr(place):
        return ZarrPicture(name, layer)
    if Path(place).is_dir():
        return TileFolder(name)
    megapixels, tiled = tiff_layout(Path(place))
    if megapixels > min(max_megapixels, _WHOLE_MEGAPIXELS if tiled else _LIMIT):
        return TiffPicture(name, layer, holds)
    return WholeFile(name, layer, holds, max_megapixels)
