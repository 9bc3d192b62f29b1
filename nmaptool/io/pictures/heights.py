"""Read and write height fields in mm: at the centres of the pixels or, exactly, at their corners."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nmaptool.core.arrays import Float64
from nmaptool.core.errors import InputError
from nmaptool.depth.meaning import is_distance_layer
from nmaptool.io.pictures.height_arrays import is_height_array, read_height_array, write_centers, write_corners
from nmaptool.io.pictures.height_samples import (
    Samples,
    center_samples,
    corner_samples,
    height_of_centers,
    height_of_corners,
    lower_right_of,
)
from nmaptool.io.pictures.normal_maps import options_like, read_raster, split_layer
from nmaptool.io.pictures.writer import write_image
from nmaptool.maps.background import alpha_is_data
from nmaptool.maps.codec import encode_grey, grey_codes
from nmaptool.maps.decoding import decode_normal_map
from nmaptool.options import HeightsAt, ReadOptions
from nmaptool.options.fields import choice_of
from nmaptool.options.formats import HEIGHT_FORMATS, check_ending
from nmaptool.types.height import Height
from nmaptool.types.normal_map import NormalMap
from nmaptool.types.picture import DepthFacts, RasterImage

_PLACE = choice_of(HeightsAt)


def height_attributes(height: Height, at: HeightsAt = "centers") -> dict[str, str]:
    """Return the metadata of a height picture: kind, unit, pitch, the range of the surface (at its corners).

    A picture of heights at corners also states ``at``.
    """
    low, high = height.range_mm
    facts = {
        "kind": "height",
        "unit": "mm",
        "pitch_mm": repr(height.pitch_mm),
        "height_min_mm": repr(low),
        "height_max_mm": repr(high),
    }
    return {**facts, "at": at} if at == "corners" else facts


def write_height(height: Height, path: Path, attributes: Mapping[str, str], *, at: HeightsAt = "centers") -> None:
    """Write heights in mm at pixel centres or corners, in a format of `nmaptool.options.formats.HEIGHT_FORMATS`.

    ``.exr`` and ``.tif`` hold float32 mm, with alpha 0 outside the surface; ``.npy`` float64 mm, NaN outside; ``.png``
    16-bit codes, 0 for the surface's lowest and 65535 for its highest corner, with the range in the metadata.

    Parameters
    ----------
    height : Height
    path : Path
    attributes : mapping
        Metadata besides that of `height_attributes`.
    at : str
        "centers": a picture of H x W means of the corners, as other programs expect. "corners": the (H+1) x (W+1)
        heights themselves, and exactly which pixels are surface; reading restores both to the precision of the format.
        Alpha is 1, or 0.5 where the pixel to the corner's lower right is not surface; ``.npy`` holds records
        (``z_mm``, ``inside``) instead of a plain array.

    Raises
    ------
    UsageError
        If the extension or ``at`` is not supported.
    OutputError
        If it cannot be written.
    """
    _PLACE.read("at", at)
    check_ending(path, HEIGHT_FORMATS, "heights")
    kind = path.suffix.lower()
    everything = {**height_attributes(height, at), **attributes}
    added = HEIGHT_FORMATS[kind].write
    if added is not None:
        added(height, path, everything)
    elif kind == ".npy":
        write_corners(height, path) if at == "corners" else write_centers(height, path)
    else:
        _write_picture(height, path, everything, at)


def _write_picture(height: Height, path: Path, attributes: Mapping[str, str], at: HeightsAt) -> None:
    kind = path.suffix.lower()
    samples = corner_samples(height) if at == "corners" else center_samples(height)
    bits = 16 if kind == ".png" else 32
    values: NDArray[Any] = _codes(samples, height) if kind == ".png" else samples.z_mm.astype(np.float32)
    if samples.alpha is None:
        write_image(values[..., None], path, ("Y",), attributes)
    else:
        write_image(np.dstack([values, encode_grey(samples.alpha, bits)]), path, ("Y", "A"), attributes)


def _codes(samples: Samples, height: Height) -> NDArray[Any]:
    """16-bit codes of the samples, 0 outside the surface."""
    low, high = height.range_mm
    if high <= low:
        return np.zeros(samples.z_mm.shape, np.uint16)
    share = (samples.z_mm - low) / (high - low)
    return grey_codes(share if samples.alpha is None else np.where(samples.alpha > 0, share, 0), 16)


def read_height(
    path: str | Path, *, pitch_mm: float | None = None, max_megapixels: float = 270.0, with_gaps: bool = False
) -> Height:
    """Read heights in mm at pixel centres or corners, as `write_height` writes them.

    Parameters
    ----------
    path : Path
        ``.exr``, ``.tif`` or ``.npy`` in mm, or a ``.png`` with its range in the metadata. Unless the file states that
        its heights are at corners, they are at centres; corner heights are then means of neighbours, extrapolated
        linearly at the edges, which is exact only for planes.
    pitch_mm : float, optional
        Size of a pixel if the file does not state it.
    max_megapixels : float
    with_gaps : bool
        Pixels whose height is NaN, infinite or transparent do not belong to the surface, instead of being refused.

    Returns
    -------
    Height

    Raises
    ------
    InputError
        If it cannot be read, is not a height field, or holds NaN or infinite values; heights at centres must be
        defined everywhere unless ``with_gaps``.
    LimitError
        If it is larger than ``max_megapixels``.

    Examples
    --------
    >>> np.save("plane.npy", np.ones((4, 6)))
    >>> nm.read_height("plane.npy", pitch_mm=0.5)
    <Height 3 x 2 mm (6 x 4 px), 1 to 1 mm high>
    """
    path = Path(path)
    if path.suffix.lower() == ".npy":
        return read_height_array(path, pitch_mm, max_megapixels, with_gaps=with_gaps)
    image = read_raster(path, ReadOptions(max_megapixels=max_megapixels))
    return height_of_picture(path, image, pitch_mm, with_gaps=with_gaps)


def read_surface(
    path: str | Path, options: ReadOptions | None = None, *, like: NormalMap, pitch_mm: float
) -> NormalMap | Height:
    """Read a curved background: heights if the file holds an array or a grey picture, else a normal map.

    Parameters
    ----------
    path : str or Path
    options : ReadOptions, optional
        As for the map that lies on it; all of a background is surface, whatever its colours, except where it is
        transparent.
    like : NormalMap
        The map that lies on it; green points the same way in both.
    pitch_mm : float
        Size of a pixel if a height file does not state it.

    Returns
    -------
    NormalMap or Height

    Raises
    ------
    InputError, LimitError
        As `read_height` and `nmaptool.read_normal_map`.

    Examples
    --------
    >>> leaf = nm.read_normal_map("samples/leaf_on_roll.png")
    >>> nm.read_surface("samples/roll.png", like=leaf, pitch_mm=0.5)
    <NormalMap samples/roll.png: 224 x 224 px, pitch unknown, 100% covered>
    """
    options = options or ReadOptions()
    if Path(path).suffix.lower() == ".npy" and is_height_array(Path(path)):
        return read_height(path, pitch_mm=pitch_mm, max_megapixels=options.max_megapixels)
    image = read_raster(path, options)
    see_through = image.alpha is not None and not alpha_is_data(image)
    options = replace(options, background_color="alpha" if see_through else "none")
    if "R" not in image.channels:
        return height_of_picture(Path(path), image, pitch_mm)
    return decode_normal_map(image, options_like(image, options, like))


def height_of_picture(path: Path, image: RasterImage, pitch_mm: float | None, *, with_gaps: bool = False) -> Height:
    """Make a height field from a picture, as `read_height`.

    Raises
    ------
    InputError
    """
    if image.channels[0] != "Y":
        raise InputError(f"{path}: has channels {', '.join(image.channels)}; a height file has one grey channel")
    facts = image.depth_facts if image.depth_facts is not None else DepthFacts("height")
    named = split_layer(str(path))[0].suffix.lower() != ".npz"  # arrays called z often hold heights
    if image.depth_facts is None and named and is_distance_layer(image):
        raise InputError(
            f"{image.name}: the name of its layer says that it holds distances from the camera, not heights; make a "
            "normal map of it with nmap compose depth, or save heights in mm"
        )
    z_mm, pitch_mm = heights_in_mm(image, facts), image.frame.pitch_mm or pitch_mm
    if facts.at == "corners":
        return height_of_corners(str(path), z_mm, lower_right_of(image.alpha, z_mm.shape), pitch_mm)
    if facts.at != "centers":
        raise InputError(f"{path}: declares heights at {facts.at!r}; accepted values are {' and '.join(_PLACE.names)}")
    return height_of_centers(str(path), z_mm, image.alpha, pitch_mm, with_gaps=with_gaps)


def heights_in_mm(image: RasterImage, facts: DepthFacts) -> Float64:
    """The (h, w) stored heights in mm, regardless of alpha.

    Raises
    ------
    InputError
        If some have the value for no data, or they are codes and the file does not state their range.
    """
    values = image.pixels[..., 0].astype(np.float64)
    if image.nodata is not None and (image.pixels[..., 0] == np.float32(image.nodata)).any():
        raise InputError(
            f"{image.name}: holds the value {image.nodata:g} for no data; fill these pixels, since heights must be "
            "defined everywhere"
        )
    if image.is_float:
        return values
    low, high = facts.black_mm, facts.white_mm
    if facts.kind != "height" or low is None or high is None:
        raise InputError(
            f"{image.name}: does not state its height range in mm; export the heights as EXR, float TIFF or NPY in mm"
        )
    return low + values / image.max_code * (high - low)
