"""Height fields as pictures and arrays: millimetres at pixel centres."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError, OutputError, reason_of
from nmaptool.core.grid import corner_mean
from nmaptool.io.pictures.normal_maps import options_like, read_raster
from nmaptool.io.pictures.png import check_size
from nmaptool.io.pictures.writer import write_image
from nmaptool.maps.background import alpha_is_data
from nmaptool.maps.decoding import decode_normal_map
from nmaptool.options import ReadOptions
from nmaptool.options.formats import HEIGHT_FORMATS, check_ending
from nmaptool.types.height import Height
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.picture import Frame, RasterImage


def height_attributes(height: Height) -> dict[str, str]:
    """Metadata that every height picture carries: kind, unit, pitch and the range of the surface (at pixel corners)."""
    low, high = height.range_mm
    return {
        "kind": "height",
        "unit": "mm",
        "pitch_mm": repr(height.pitch_mm),
        "height_min_mm": repr(low),
        "height_max_mm": repr(high),
    }


def write_height(height: Height, path: Path, attributes: Mapping[str, str]) -> None:
    """Write heights in mm at pixel centres, as `nmaptool.options.formats.HEIGHT_FORMATS` says.

    ``.exr`` and ``.tif`` hold float32 mm, with alpha 0 outside the surface; ``.npy`` float64 mm, NaN outside; ``.png``
    16-bit codes, 0 for the surface's lowest and 65535 for its highest corner, the range being in the file's text.

    Parameters
    ----------
    height : Height
    path : Path
    attributes : mapping
        Metadata beside that of `height_attributes`.

    Raises
    ------
    UsageError
        If the ending is not offered.
    OutputError
        If it cannot be written.
    """
    check_ending(path, HEIGHT_FORMATS, "heights")
    kind = path.suffix.lower()
    write = HEIGHT_FORMATS[kind].write or _WRITERS[kind]
    write(height, path, {**height_attributes(height), **attributes})


def _write_array(height: Height, path: Path, attributes: Mapping[str, str]) -> None:
    try:
        with path.open("wb") as stream:
            np.save(stream, height.at_pixels(), allow_pickle=False)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({reason_of(error)})") from None


def _write_codes(height: Height, path: Path, attributes: Mapping[str, str]) -> None:
    (low, high), z, inside = height.range_mm, height.at_pixels(), height.domain
    share = (z - low) / (high - low) if high > low else np.zeros_like(z)
    codes = np.floor(np.where(inside, share, 0) * 65535 + 0.5).astype(np.uint16)
    _write_grey(codes, inside.astype(np.uint16) * np.uint16(65535), path, attributes)


def _write_floats(height: Height, path: Path, attributes: Mapping[str, str]) -> None:
    inside = height.domain
    values = np.where(inside, height.at_pixels(), 0).astype(np.float32)
    _write_grey(values, inside.astype(np.float32), path, attributes)


def _write_grey(values: NDArray[Any], opaque: NDArray[Any], path: Path, attributes: Mapping[str, str]) -> None:
    if opaque.all():
        write_image(values[..., None], path, ("Y",), attributes)
    else:
        write_image(np.dstack([values, opaque]), path, ("Y", "A"), attributes)


_WRITERS = {
    ".exr": _write_floats,
    ".tif": _write_floats,
    ".tiff": _write_floats,
    ".npy": _write_array,
    ".png": _write_codes,
}


def to_vertices(centre: Float64) -> Float64:
    """(H+1, W+1) heights at corners from (H, W) at centres: means of neighbours, continued straight at the edges.

    >>> to_vertices(np.array([[0.0, 1.0], [0.0, 1.0]]))[0].tolist()
    [-0.5, 0.5, 1.5]
    """
    for axis, count in enumerate(centre.shape):
        around = [(1, 1) if i == axis else (0, 0) for i in range(2)]
        if count > 1:
            centre = np.pad(centre, around, mode="reflect", reflect_type="odd")
        else:
            centre = np.pad(centre, around, mode="edge")
    return corner_mean(centre)


def read_height(path: str | Path, pitch_mm: float | None = None, max_megapixels: float = 270.0) -> Height:
    """Read heights in mm at pixel centres, as `write_height` writes them.

    Parameters
    ----------
    path : Path
        ``.exr``, ``.tif``, ``.npy`` in mm, or a ``.png`` whose text says its range.
    pitch_mm : float, optional
        Size of a pixel where the file does not say it.
    max_megapixels : float

    Raises
    ------
    InputError
        If it cannot be read, is no height field, or holds NaN or infinite values.
    LimitError
        If it is larger than ``max_megapixels``.
    """
    path = Path(path)
    if path.suffix.lower() == ".npy":
        return _height(path, _read_npy(path, max_megapixels), pitch_mm)
    return _height_of(path, read_raster(path, ReadOptions(max_megapixels=max_megapixels)), pitch_mm)


def read_surface(
    path: str | Path, options: ReadOptions | None = None, *, like: NormalMap, pitch_mm: float
) -> NormalMap | Height:
    """Read a curved background: heights where the file holds an array or a grey picture, else a normal map.

    Parameters
    ----------
    path : str or Path
    options : ReadOptions, optional
        As for the map that lies on it; all of a background is surface, whatever its colours, but where it is
        transparent.
    like : NormalMap
        The map that lies on it: green points the same way.
    pitch_mm : float
        Size of a pixel where a file of heights does not say it.

    Raises
    ------
    InputError, LimitError
        As `read_height` and `nmaptool.read_normal_map`.
    """
    options = options or ReadOptions()
    if Path(path).suffix.lower() == ".npy":
        return read_height(path, pitch_mm, options.max_megapixels)
    image = read_raster(path, options)
    see_through = image.alpha is not None and not alpha_is_data(image)
    options = replace(options, background_color="alpha" if see_through else "none")
    if "R" not in image.channels:
        return _height_of(Path(path), image, pitch_mm)
    return decode_normal_map(image, options_like(image, options, like))


def _height_of(path: Path, image: RasterImage, pitch_mm: float | None) -> Height:
    if image.channels[0] != "Y":
        raise InputError(f"{path}: has channels {', '.join(image.channels)}; a height file has one grey channel")
    return _height(path, _in_mm(image), image.frame.pitch_mm or pitch_mm)


def _height(path: Path, centre: Float64, pitch_mm: float | None) -> Height:
    if not np.isfinite(centre).all():
        raise InputError(f"{path}: holds NaN or infinite heights; a curved background must be defined everywhere")
    frame = Frame(centre.shape[0], centre.shape[1], pitch_mm)
    return Height(to_vertices(centre), np.ones(centre.shape, bool), frame)


def _read_npy(path: Path, max_megapixels: float) -> Float64:
    not_ours = InputError(f"{path}: is not a NumPy array file, or is cut short")
    try:
        with path.open("rb") as stream:
            if not stream.read(6) == np.lib.format.MAGIC_PREFIX:
                raise not_ours
            stream.seek(0)
            version = np.lib.format.read_magic(stream)
            reader = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
            shape, _, kind = reader(stream)
            if len(shape) != 2 or kind.kind not in "fiu" or 0 in shape:
                raise InputError(f"{path}: must hold one (rows, columns) array of numbers, heights in mm")
            check_size(path, shape[1], shape[0], max_megapixels)
            stream.seek(0)
            values: NDArray[Any] = np.load(stream, allow_pickle=False)
    except InputError:
        raise
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a folder; give a file of heights") from None
    except (OSError, ValueError, EOFError):
        raise not_ours from None
    return values.astype(np.float64)


def _in_mm(image: RasterImage) -> Float64:
    values = image.pixels[..., 0].astype(np.float64)
    if image.alpha is not None:
        values[image.alpha <= 0] = np.nan
    if image.is_float:
        return values
    try:
        low, high = float(image.attributes["height_min_mm"]), float(image.attributes["height_max_mm"])
    except (KeyError, ValueError):
        raise InputError(
            f"{image.name}: does not say its height range in mm; give the heights as EXR, float TIFF or NPY in mm"
        ) from None
    return low + values / image.max_code * (high - low)
